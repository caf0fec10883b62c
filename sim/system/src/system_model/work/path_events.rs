//! Work of a path before units, array and the GPU's cache are known: what is rendered once.

use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_base::ssim::ssim;
use potamoi_cycles::batch::BatchEvents;
use potamoi_formats::config::Config;
use potamoi_scene::{Scene, SceneError};
use potamoi_warp::{
    Chain, Counts, Frame, Plan, PlanOptions, ReferenceFrom, Renderer as _, Sequence, WarpError,
    Warper, half_resolution,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::frame::FrameEvents;
use super::path::{Classes, PathError, PathOptions, PathParts, PathWork, Quality, TargetWork};

/// Frames counted in parallel; their pictures are in memory.
const SIDE_BY_SIDE: usize = 8;

/// Work of a path, with vector unit, array and reads left open, and the pixels of its targets that
/// are rendered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct PathEvents {
    pub(super) path: PathWork<BatchEvents>,
    pub(super) targets: Vec<PixelRuns>,
    pub(super) chained: Vec<PixelRuns>,
}

/// Pixels of a mask: lengths of runs, of pixels that are not in it and that are, by turns. Empty
/// where no pixel is.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PixelRuns(Vec<u32>);

impl PixelRuns {
    fn of(mask: &Mask, pixels: usize) -> Self {
        let (mut runs, mut is_in, mut length) = (vec![], false, 0);
        for pixel in 0..pixels {
            if mask.has(pixel) != is_in {
                runs.push(length);
                (is_in, length) = (!is_in, 0);
            }
            length += 1;
        }
        runs.push(length);
        Self(runs)
    }

    /// The mask of a picture of this size.
    pub(super) fn mask(&self, size: [u32; 2]) -> Mask {
        let mut has = vec![];
        for (turn, length) in self.0.iter().enumerate() {
            has.extend(std::iter::repeat_n(turn % 2 == 1, *length as usize));
        }
        Mask::new(size, |pixel| has.get(pixel).copied().unwrap_or(false))
    }
}

/// A target with its rendered pixels.
type Target = (TargetWork<BatchEvents>, PixelRuns);

/// Targets with their rendered pixels.
#[derive(Default)]
struct Targets {
    works: Vec<TargetWork<BatchEvents>>,
    pixels: Vec<PixelRuns>,
}

pub(super) fn seen_by(scene: &Scene, camera: &Camera) -> Scene {
    let mut scene = scene.clone();
    scene.set_camera(*camera);
    scene
}

pub(super) fn plan(path: &[Camera], options: &PathOptions) -> Result<Plan, WarpError> {
    let plan = PlanOptions {
        window: options.window,
        reference: ReferenceFrom::Predicted,
        lead: None,
    };
    Plan::new(path, &plan)
}

/// Cameras of the references, in full and then, where they are counted, at half the resolution.
pub(super) fn whole_and_half(plan: &Plan, parts: PathParts) -> Vec<Camera> {
    let whole = plan.references.iter().map(|task| task.camera);
    let small = |of: Camera| of.resized(of.width.div_ceil(2), of.height.div_ceil(2));
    match parts {
        PathParts::All => whole.clone().chain(whole.map(small)).collect(),
        PathParts::FullFrames => whole.collect(),
    }
}

/// Error sums of one comparison over frames.
#[derive(Default)]
struct GatherSums {
    squared: Option<f64>,
    similar: Option<f64>,
}

impl GatherSums {
    fn add(&mut self, shown: &Picture, other: &Picture) {
        let error = shown.mean_squared_error(other, |_| true).unwrap_or(0.0);
        *self.squared.get_or_insert(0.0) += error;
        if let Some(similar) = ssim(shown, other, |_| true) {
            *self.similar.get_or_insert(0.0) += similar;
        }
    }

    fn means(&self, frames: u32) -> [Option<f64>; 2] {
        let of = |sum: Option<f64>| Some(sum? / f64::from(frames));
        let db = of(self.squared).filter(|mse| *mse > 0.0);
        [db.map(|mse| -10.0 * mse.log10()), of(self.similar)]
    }
}

/// Error sums against model and ground truth.
#[derive(Default)]
struct Errors {
    model: GatherSums,
    truth: GatherSums,
    frames: u32,
}

impl Errors {
    fn add(&mut self, shown: &Picture, model: &Picture, truth: Option<&Picture>) {
        self.model.add(shown, model);
        if let Some(truth) = truth {
            self.truth.add(shown, truth);
        }
        self.frames += 1;
    }

    fn quality(&self) -> Quality {
        let [full_db, full_ssim] = self.model.means(self.frames);
        let [truth_db, truth_ssim] = self.truth.means(self.frames);
        Quality {
            full_db,
            truth_db,
            full_ssim,
            truth_ssim,
        }
    }
}

/// Counts the frames of a scene.
struct Counter<'a> {
    scene: Scene,
    config: &'a Config,
}

impl Counter<'_> {
    fn frame(&self, camera: &Camera, only: Option<&Mask>) -> Result<FrameEvents, SceneError> {
        FrameEvents::of(&seen_by(&self.scene, camera), self.config, only)
    }

    fn target(&self, camera: &Camera, frame: &Frame) -> Result<Target, SceneError> {
        let classes = &frame.target.classes;
        let counts = Counts::of(classes, |_| true);
        let mask = Mask::new([camera.width, camera.height], |i| classes[i].is_rendered());
        // A frame that is its reference is counted there.
        let is_rendered = mask.count() > 0 && frame.reference.is_some();
        let work = TargetWork {
            reference: frame.reference,
            classes: Classes {
                warped: counts.warped,
                void: counts.void,
                rendered: counts.total() - counts.warped - counts.void,
            },
            work: match is_rendered {
                true => Some(self.frame(camera, Some(&mask))?),
                false => None,
            },
        };
        let pixels = match is_rendered {
            true => PixelRuns::of(&mask, classes.len()),
            false => PixelRuns::default(),
        };
        Ok((work, pixels))
    }

    /// Counts full frames, some in parallel.
    fn frames(
        &self,
        cameras: &[Camera],
        step: &(dyn Fn() + Sync),
    ) -> Result<Vec<FrameEvents>, SceneError> {
        let mut all = vec![];
        for cameras in cameras.chunks(SIDE_BY_SIDE) {
            let counted = cameras.par_iter().map(|camera| {
                let work = self.frame(camera, None);
                step();
                work
            });
            for work in counted.collect::<Vec<_>>() {
                all.push(work?);
            }
        }
        Ok(all)
    }

    /// Counts the frames of a warped path as they are made, and measures their quality.
    fn targets(
        &self,
        frames: &mut dyn Iterator<Item = Result<Frame, WarpError>>,
        path: &[Camera],
        shown: &Shown,
        step: &(dyn Fn() + Sync),
    ) -> Result<(Targets, Quality), PathError> {
        let (mut all, mut errors) = (Targets::default(), Errors::default());
        loop {
            let some: Result<Vec<Frame>, _> = (&mut *frames).take(SIDE_BY_SIDE).collect();
            let some = some?;
            if some.is_empty() {
                return Ok((all, errors.quality()));
            }
            let counted = some.par_iter().map(|frame| {
                let work = self.target(&path[frame.number], frame);
                step();
                work
            });
            for (frame, work) in some.iter().zip(counted.collect::<Vec<_>>()) {
                let (work, pixels) = work?;
                all.works.push(work);
                all.pixels.push(pixels);
                let (model, truth) = (&shown.models[frame.number], &shown.truths[frame.number]);
                errors.add(&frame.target.shaded.picture, model, truth.as_ref());
            }
        }
    }
}

/// Pictures that a path's frames are compared with.
struct Shown {
    /// The model's.
    models: Vec<Picture>,
    /// Ground truth, where it is known.
    truths: Vec<Option<Picture>>,
    /// Errors of the model's full frames, and of those at half the resolution.
    full: Errors,
    halved: Errors,
}

impl Shown {
    fn of(
        counter: &Counter<'_>,
        path: &[Camera],
        step: &(dyn Fn() + Sync),
    ) -> Result<Self, PathError> {
        let scene = &counter.scene;
        let mut own = Self {
            models: vec![],
            truths: vec![],
            full: Errors::default(),
            halved: Errors::default(),
        };
        for camera in path {
            let model = scene.shade(camera, None)?.picture;
            let truth = match scene.analytic() {
                Some(_) => Some(seen_by(scene, camera).render_truth()?.picture),
                None => None,
            };
            own.full.add(&model, &model, truth.as_ref());
            let half = half_resolution(scene, camera)?;
            own.halved.add(&half, &model, truth.as_ref());
            own.models.push(model);
            own.truths.push(truth);
            step();
        }
        Ok(own)
    }
}

impl PathEvents {
    /// Renders a path and counts its events. `step` is called after each frame.
    ///
    /// # Errors
    /// A scene, a path or a configuration that does not fit.
    pub(super) fn count(
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        step: &(dyn Fn() + Sync),
    ) -> Result<Self, PathError> {
        let path = scene.path(options.fps, options.frames)?;
        let Some(first) = path.first() else {
            return Err(PathError::NoFrames);
        };
        let plan = plan(&path, options)?;
        let rule = options.rule(scene);
        let warper = Warper {
            renderer: scene,
            geometry: None,
            rule,
        };
        let counter = Counter {
            scene: scene.clone(),
            config,
        };

        let cameras = whole_and_half(&plan, options.parts);
        if options.parts == PathParts::FullFrames {
            let references = counter.frames(&cameras, step)?;
            return Ok(Self::of_full_frames(
                scene, options, &path, &plan, references,
            ));
        }
        let shown = Shown::of(&counter, &path, step)?;
        let mut references = counter.frames(&cameras, step)?;
        let halves = references.split_off(plan.references.len());
        let warped = &mut Sequence::new(warper, &path, &plan, &[]);
        let (targets, warped_quality) = counter.targets(warped, &path, &shown, step)?;
        let chain = &mut Chain::new(warper, &path, options.window);
        let (chained, chained_quality) = counter.targets(chain, &path, &shown, step)?;
        let path = PathWork {
            scene: scene.name().to_owned(),
            algorithm: scene.model().algorithm().to_owned(),
            size: [first.width, first.height],
            options: *options,
            references,
            reference_frames: (plan.references.iter())
                .map(|task| (task.target, task.known))
                .collect(),
            targets: targets.works,
            chained: chained.works,
            halves,
            full_quality: shown.full.quality(),
            warped_quality,
            chained_quality,
            half_quality: shown.halved.quality(),
        };
        Ok(Self {
            path,
            targets: targets.pixels,
            chained: chained.pixels,
        })
    }

    /// A path of full frames: each is rendered whole, with the work of its reference.
    fn of_full_frames(
        scene: &Scene,
        options: &PathOptions,
        path: &[Camera],
        plan: &Plan,
        references: Vec<FrameEvents>,
    ) -> Self {
        let size = path.first().map_or([0, 0], |own| [own.width, own.height]);
        let whole = TargetWork {
            reference: None,
            classes: Classes {
                rendered: u64::from(size[0]) * u64::from(size[1]),
                ..Classes::default()
            },
            work: None,
        };
        let path = PathWork {
            scene: scene.name().to_owned(),
            algorithm: scene.model().algorithm().to_owned(),
            size,
            options: *options,
            references,
            reference_frames: (plan.references.iter())
                .map(|task| (task.target, task.known))
                .collect(),
            targets: vec![whole; path.len()],
            chained: vec![],
            halves: vec![],
            full_quality: Quality::default(),
            warped_quality: Quality::default(),
            chained_quality: Quality::default(),
            half_quality: Quality::default(),
        };
        Self {
            targets: vec![PixelRuns::default(); path.targets.len()],
            chained: vec![],
            path,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn runs_are_their_mask(pixels in prop::collection::vec(any::<bool>(), 12)) {
            let mask = Mask::new([4, 3], |i| pixels[i]);
            let again = PixelRuns::of(&mask, 12).mask([4, 3]);
            prop_assert!((0..12).all(|i| again.has(i) == pixels[i]));
        }
    }
}
