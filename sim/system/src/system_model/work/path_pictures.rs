//! Pictures of a path in floating point: which pixels of warped frames are rendered, and how near frames
//! are to the model and to the ground truth. They depend on the scene and on the options of the path, and on
//! no configuration.

use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_base::ssim::ssim;
use potamoi_scene::Scene;
use potamoi_warp::{
    Chain, Counts, Frame, Renderer as _, Sequence, WarpError, Warper, half_resolution,
};
use serde::{Deserialize, Serialize};

use super::path::{Classes, PathError, PathOptions, PathParts, Quality};
use super::path_cameras::{plan, seen_by};
use super::pixel_runs::PixelRuns;

/// What the pictures of a path show.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PathPictures {
    /// Quality of frames in full, and at half the resolution.
    pub(super) full: Quality,
    pub(super) half: Quality,
    /// Frames warped from references, and from one another.
    pub(super) warped: WarpedPath,
    pub(super) chained: WarpedPath,
}

/// The frames of a warped path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct WarpedPath {
    /// One for each frame of the path.
    pub(super) targets: Vec<TargetPixels>,
    pub(super) quality: Quality,
}

/// The pixels of a warped frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct TargetPixels {
    /// The reference; a frame without one is its own, and is counted there.
    pub(super) reference: Option<usize>,
    pub(super) classes: Classes,
    /// Pixels that are rendered; none in a frame without a reference.
    pub(super) pixels: PixelRuns,
}

/// Error sums of one comparison over frames.
#[derive(Default)]
struct ErrorSums {
    squared: Option<f64>,
    similar: Option<f64>,
}

impl ErrorSums {
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
    model: ErrorSums,
    truth: ErrorSums,
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
    fn of(scene: &Scene, path: &[Camera], step: &(dyn Fn() + Sync)) -> Result<Self, PathError> {
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

impl TargetPixels {
    fn of(frame: &Frame, camera: &Camera) -> Self {
        let classes = &frame.target.classes;
        let counts = Counts::of(classes, |_| true);
        let mask = Mask::new([camera.width, camera.height], |i| classes[i].is_rendered());
        let is_rendered = mask.count() > 0 && frame.reference.is_some();
        Self {
            reference: frame.reference,
            classes: Classes {
                warped: counts.warped,
                void: counts.void,
                rendered: counts.total() - counts.warped - counts.void,
            },
            pixels: match is_rendered {
                true => PixelRuns::of(&mask, classes.len()),
                false => PixelRuns::default(),
            },
        }
    }
}

impl WarpedPath {
    fn of(
        frames: &mut dyn Iterator<Item = Result<Frame, WarpError>>,
        path: &[Camera],
        shown: &Shown,
        step: &(dyn Fn() + Sync),
    ) -> Result<Self, WarpError> {
        let (mut targets, mut errors) = (vec![], Errors::default());
        for frame in frames {
            let frame = frame?;
            let (model, truth) = (&shown.models[frame.number], &shown.truths[frame.number]);
            errors.add(&frame.target.shaded.picture, model, truth.as_ref());
            targets.push(TargetPixels::of(&frame, &path[frame.number]));
            step();
        }
        Ok(Self {
            targets,
            quality: errors.quality(),
        })
    }
}

impl PathPictures {
    /// Renders a path in floating point; nothing of one of full frames alone. `step` is called after each
    /// frame.
    ///
    /// # Errors
    /// A scene or a path that does not fit.
    pub(super) fn render(
        scene: &Scene,
        options: &PathOptions,
        step: &(dyn Fn() + Sync),
    ) -> Result<Self, PathError> {
        if options.parts == PathParts::FullFrames {
            return Ok(Self::default());
        }
        let path = scene.path(options.fps, options.frames)?;
        if path.is_empty() {
            return Err(PathError::NoFrames);
        }
        let plan = plan(&path, options)?;
        let warper = Warper {
            renderer: scene,
            geometry: None,
            rule: options.rule(scene),
        };
        let shown = Shown::of(scene, &path, step)?;
        let warped = &mut Sequence::new(warper, &path, &plan, &[]);
        let chain = &mut Chain::new(warper, &path, options.window);
        Ok(Self {
            warped: WarpedPath::of(warped, &path, &shown, step)?,
            chained: WarpedPath::of(chain, &path, &shown, step)?,
            full: shown.full.quality(),
            half: shown.halved.quality(),
        })
    }
}
