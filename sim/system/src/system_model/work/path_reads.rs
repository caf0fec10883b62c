//! Reads of a path's frames through the GPU's cache, and the path's work with them.

use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_cycles::batch::{BatchEvents, Pricing};
use potamoi_formats::config::Config;
use potamoi_scene::{Scene, SceneError};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::frame::{FrameEvents, FrameWork, Reads};
use super::path::{PathError, PathOptions, PathWork, TargetWork};
use super::path_cameras::{plan, seen_by, whole_and_half};
use super::path_events::PathEvents;
use super::path_pictures::PathPictures;
use super::pixel_runs::PixelRuns;

/// Reads of a path's frames through a cache: of references, halves, targets and chained frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct PathReads {
    references: Vec<Reads>,
    halves: Vec<Reads>,
    targets: Vec<Option<Reads>>,
    chained: Vec<Option<Reads>>,
}

impl PathEvents {
    /// The work with the units of a configuration, an array and reads.
    pub(super) fn priced(
        &self,
        config: &Config,
        options: &PathOptions,
        reads: &PathReads,
    ) -> Result<PathWork, PathError> {
        let pricing = Pricing::new(config, PathWork::array(options));
        let pricing = pricing.map_err(|error| SceneError::of_unit(error.into()))?;
        let frames = |works: &[FrameEvents], reads: &[Reads]| -> Vec<FrameWork> {
            let both = works.iter().zip(reads);
            both.map(|(work, reads)| work.priced(&pricing, *reads))
                .collect()
        };
        let targets = |works: &[TargetWork<BatchEvents>], reads: &[Option<Reads>]| {
            let both = works.iter().zip(reads);
            let priced = both.map(|(target, reads)| TargetWork {
                reference: target.reference,
                classes: target.classes,
                work: (target.work.as_ref())
                    .map(|own| own.priced(&pricing, reads.unwrap_or_default())),
            });
            priced.collect::<Vec<TargetWork>>()
        };
        let own = &self.path;
        Ok(PathWork {
            scene: own.scene.clone(),
            algorithm: own.algorithm.clone(),
            size: own.size,
            options: *options,
            references: frames(&own.references, &reads.references),
            reference_frames: own.reference_frames.clone(),
            targets: targets(&own.targets, &reads.targets),
            chained: targets(&own.chained, &reads.chained),
            halves: frames(&own.halves, &reads.halves),
            full_quality: own.full_quality,
            warped_quality: own.warped_quality,
            chained_quality: own.chained_quality,
            half_quality: own.half_quality,
        })
    }
}

impl PathWork {
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
        PathEvents::check(scene, config)?;
        let pictures = PathPictures::render(scene, options, step)?;
        let events = PathEvents::count(scene, config, options, &pictures, step)?;
        let reads = PathReads::count(scene, config, options, &events, step)?;
        events.priced(config, options, &reads)
    }
}

impl PathReads {
    /// Counts the reads of a path's frames through the options' cache. Nothing is rendered through
    /// units. `step` is called for each frame.
    ///
    /// # Errors
    /// A scene or a path that does not fit.
    pub(super) fn count(
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        events: &PathEvents,
        step: &(dyn Fn() + Sync),
    ) -> Result<Self, PathError> {
        let path = scene.path(options.fps, options.frames)?;
        let plan = plan(&path, options)?;
        let cameras = whole_and_half(&plan, options.parts);
        let of = |camera: &Camera, only: Option<&Mask>| {
            let reads = Reads::of(&seen_by(scene, camera), config, options.cache, only);
            step();
            reads
        };
        let whole = cameras.par_iter().map(|camera| of(camera, None));
        let mut references = whole.collect::<Result<Vec<_>, _>>()?;
        let halves = references.split_off(plan.references.len());
        let targets = |works: &[TargetWork<BatchEvents>], pixels: &[PixelRuns]| {
            let all = works.par_iter().zip(pixels).zip(&path);
            let all = all.map(|((target, pixels), camera)| match &target.work {
                None => {
                    step();
                    Ok(None)
                }
                Some(_) => {
                    let mask = pixels.mask([camera.width, camera.height]);
                    of(camera, Some(&mask)).map(Some)
                }
            });
            all.collect::<Result<Vec<_>, SceneError>>()
        };
        Ok(Self {
            references,
            halves,
            targets: targets(&events.path.targets, &events.targets)?,
            chained: targets(&events.path.chained, &events.chained)?,
        })
    }
}
