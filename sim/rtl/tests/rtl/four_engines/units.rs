//! Units on an engine, and recorded runs of them.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_formats::units::GATHERING_UNIT;
use potamoi_netlist::{Header, Module, verilog};
use potamoi_rtl::{Check, EngineKind, GatherUnit, PortTrace, VectorBatch, VectorUnit};
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::vector_unit::vector_unit;

use super::jobs::{Job, Work};

pub(super) enum Unit {
    Gather(GatherUnit),
    Vector(VectorUnit),
}

/// Verilog that an engine runs: the generator's, or other files.
#[derive(Clone, Copy)]
pub(super) enum Text<'a> {
    Own,
    Files(&'a BTreeMap<String, String>),
}

/// The ports of a run, and its totals or why it failed, in words.
#[derive(Clone)]
pub(super) struct Run {
    pub(super) trace: PortTrace,
    pub(super) totals: Result<String, String>,
}

fn module_of(config: &Config, unit: &str) -> Arc<Module> {
    match unit == GATHERING_UNIT {
        true => gathering_unit(config).unwrap(),
        false => vector_unit(config).unwrap(),
    }
}

pub(super) fn verilog_of(config: &Config, unit: &str) -> BTreeMap<String, String> {
    verilog(&module_of(config, unit), &Header::default())
}

impl Unit {
    pub(super) fn of(kind: EngineKind, config: &Config, unit: &str, text: Text<'_>) -> Self {
        let is_gather = unit == GATHERING_UNIT;
        let built = match (is_gather, text) {
            (true, Text::Own) => GatherUnit::on(kind, config).map(Self::Gather),
            (false, Text::Own) => VectorUnit::on(kind, config).map(Self::Vector),
            (true, Text::Files(files)) => {
                GatherUnit::of_files(kind, config, files).map(Self::Gather)
            }
            (false, Text::Files(files)) => {
                VectorUnit::of_files(kind, config, files).map(Self::Vector)
            }
        };
        built.unwrap_or_else(|e| panic!("{unit} on {kind}: {e}"))
    }

    /// Runs a job from a state before reset, held to the reference unit and the cycle model.
    pub(super) fn run(&self, config: &Config, job: &Job, state: u64) -> Run {
        let check = Check {
            stalls: job.stalls,
            seed: job.seed,
            flags: 0,
            progress: &mut |_| {},
        };
        match (self, &job.work) {
            (Self::Gather(unit), Work::Gather(tasks, features)) => {
                let run = unit
                    .check_traced(config, tasks, features, check, state)
                    .unwrap();
                Run {
                    trace: run.trace,
                    totals: run
                        .result
                        .map(|t| format!("{t:?}"))
                        .map_err(|e| e.to_string()),
                }
            }
            (Self::Vector(unit), Work::Vector(operations, results)) => {
                let batches: Vec<_> = operations
                    .iter()
                    .map(|(op, a, b)| VectorBatch { op: *op, a, b })
                    .collect();
                let run = unit
                    .check_traced(config, &batches, results, check, state)
                    .unwrap();
                Run {
                    trace: run.trace,
                    totals: run
                        .result
                        .map(|t| format!("{t:?}"))
                        .map_err(|e| e.to_string()),
                }
            }
            _ => panic!("{}: work of the other unit", job.name),
        }
    }
}
