//! Work of a camera path: frames in full, warped from references, warped from one another, and at
//! half the resolution.

use potamoi_base::camera::Camera;
use potamoi_base::effects::Effect;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_base::ssim::ssim;
use potamoi_formats::config::Config;
use potamoi_scene::{Scene, SceneError};
use potamoi_warp::{
    Chain, Counts, Frame, Plan, PlanOptions, Profile, ReferenceFrom, Renderer as _, Rule, Sequence,
    WarpError, Warper, half_resolution,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::frame::FrameWork;
use potamoi_cycles::mac_array::MacArray;

/// Frames counted in parallel; their pictures are in memory.
const SIDE_BY_SIDE: usize = 8;

/// Why a path could not be counted.
#[derive(Debug, Error)]
pub enum PathError {
    /// The scene cannot be rendered.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Its frames cannot be warped.
    #[error(transparent)]
    Warp(#[from] WarpError),
    /// The path has no frames.
    #[error("frames is 0: expected a path of 1 or more frames")]
    NoFrames,
}

/// Options of a counted path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PathOptions {
    /// Frames of the path.
    pub frames: u32,
    /// Frames a second on the scene's built-in path.
    pub fps: f64,
    /// Window: targets of a reference.
    pub window: u32,
    /// Largest angle between the rays of reference and target at a point, in degrees; `None`: no
    /// limit.
    pub phi: Option<f64>,
    /// Rules that classify pixels as warped or rendered.
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub profile: Profile,
    /// Rows and columns of the MAC array.
    pub array: [u64; 2],
    /// Whether each unit of the array holds a second operand.
    pub is_double_buffered: bool,
    /// Bytes of the GPU's cache.
    pub cache: u32,
}

impl PathOptions {
    /// The rule that classifies a target's pixels.
    pub(super) fn rule(&self, scene: &Scene) -> Rule {
        Rule {
            phi: self.phi.map(f64::to_radians),
            warps_still: scene.choices().forces(Effect::Warping),
            ..self.profile.rule()
        }
    }
}

/// Pixels of a target by origin.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Classes {
    /// Warped from the reference.
    pub warped: u64,
    /// Background.
    pub void: u64,
    /// Rendered.
    pub rendered: u64,
}

impl Classes {
    /// Pixels in all.
    #[must_use]
    pub const fn pixels(&self) -> u64 {
        self.warped + self.void + self.rendered
    }
}

/// A target frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TargetWork {
    /// The reference that it is warped from; `None` where it shows a reference.
    pub reference: Option<usize>,
    /// Its pixels.
    pub classes: Classes,
    /// Work of rendering the remaining pixels; `None` where nothing is rendered.
    pub work: Option<FrameWork>,
}

/// Quality of a path's frames. PSNR in dB, from the mean squared error over all frames, peak 1;
/// `None` where they are equal. SSIM, as mean over frames; `None` for frames smaller than 11 x 11
/// pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// PSNR against the model's own full frames.
    pub model_db: Option<f64>,
    /// PSNR against the ground truth that the model was sampled from, where it is known.
    pub truth_db: Option<f64>,
    /// SSIM against the model's own full frames.
    #[serde(default)]
    pub model_ssim: Option<f64>,
    /// SSIM against the ground truth, where it is known.
    #[serde(default)]
    pub truth_ssim: Option<f64>,
}

/// Work of a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathWork {
    /// The scene.
    pub scene: String,
    /// Name of the algorithm.
    pub algorithm: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Options it was counted with.
    pub options: PathOptions,
    /// Full frames, at the poses of references.
    pub references: Vec<FrameWork>,
    /// For each reference the frame that shows it, if any, and the frame at whose time its pose is
    /// known.
    pub reference_frames: Vec<(Option<usize>, usize)>,
    /// Frames warped from references (SpaRW), one for each frame of the path.
    pub targets: Vec<TargetWork>,
    /// Frames warped from the frame before; the first of each window is rendered in full (Temp-N).
    pub chained: Vec<TargetWork>,
    /// Frames at half width and height (DS-2), at the poses of references.
    pub halves: Vec<FrameWork>,
    /// Quality of full frames.
    pub full_quality: Quality,
    /// Quality of frames warped from references.
    pub warped_quality: Quality,
    /// Quality of frames warped from one another.
    pub chained_quality: Quality,
    /// Quality of frames at half the resolution.
    pub half_quality: Quality,
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
        let [model_db, model_ssim] = self.model.means(self.frames);
        let [truth_db, truth_ssim] = self.truth.means(self.frames);
        Quality {
            model_db,
            truth_db,
            model_ssim,
            truth_ssim,
        }
    }
}

/// Counts the frames of a scene.
struct Counter<'a> {
    scene: Scene,
    config: &'a Config,
    array: MacArray,
    cache: u32,
}

impl Counter<'_> {
    fn seen_by(&self, camera: &Camera) -> Scene {
        let mut scene = self.scene.clone();
        scene.set_camera(*camera);
        scene
    }

    fn frame(&self, camera: &Camera, only: Option<&Mask>) -> Result<FrameWork, SceneError> {
        let scene = self.seen_by(camera);
        FrameWork::count(&scene, self.config, self.array, self.cache, only)
    }

    fn target(&self, camera: &Camera, frame: &Frame) -> Result<TargetWork, SceneError> {
        let classes = &frame.target.classes;
        let counts = Counts::of(classes, |_| true);
        let mask = Mask::new([camera.width, camera.height], |i| classes[i].is_rendered());
        // A frame that is its reference is counted there.
        let is_rendered = mask.count() > 0 && frame.reference.is_some();
        Ok(TargetWork {
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
        })
    }

    /// Counts full frames, some in parallel.
    fn frames(
        &self,
        cameras: &[Camera],
        step: &(dyn Fn() + Sync),
    ) -> Result<Vec<FrameWork>, SceneError> {
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
    ) -> Result<(Vec<TargetWork>, Quality), PathError> {
        let (mut all, mut errors) = (vec![], Errors::default());
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
                all.push(work?);
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
                Some(_) => Some(counter.seen_by(camera).render_truth()?.picture),
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

impl PathWork {
    /// The full frame that stands for a frame of the path: that of its reference.
    ///
    /// # Panics
    /// Never: a counted path has a reference.
    #[must_use]
    pub fn full(&self, number: usize) -> &FrameWork {
        self.standing_for(&self.references, number)
    }

    /// The half-resolution frame that stands for a frame of the path.
    ///
    /// # Panics
    /// Never: a counted path has a reference.
    #[must_use]
    pub fn half(&self, number: usize) -> &FrameWork {
        self.standing_for(&self.halves, number)
    }

    fn standing_for<'a>(&self, works: &'a [FrameWork], number: usize) -> &'a FrameWork {
        let window = self.options.window.max(1) as usize;
        &works[(number / window).min(works.len() - 1)]
    }

    /// Steps that [`PathWork::count`] reports.
    #[must_use]
    pub fn steps(options: &PathOptions) -> u64 {
        3 * u64::from(options.frames)
            + 2 * u64::from(options.frames.div_ceil(options.window.max(1)))
    }

    /// Renders and counts a path. `step` is called after each frame.
    ///
    /// # Errors
    /// A scene, a path or a configuration that does not fit.
    pub fn count(
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        step: &(dyn Fn() + Sync),
    ) -> Result<Self, PathError> {
        let path = scene.path(options.fps, options.frames)?;
        let Some(first) = path.first() else {
            return Err(PathError::NoFrames);
        };
        let plan = Plan::new(
            &path,
            &PlanOptions {
                window: options.window,
                reference: ReferenceFrom::Predicted,
                lead: None,
            },
        )?;
        let rule = options.rule(scene);
        let warper = Warper {
            renderer: scene,
            geometry: None,
            rule,
        };
        let [rows, columns] = options.array;
        let counter = Counter {
            scene: scene.clone(),
            config,
            array: MacArray {
                rows,
                columns,
                is_double_buffered: options.is_double_buffered,
                ..MacArray::PAPER
            },
            cache: options.cache,
        };

        let shown = Shown::of(&counter, &path, step)?;
        let whole = plan.references.iter().map(|task| task.camera);
        let small = |of: Camera| of.resized(of.width.div_ceil(2), of.height.div_ceil(2));
        let cameras: Vec<Camera> = whole.clone().chain(whole.map(small)).collect();
        let mut references = counter.frames(&cameras, step)?;
        let halves = references.split_off(plan.references.len());
        let warped = &mut Sequence::new(warper, &path, &plan, &[]);
        let (targets, warped_quality) = counter.targets(warped, &path, &shown, step)?;
        let chain = &mut Chain::new(warper, &path, options.window);
        let (chained, chained_quality) = counter.targets(chain, &path, &shown, step)?;
        Ok(Self {
            scene: scene.name().to_owned(),
            algorithm: scene.model().algorithm().to_owned(),
            size: [first.width, first.height],
            options: *options,
            references,
            reference_frames: (plan.references.iter())
                .map(|task| (task.target, task.known))
                .collect(),
            targets,
            chained,
            halves,
            full_quality: shown.full.quality(),
            warped_quality,
            chained_quality,
            half_quality: shown.halved.quality(),
        })
    }
}
