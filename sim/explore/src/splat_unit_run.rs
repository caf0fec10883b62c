//! Cycles of the splat unit for a frame, by its cycle model.

use potamoi_cycles::splat_unit::{SplatBeat, SplatCounters, SplatModel};
use potamoi_formats::config::{Config, SuConfig};
use potamoi_reference::splat_unit::SplatEntry;
use potamoi_scene::{Model, Scene};
use potamoi_splats::{RenderError, Schedule, View, unit_entries, unit_settings};
use serde::Serialize;

use crate::ExploreError;

/// Words of the limits, each a beat.
const LIMITS: usize = 80;

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
    let mut options = scene.splat_options(config);
    options.schedule.group_tiles = Some(group_of(su));
    let failed = |error: RenderError| ExploreError::Scene(error.into());
    let view = View::new(cloud, scene.camera(), scene.profile()).map_err(failed)?;
    let settings = unit_settings(view.rules());
    if settings.thresholds.spare != 0 {
        return Ok(None);
    }
    let schedule = Schedule::new(cloud, &view, &options.schedule).map_err(failed)?;
    let (mut cycles, mut counters) = (0, SplatCounters::default());
    for group in (0..schedule.groups()).filter_map(|g| schedule.group(g)) {
        let mut entries = vec![];
        unit_entries(&view, &group, &mut |entry| entries.push(*entry));
        let last_slot = group.tiles.len().saturating_sub(1);
        let model = SplatModel::new(config, su, settings, last_slot);
        let mut model = model.map_err(|error| ExploreError::Rtl(error.into()))?;
        cycles += job(&mut model, &entries, su, &mut counters);
    }
    let counted = (counters.drawn + counters.stopped).max(1);
    Ok(Some(SplatUnitRun {
        lanes: su.lanes,
        tiles: su.tiles,
        cycles,
        counters,
        lane_clocks_a_counted_pair: cycles as f64 * f64::from(su.lanes) / counted as f64,
    }))
}

fn cloud_of(scene: &Scene) -> Option<&potamoi_splats::Cloud> {
    match scene.model() {
        Model::Splats(cloud) => Some(cloud),
        _ => None,
    }
}

/// Columns and rows of a group of as many tiles as the unit holds.
fn group_of(su: &SuConfig) -> [u32; 2] {
    let order = su.tiles.ilog2();
    [1 << order.div_ceil(2), 1 << (order / 2)]
}

/// Cycles from the first beat of a job to its last pixel; adds its counters.
fn job(
    model: &mut SplatModel,
    entries: &[SplatEntry],
    su: &SuConfig,
    sum: &mut SplatCounters,
) -> u64 {
    // The pass that clears the pixels after a reset.
    for _ in 0..su.tiles as usize * potamoi_reference::splat_unit::TILE_PIXELS + 1 {
        model.step(None, false);
    }
    let count = LIMITS + entries.len();
    let (mut next, mut cycles) = (0, 0);
    loop {
        let is_last = next + 1 == count;
        let beat = (next < count).then(|| match next.checked_sub(LIMITS) {
            Some(at) => SplatBeat::Record(&entries[at], is_last),
            None => SplatBeat::Other(is_last),
        });
        let outputs = model.step(beat, true);
        next += usize::from(beat.is_some() && outputs.ready);
        cycles += 1;
        if outputs.pixel.is_some_and(|(_, is_last)| is_last) {
            break;
        }
    }
    let own = model.step(None, true).counters;
    sum.busy += own.busy;
    sum.records += own.records;
    sum.square_sums += own.square_sums;
    sum.exponentials += own.exponentials;
    sum.drawn += own.drawn;
    sum.stopped += own.stopped;
    cycles
}
