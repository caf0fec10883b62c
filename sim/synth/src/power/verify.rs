//! Gate-level verification of netlists against golden values.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_gates::{Flat, NoCount};

use super::activity::Sampler;
use super::library::PowerLibrary;
use super::measure::Work;
use super::multiply::MultiplyWindow;
use super::static_data::StaticData;
use super::unavailable::Unavailable;
use crate::{Library, SynthError, UnitKind};

/// Amount compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Verified {
    /// Number of runs: without delays, and with those of the cells.
    pub runs: u32,
    /// Samples or exponentials of a run.
    pub items: u64,
    /// Cycles of all runs.
    pub cycles: u64,
}

/// Simulates a share of the sampled work on a unit's netlist, without delays and with those of the
/// cells, each from another initial state.
///
/// # Errors
/// The netlist differs from the golden results or cannot be simulated, the library lacks data of
/// its cells, or there was no work.
pub fn verify_netlist(
    config: &Config,
    unit: UnitKind,
    library: &Library,
    netlist: &str,
    sampler: &Sampler,
) -> Result<Verified, SynthError> {
    let wrong = |problem: String| SynthError::Gates {
        unit: unit.to_string(),
        library: library.name.clone(),
        problem,
    };
    let work = match unit {
        UnitKind::Gathering => sampler.gather_window().map(Work::Gather),
        UnitKind::Vector => sampler.vector_window().map(Work::Vector),
        UnitKind::ArrayMac => {
            let gathered = sampler.gather_window();
            gathered.map(|own| Work::Multiply(MultiplyWindow::of(&own)))
        }
        UnitKind::Splat => sampler.splat_window().map(Work::Splat),
    };
    let work = work.ok_or_else(|| wrong("there is no work for it".to_owned()))?;
    let cells = PowerLibrary::read(library)?;
    let memories = unit.module(config)?.memory_modules();
    let flat = Flat::new(netlist, unit.top(), &cells.gates, &memories).map_err(wrong)?;
    let still = StaticData::new(&cells, &Arc::new(flat), &BTreeMap::new());
    let still = still.map_err(|lack| match lack {
        Unavailable::Absent(what) => wrong(what),
        Unavailable::Wrong(error) => error,
    })?;
    let mut verified = Verified {
        runs: 0,
        items: work.items(),
        cycles: 0,
    };
    for is_delayed in [false, true] {
        let mut engine = still.engine(is_delayed, 2 + u64::from(is_delayed), NoCount)?;
        work.run(&mut engine, config)?;
        verified.runs += 1;
        verified.cycles += engine.simulator.cycles;
    }
    Ok(verified)
}
