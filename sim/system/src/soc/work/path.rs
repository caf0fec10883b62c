//! What the frames of a camera path ask for: rendered in full, warped, warped from one another,
//! and at half the resolution.

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

use super::super::npu::Array;
use super::frame::FrameWork;

/// Frames that are counted side by side, with their pictures in memory.
const SIDE_BY_SIDE: usize = 8;

/// A path that could not be counted.
#[derive(Debug, Error)]
pub enum PathError {
    /// The scene cannot be rendered so.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// It cannot be warped so.
    #[error(transparent)]
    Warp(#[from] WarpError),
    /// There is nothing to count.
    #[error("frames is 0: expected 1 or more frames of a path")]
    NoFrames,
}

/// What is counted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PathOptions {
    /// Frames of the path.
    pub frames: u32,
    /// Frames a second of the scene's way.
    pub fps: f64,
    /// Targets of a reference.
    pub window: u32,
    /// Largest angle between the rays of reference and target at a point, in degrees.
    pub phi: Option<f64>,
    /// Which pixels are warped and which are rendered.
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub profile: Profile,
    /// Rows and columns of the MAC array.
    pub array: [u64; 2],
    /// Whether its units hold a second operand.
    pub is_double_buffered: bool,
    /// Bytes of the GPU's cache.
    pub cache: u32,
}

impl PathOptions {
    /// What decides which pixels of a scene's targets are warped.
    pub(super) fn rule(&self, scene: &Scene) -> Rule {
        Rule {
            phi: self.phi.map(f64::to_radians),
            warps_still: scene.choices().forces(Effect::Warping),
            ..self.profile.rule()
        }
    }
}

/// Pixels of a target by where they come from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Classes {
    /// Taken from the reference.
    pub warped: u64,
    /// Background.
    pub void: u64,
    /// Rendered.
    pub rendered: u64,
}

impl Classes {
    /// All of them.
    #[must_use]
    pub const fn pixels(&self) -> u64 {
        self.warped + self.void + self.rendered
    }
}

/// A frame that is warped.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TargetWork {
    /// The reference that it is warped from; none where it is one.
    pub reference: Option<usize>,
    /// Its pixels.
    pub classes: Classes,
    /// What rendering the rest asks for; none where nothing is rendered.
    pub work: Option<FrameWork>,
}

/// How like the frames of a path are to others: dB of the mean squared error over all of them,
/// peak 1, none where they are equal; and structural similarity, its mean over them, none where
/// they have less than 11 x 11 pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Beside the model's own frames, rendered in full.
    pub model_db: Option<f64>,
    /// Beside what the model was sampled from, where that is known.
    pub truth_db: Option<f64>,
    /// As `model_db`.
    #[serde(default)]
    pub model_ssim: Option<f64>,
    /// As `truth_db`.
    #[serde(default)]
    pub truth_ssim: Option<f64>,
}

/// Work of a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathWork {
    /// The scene.
    pub scene: String,
    /// The algorithm, by its usual name.
    pub algorithm: String,
    /// Pixels a row, and rows.
    pub size: [u32; 2],
    /// What was counted.
    pub options: PathOptions,
    /// Frames in full, at the poses of references.
    pub references: Vec<FrameWork>,
    /// The frame of the path as which each reference is shown, if it is one, and the frame at
    /// whose time its pose is known.
    pub reference_frames: Vec<(Option<usize>, usize)>,
    /// Frames warped from references (SpaRW), one a frame of the path.
    pub targets: Vec<TargetWork>,
    /// Frames each warped from the one before, the first of a window in full (Temp-N).
    pub chained: Vec<TargetWork>,
    /// Frames at half the width and height (DS-2), at the poses of references.
    pub halves: Vec<FrameWork>,
    /// Of frames in full.
    pub full_quality: Quality,
    /// Of warped ones.
    pub warped_quality: Quality,
    /// Of those warped from one another.
    pub chained_quality: Quality,
    /// Of those at half the resolution.
    pub half_quality: Quality,
}

/// Likeness to one kind of picture, summed up over frames.
#[derive(Default)]
struct Sums {
    squared: Option<f64>,
    similar: Option<f64>,
}

impl Sums {
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

/// What frames are like.
#[derive(Default)]
struct Errors {
    model: Sums,
    truth: Sums,
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

/// Counts frames of a scene.
struct Counter<'a> {
    scene: Scene,
    config: &'a Config,
    array: Array,
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

    /// Frames in full, some side by side.
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

    /// Frames of a path as they are made, and how good they are.
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

/// What a path's frames are compared with.
struct Shown {
    /// By the model.
    models: Vec<Picture>,
    /// What is there, where that is known.
    truths: Vec<Option<Picture>>,
    /// Of the model's own frames, and of those at half the resolution.
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
    /// The frame in full that stands for a frame of the path: its reference's.
    ///
    /// # Panics
    /// Never: a path that was counted has a reference.
    #[must_use]
    pub fn full(&self, number: usize) -> &FrameWork {
        self.standing_for(&self.references, number)
    }

    /// The same at half the width and height.
    ///
    /// # Panics
    /// Never, likewise.
    #[must_use]
    pub fn half(&self, number: usize) -> &FrameWork {
        self.standing_for(&self.halves, number)
    }

    fn standing_for<'a>(&self, works: &'a [FrameWork], number: usize) -> &'a FrameWork {
        let window = self.options.window.max(1) as usize;
        &works[(number / window).min(works.len() - 1)]
    }

    /// Steps that [`PathWork::count`] tells of.
    #[must_use]
    pub fn steps(options: &PathOptions) -> u64 {
        3 * u64::from(options.frames)
            + 2 * u64::from(options.frames.div_ceil(options.window.max(1)))
    }

    /// Renders and counts a path; `step` is told of each frame that is done.
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
            array: Array {
                rows,
                columns,
                is_double_buffered: options.is_double_buffered,
                ..Array::PAPER
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
