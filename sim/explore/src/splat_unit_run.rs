//! Cycles of the splat unit for a frame, by its cycle model.

use potamoi_cycles::splat_unit::{SplatCounters, SplatJobRun, SplatRunner};
use potamoi_formats::config::Config;
use potamoi_reference::splat_unit::SplatJob;
use potamoi_scene::{Model, Scene};
use potamoi_splats::{RenderError, Schedule, View, unit_entries, unit_settings};
use serde::Serialize;

use crate::ExploreError;

/// A frame on the splat unit, with streams that never pause.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct SplatUnitRun {
    /// Lanes of its exponential.
    pub lanes: u32,
    /// Tiles in flight.
    pub tiles: u32,
    /// Cycles of all jobs, pixels included.
    pub cycles: u64,
    /// Work and busy cycles.
    pub counters: SplatCounters,
    /// Square sums over pairs that draw or stop a pixel.
    pub square_sums_a_counted_pair: f64,
    /// Lanes of the exponential's vectors, those without a pair among them, over pairs that draw or stop a
    /// pixel.
    pub lane_slots_a_counted_pair: f64,
    /// Cycles times lanes over pairs that draw or stop a pixel.
    pub lane_clocks_a_counted_pair: f64,
}

/// Runs the frame of a scene's camera in jobs of as many tiles as the unit holds. `None` if the scene is
/// no splats, the configuration has no splat unit, or its rules carry fewer bits of transmittance.
///
/// # Errors
/// Those of the schedule.
pub fn splat_unit_run(
    scene: &Scene,
    config: &Config,
) -> Result<Option<SplatUnitRun>, ExploreError> {
    let (Some(su), Some(cloud)) = (&config.su, cloud_of(scene)) else {
        return Ok(None);
    };
    let options = scene.splat_options(config);
    let failed = |error: RenderError| ExploreError::Scene(error.into());
    let view = View::new(cloud, scene.camera(), scene.profile()).map_err(failed)?;
    let settings = unit_settings(view.rules(), options.schedule.opacity);
    if settings.thresholds.spare != 0 {
        return Ok(None);
    }
    let schedule = Schedule::new(cloud, &view, &options.schedule).map_err(failed)?;
    let Some(mut runner) = SplatRunner::new(config) else {
        return Ok(None);
    };
    let mut all = SplatJobRun::default();
    for group in (0..schedule.groups()).filter_map(|g| schedule.group(g)) {
        let mut entries = vec![];
        unit_entries(&view, &group, &mut |entry| entries.push(*entry));
        let job = SplatJob {
            settings,
            tiles: group.tiles.len(),
            entries: &entries,
        };
        let run = runner.run(&job);
        all += run.map_err(|error| ExploreError::Rtl(error.into()))?;
    }
    let SplatJobRun {
        cycles,
        counters,
        lane_slots,
    } = all;
    let counted = (counters.drawn + counters.stopped).max(1);
    Ok(Some(SplatUnitRun {
        lanes: su.lanes,
        tiles: su.tiles,
        cycles,
        counters,
        square_sums_a_counted_pair: counters.square_sums as f64 / counted as f64,
        lane_slots_a_counted_pair: lane_slots as f64 / counted as f64,
        lane_clocks_a_counted_pair: cycles as f64 * f64::from(su.lanes) / counted as f64,
    }))
}

fn cloud_of(scene: &Scene) -> Option<&potamoi_splats::Cloud> {
    match scene.model() {
        Model::Splats(cloud) => Some(cloud),
        _ => None,
    }
}
