//! Verilated units, driven from Rust and from a C++ testbench of the same stimulus.
//!
//! The stimulus is that of whole runs of the lantern: streams always ready, all inputs of every clock.
//! Both sides set every input, evaluate both halves of the clock and read every output, and must read the
//! same. They take turns, and the fastest run of each counts.

use std::sync::Arc;

use potamoi_cycles::Stalls;
use potamoi_formats::config::Config;
use potamoi_reference::trace_recorder::Limits;
use potamoi_rtl::{GatherUnit, RtlError, VectorBatch, VectorUnit, model};
use potamoi_scene::Scene;
use potamoi_scene::trace::Trace;
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::vector_unit::vector_unit;
use potamoi_verilated::{Toolchain, peer::Peer};

use crate::error::SpeedError;
use crate::machine::Tool;
use crate::row::{Beside, Figure, Kind, Row, Section};
use crate::sizes::Sizes;

/// Nanoseconds of processor time a clock.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clocks {
    /// Driven from Rust.
    rust: f64,
    /// By the C++ testbench.
    pub(crate) cpp: f64,
    /// Clocks of the stimulus.
    count: u64,
}

/// Both units, or why one has no figure.
#[derive(Debug)]
pub(crate) struct Units {
    pub(crate) gathering: Result<Clocks, String>,
    pub(crate) vector: Result<Clocks, String>,
    tools: Result<[String; 2], String>,
}

/// Number of steps of [`Units::measure`].
pub(crate) const STEPS: u64 = 2;

impl Units {
    /// Measures both.
    ///
    /// # Errors
    /// A scene that cannot be rendered.
    pub(crate) fn measure(
        sizes: &Sizes,
        runs: u32,
        begin: &mut dyn FnMut(&str),
    ) -> Result<Self, SpeedError> {
        let tools = match Toolchain::detect() {
            Ok(tools) => tools,
            Err(error) => return Ok(Self::without(&error.to_string())),
        };
        let config = (sizes.config)();
        let mut scene = Scene::open("lantern")?;
        scene.set_size(Some(sizes.units), None)?;
        let [entries, elements] = sizes.stimulus;
        let trace = Trace::record(&scene, &config, Limits { entries, elements })?;
        begin("the gathering unit: building and running its models");
        let gathering = gathering(&config, &trace, &tools, runs);
        begin("the vector unit: building and running its models");
        let vector = vector(&config, &trace, &tools, runs);
        let versions = [tools.verilator_version(), tools.cxx_version()];
        Ok(Self {
            gathering: gathering.map_err(|error| error.to_string()),
            vector: vector.map_err(|error| error.to_string()),
            tools: Ok(versions.map(str::to_owned)),
        })
    }

    /// No unit, for this reason.
    pub(crate) fn without(why: &str) -> Self {
        Self {
            gathering: Err(why.to_owned()),
            vector: Err(why.to_owned()),
            tools: Err(why.to_owned()),
        }
    }

    /// Verilator and the compiler.
    pub(crate) fn tools(&self) -> [Tool; 2] {
        let version = |at: usize| match &self.tools {
            Ok(versions) => Ok(versions[at].clone()),
            Err(why) => Err(why.clone()),
        };
        [
            Tool::new("Verilator", &version(0)),
            Tool::new("C++ compiler", &version(1)),
        ]
    }

    /// A row of each unit.
    pub(crate) fn rows(&self) -> Vec<Row> {
        vec![
            row("gathering unit", &self.gathering),
            row("vector unit", &self.vector),
        ]
    }
}

fn row(unit: &str, found: &Result<Clocks, String>) -> Row {
    let figure =
        |of: fn(&Clocks) -> f64| -> Figure { found.as_ref().map(of).map_err(Clone::clone) };
    let beside = Beside::new(Kind::Peer, "C++ testbench", &figure(|clocks| clocks.cpp));
    let origin = "the Verilated model driven from Rust; beside: the same model driven by a C++ program \
                  with the same inputs in every clock, whose outputs were the same";
    let row = Row::new(
        Section::Units,
        format!("{unit}, from Rust"),
        &figure(|clocks| clocks.rust),
        beside,
        origin,
    );
    let row = row.in_unit("ns a clock");
    match found {
        Ok(clocks) => row.with_counts([("clocks", clocks.count)]),
        Err(_) => row,
    }
}

fn gathering(
    config: &Config,
    trace: &Trace,
    tools: &Toolchain,
    runs: u32,
) -> Result<Clocks, RtlError> {
    let module = gathering_unit(config)?;
    let unit = GatherUnit::build(config)?;
    let tasks: Vec<_> = trace.gathered.iter().map(|g| g.task.clone()).collect();
    compared(&module, tools, runs, &|inputs| {
        unit.stimulus(&tasks, &Stalls::NONE, 0, inputs)
    })
}

fn vector(
    config: &Config,
    trace: &Trace,
    tools: &Toolchain,
    runs: u32,
) -> Result<Clocks, RtlError> {
    let module = vector_unit(config)?;
    let unit = VectorUnit::build(config)?;
    let batches = trace.computed.iter().map(|own| VectorBatch {
        op: own.op,
        a: &own.a,
        b: &own.b,
    });
    let batches: Vec<_> = batches.collect();
    compared(&module, tools, runs, &|inputs| {
        unit.stimulus(&batches, &Stalls::NONE, 0, inputs)
    })
}

/// The values of named inputs in every clock.
type Stimulus<'a> = dyn Fn(&[&str]) -> Result<Vec<u32>, RtlError> + 'a;

/// Both sides of a module on the stimulus for its named inputs.
fn compared(
    module: &Arc<potamoi_netlist::Module>,
    tools: &Toolchain,
    runs: u32,
    stimulus: &Stimulus<'_>,
) -> Result<Clocks, RtlError> {
    let peer = Peer::build(model(module), tools, "clk")?;
    let inputs: Vec<&str> = peer
        .inputs()
        .iter()
        .map(|port| port.name.as_str())
        .collect();
    let times = peer.compare(&stimulus(&inputs)?, runs.max(1) as usize)?;
    Ok(Clocks {
        rust: times.rust_fastest_ns,
        cpp: times.cpp_fastest_ns,
        count: times.cycles as u64,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_missing_tool_is_the_reason_of_both_units() {
        let units = Units::without("no verilator: apt install verilator");
        for row in units.rows() {
            assert_eq!(
                (row.measured, row.beside.value, row.ratio),
                (None, None, None)
            );
            for why in [row.why, row.beside.why] {
                assert_eq!(why.as_deref(), Some("no verilator: apt install verilator"));
            }
            assert!(row.counts.is_empty());
        }
        assert!(units.tools().iter().all(|tool| tool.version.is_none()));
    }

    #[test]
    fn a_ratio_is_rust_over_cpp() {
        let row = row(
            "unit",
            &Ok(Clocks {
                rust: 30.0,
                cpp: 20.0,
                count: 5,
            }),
        );
        assert_eq!(
            (row.ratio, row.unit, row.counts[0].count),
            (Some(1.5), "ns a clock", 5)
        );
    }
}
