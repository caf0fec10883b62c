//! Work of a path before units, array and the GPU's cache are known: what is rendered once.

use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_cycles::batch::BatchEvents;
use potamoi_formats::config::Config;
use potamoi_scene::{Scene, SceneError};
use potamoi_warp::Plan;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::frame::FrameEvents;
use super::path::{Classes, PathError, PathOptions, PathParts, PathWork, Quality, TargetWork};
use super::path_cameras::{plan, seen_by, whole_and_half};
use super::path_pictures::{PathPictures, TargetPixels, WarpedPath};
use super::pixel_runs::PixelRuns;

/// Frames counted in parallel.
const SIDE_BY_SIDE: usize = 8;

/// Work of a path, with vector unit, array and reads left open, and the pixels of its targets that
/// are rendered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct PathEvents {
    pub(super) path: PathWork<BatchEvents>,
    pub(super) targets: Vec<PixelRuns>,
    pub(super) chained: Vec<PixelRuns>,
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

    /// Counts what is rendered of the targets of a path.
    fn targets(
        &self,
        targets: &[TargetPixels],
        path: &[Camera],
        step: &(dyn Fn() + Sync),
    ) -> Result<Vec<TargetWork<BatchEvents>>, SceneError> {
        let mut all = vec![];
        let each: Vec<_> = targets.iter().zip(path).collect();
        for some in each.chunks(SIDE_BY_SIDE) {
            let counted = some.par_iter().map(|(target, camera)| {
                let mask = target.pixels.rendered([camera.width, camera.height]);
                let work = mask.map(|mask| self.frame(camera, Some(&mask))).transpose();
                step();
                work
            });
            for ((target, _), work) in some.iter().zip(counted.collect::<Vec<_>>()) {
                all.push(TargetWork {
                    reference: target.reference,
                    classes: target.classes,
                    work: work?,
                });
            }
        }
        Ok(all)
    }
}

impl PathEvents {
    /// Refuses a configuration that cannot render the scene, before minutes of pictures: by a frame of one
    /// pixel.
    ///
    /// # Errors
    /// That of the configuration.
    pub(super) fn check(scene: &Scene, config: &Config) -> Result<(), PathError> {
        let pixel = scene.camera().resized(1, 1);
        FrameEvents::of(&seen_by(scene, &pixel), config, None)?;
        Ok(())
    }

    /// Counts the events of a path whose pictures are known. `step` is called after each frame.
    ///
    /// # Errors
    /// A scene, a path or a configuration that does not fit.
    pub(super) fn count(
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        pictures: &PathPictures,
        step: &(dyn Fn() + Sync),
    ) -> Result<Self, PathError> {
        let path = scene.path(options.fps, options.frames)?;
        let Some(first) = path.first() else {
            return Err(PathError::NoFrames);
        };
        let plan = plan(&path, options)?;
        let counter = Counter {
            scene: scene.clone(),
            config,
        };
        let cameras = whole_and_half(&plan, options.parts);
        let mut references = counter.frames(&cameras, step)?;
        if options.parts == PathParts::FullFrames {
            return Ok(Self::of_full_frames(
                scene, options, &path, &plan, references,
            ));
        }
        let halves = references.split_off(plan.references.len());
        let PathPictures {
            full,
            half,
            warped,
            chained,
        } = pictures;
        let pixels = |of: &WarpedPath| of.targets.iter().map(|t| t.pixels.clone()).collect();
        Ok(Self {
            targets: pixels(warped),
            chained: pixels(chained),
            path: PathWork {
                scene: scene.name().to_owned(),
                algorithm: scene.model().algorithm().to_owned(),
                size: [first.width, first.height],
                options: *options,
                references,
                reference_frames: (plan.references.iter())
                    .map(|task| (task.target, task.known))
                    .collect(),
                targets: counter.targets(&warped.targets, &path, step)?,
                chained: counter.targets(&chained.targets, &path, step)?,
                halves,
                full_quality: *full,
                warped_quality: warped.quality,
                chained_quality: chained.quality,
                half_quality: *half,
            },
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
