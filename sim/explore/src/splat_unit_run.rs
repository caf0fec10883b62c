//! Cycles of the splat unit for a frame, by its cycle model.

use potamoi_cycles::splat_unit::{SplatCounters, SplatJobRun, SplatRunner, last_end};
use potamoi_formats::config::Config;
pub use potamoi_reference::splat_unit::SplatPart;
use potamoi_reference::splat_unit::{SplatEntry, SplatJob, SplatSettings};
use potamoi_scene::{Model, Scene};
use potamoi_splats::{RenderError, Schedule, View, unit_entries, unit_settings};
use schemars::JsonSchema;
use serde::Serialize;

use crate::ExploreError;

/// A frame on the splat unit, with streams that never pause.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SplatUnitRun {
    /// Lanes of its exponential.
    pub lanes: u32,
    /// Tiles in flight.
    pub tiles: u32,
    /// Units side by side.
    pub units: u32,
    /// Cycles of all jobs, pixels included.
    pub cycles: u64,
    /// Cycles until the last of the units side by side is done.
    pub elapsed_cycles: u64,
    /// Work and busy cycles.
    pub counters: SplatCounters,
    /// Square sums over pairs that draw or stop a pixel.
    pub square_sums_a_counted_pair: f64,
    /// Lanes of the exponential's vectors, those without a pair among them, over pairs that draw or stop a
    /// pixel.
    pub lane_slots_a_counted_pair: f64,
    /// Cycles times lanes over pairs that draw or stop a pixel.
    pub lane_clocks_a_counted_pair: f64,
    /// The same frame on units from which a part is left out, one at a time.
    pub without: Vec<SplatPartLeftOut>,
}

/// A frame on splat units from which a part is left out.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct SplatPartLeftOut {
    /// The part.
    pub part: SplatPart,
    /// Cycles of all jobs, pixels included.
    pub cycles: u64,
    /// Cycles until the last of the units side by side is done.
    pub elapsed_cycles: u64,
    /// Square sums over pairs that draw or stop a pixel.
    pub square_sums_a_counted_pair: f64,
    /// Exponentials over pairs that draw or stop a pixel.
    pub exponentials_a_counted_pair: f64,
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
    let mut groups = vec![];
    for group in (0..schedule.groups()).filter_map(|g| schedule.group(g)) {
        let mut entries = vec![];
        unit_entries(&view, &group, &mut |entry| entries.push(*entry));
        groups.push((group.tiles.len(), entries));
    }
    let frame = Frame { settings, groups };
    let Some(runner) = SplatRunner::new(config) else {
        return Ok(None);
    };
    let whole = frame.run(runner, su.units)?;
    let mut without = vec![];
    for part in [SplatPart::Spans, SplatPart::Cut] {
        let Some(runner) = SplatRunner::new(config) else {
            continue;
        };
        let run = frame.run(runner.without(part), su.units)?;
        without.push(SplatPartLeftOut {
            part,
            cycles: run.all.cycles,
            elapsed_cycles: run.elapsed_cycles,
            square_sums_a_counted_pair: run.a_counted_pair(run.all.counters.square_sums),
            exponentials_a_counted_pair: run.a_counted_pair(run.all.counters.exponentials),
        });
    }
    let SplatJobRun {
        cycles,
        counters,
        lane_slots,
    } = whole.all;
    Ok(Some(SplatUnitRun {
        lanes: su.lanes,
        tiles: su.tiles,
        units: su.units,
        cycles,
        elapsed_cycles: whole.elapsed_cycles,
        counters,
        square_sums_a_counted_pair: whole.a_counted_pair(counters.square_sums),
        lane_slots_a_counted_pair: whole.a_counted_pair(lane_slots),
        lane_clocks_a_counted_pair: whole.a_counted_pair(cycles * u64::from(su.lanes)),
        without,
    }))
}

/// The jobs of a frame: tiles and records of each.
struct Frame {
    settings: SplatSettings,
    groups: Vec<(usize, Vec<SplatEntry>)>,
}

/// The sum of all jobs.
struct FrameRun {
    all: SplatJobRun,
    elapsed_cycles: u64,
}

impl Frame {
    fn run(&self, mut runner: SplatRunner, units: u32) -> Result<FrameRun, ExploreError> {
        let (mut all, mut jobs) = (SplatJobRun::default(), vec![]);
        for (tiles, entries) in &self.groups {
            let job = SplatJob {
                settings: self.settings,
                tiles: *tiles,
                entries,
            };
            let run = runner.run(&job);
            let run = run.map_err(|error| ExploreError::Rtl(error.into()))?;
            jobs.push(run.cycles);
            all += run;
        }
        Ok(FrameRun {
            all,
            elapsed_cycles: last_end(jobs.into_iter(), units),
        })
    }
}

impl FrameRun {
    /// A number over the pairs that draw or stop a pixel.
    fn a_counted_pair(&self, number: u64) -> f64 {
        let counters = &self.all.counters;
        number as f64 / (counters.drawn + counters.stopped).max(1) as f64
    }
}

fn cloud_of(scene: &Scene) -> Option<&potamoi_gaussians::Cloud> {
    match scene.model() {
        Model::Splats(cloud) => Some(cloud),
        _ => None,
    }
}
