//! Energy of a netlist at work.

use std::ops::Range;

use potamoi_formats::config::Config;
use potamoi_gates::Watch;
use potamoi_rtl::{GateEngine, RtlError, VectorBatch};

use super::activity::{GatherWindow, SplatWindow, VectorWindow};
use super::count::{Counter, Energies};
use super::multiply::MultiplyWindow;
use super::static_data::StaticData;
use crate::SynthError;

/// Idle cycles measured after the work.
const REST: u64 = 64;

/// Work for a gate-level unit.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub(super) enum Work {
    Gather(GatherWindow),
    Vector(VectorWindow),
    Multiply(MultiplyWindow),
    Splat(SplatWindow),
}

impl Work {
    /// Runs it, compared with golden results in every output bit and every cycle. Returns the busy
    /// cycles.
    pub(super) fn run<W: Watch>(
        &self,
        engine: &mut GateEngine<W>,
        config: &Config,
    ) -> Result<u64, SynthError> {
        let wrong = |e: RtlError| SynthError::Rtl(Box::new(e));
        match self {
            Self::Gather(window) => {
                let done = engine.gather(config, &window.tasks, &window.features);
                Ok(done.map_err(wrong)?.busy)
            }
            Self::Vector(window) => {
                let (op, runs) = (window.op, &window.runs);
                let batches: Vec<_> = runs
                    .iter()
                    .filter_map(|[a, b, _]| Some(VectorBatch { op: op?, a, b }))
                    .collect();
                let results: Vec<i32> = runs.iter().flat_map(|run| &run[2]).copied().collect();
                let done = engine.compute(config, &batches, &results);
                Ok(done.map_err(wrong)?.busy)
            }
            Self::Multiply(window) => engine.multiply(&window.runs).map_err(wrong),
            Self::Splat(window) => {
                let last = u16::try_from(window.tiles.saturating_sub(1)).unwrap_or(u16::MAX);
                let work = (&window.entries[..], &window.settings);
                let done = engine.composite(config, work, last);
                Ok(done.map_err(wrong)?.counters.busy)
            }
        }
    }

    /// Groups of banks or lanes with equal work, and their weights: where the channels do not fill
    /// the banks, those past the last channel are idle.
    pub(super) fn kinds(&self, all: usize) -> Vec<(f64, Range<usize>)> {
        let full = match self {
            Self::Gather(window) => window.banks_of_last_segment(all),
            Self::Vector(_) | Self::Multiply(_) | Self::Splat(_) => all,
        };
        let kinds = [0..full, full..all];
        let kinds = kinds.into_iter().filter(|range| !range.is_empty());
        kinds
            .map(|range| (range.len() as f64 / all as f64, range))
            .collect()
    }

    /// Number of samples, exponentials, products, or pairs that draw or stop a pixel.
    pub(super) fn items(&self) -> u64 {
        match self {
            Self::Gather(window) => window.entries(),
            Self::Vector(window) => window.elements(),
            Self::Multiply(window) => window.products(),
            Self::Splat(window) => window.counted,
        }
    }
}

/// Measurements of a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Measured {
    /// Femtojoules a cycle by kind of module.
    pub(super) energies: Vec<Energies>,
    /// Femtojoules an idle cycle by kind of module.
    pub(super) at_rest: Vec<Energies>,
    pub(super) cycles: u64,
    /// Busy cycles, as the unit reports them.
    pub(super) busy: u64,
    /// Transitions of a net a cycle, as mean over all nets except the clock.
    pub(super) toggles: f64,
    /// Longest time from a clock edge to the last transition, in picoseconds, with delays.
    pub(super) longest_ps: f64,
}

/// Simulates work on a netlist, compared with golden results in every output bit and every cycle,
/// with the cells' delays or without.
pub(super) fn measure(
    still: &StaticData,
    config: &Config,
    work: &Work,
    is_delayed: bool,
) -> Result<Measured, SynthError> {
    let mut engine = still.engine(is_delayed, 1, Counter::new(still))?;
    let busy = work.run(&mut engine, config)?;
    let simulator = &mut engine.simulator;
    let cycles = simulator.cycles;
    let a_cycle = |energies: Vec<Energies>, cycles: u64| -> Vec<Energies> {
        let scale = 1.0 / cycles.max(1) as f64;
        energies.into_iter().map(|e| e.times(scale)).collect()
    };
    let energies = a_cycle(simulator.watch.energies(still, cycles), cycles);
    let toggles = simulator.watch.toggles() as f64 / cycles.max(1) as f64;
    let longest_ps = still.step_ps() * simulator.longest as f64;
    simulator.watch.clear();
    let inputs = [
        "s_axis_rit_tvalid",
        "s_axis_mft_tvalid",
        "s_axis_vec_tvalid",
        "s_axis_spl_tvalid",
    ];
    let rested = engine.rest(&inputs, REST);
    rested.map_err(|e| SynthError::Rtl(Box::new(e)))?;
    let at_rest = engine.simulator.watch.energies(still, REST);
    Ok(Measured {
        energies,
        at_rest: a_cycle(at_rest, REST),
        cycles,
        busy,
        toggles: toggles / still.flat.nets() as f64,
        longest_ps,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use potamoi_formats::rit::Vertices;
    use potamoi_reference::GatherTask;

    #[test]
    fn banks_past_the_last_channel_are_a_kind_of_their_own() {
        let of = |channels: usize, banks: usize| {
            let task = GatherTask {
                vertices: Vertices::Eight,
                channels,
                rows: vec![],
                entries: vec![],
            };
            let window = GatherWindow {
                tasks: vec![task],
                features: vec![],
            };
            Work::Gather(window).kinds(banks)
        };
        assert_eq!(of(13, 32), [(13.0 / 32.0, 0..13), (19.0 / 32.0, 13..32)]);
        // Two segments: five of eight banks have two channels.
        assert_eq!(of(13, 8), [(5.0 / 8.0, 0..5), (3.0 / 8.0, 5..8)]);
        assert_eq!(of(16, 8), [(1.0, 0..8)]);
        let lanes = Work::Vector(VectorWindow::default()).kinds(24);
        assert_eq!(lanes, [(1.0, 0..24)]);
    }
}
