//! Speed of the Verilated gathering unit, driven from Rust, relative to a C++
//! testbench of the same stimulus in one run.
//!
//! The stimulus is that of a whole run of the lantern at the paper's sizes:
//! eight vertices an entry, streams always ready. Both sides set every input,
//! evaluate both halves of the clock and read every output, cycle by cycle.
//! Fails below 0.95.
#![allow(missing_docs, clippy::expect_used, clippy::panic)]

use potamoi_cycles::Stalls;
use potamoi_formats::config::Config;
use potamoi_reference::trace_recorder::Limits;
use potamoi_rtl::{GatherUnit, model};
use potamoi_scene::Scene;
use potamoi_scene::trace::Trace;
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_verilated::{Toolchain, peer::Peer};

const ENTRIES: u64 = 4_000;
const ROUNDS: usize = 101;
const RUNS: usize = 5;
const LEAST: f64 = 0.95;

fn main() {
    let config = Config::paper();
    let mut scene = Scene::open("lantern").expect("built in");
    scene.set_size(Some(200), None).expect("a size");
    let limits = Limits {
        entries: ENTRIES,
        elements: 0,
    };
    let trace = Trace::record(&scene, &config, limits).expect("the paper's sizes");
    let tasks: Vec<_> = trace.gathered.into_iter().map(|g| g.task).collect();

    let tools = Toolchain::detect().expect("Verilator and a C++ compiler");
    println!("{} and {}", tools.verilator_version(), tools.cxx_version());
    let module = gathering_unit(&config).expect("a netlist");
    let peer = Peer::build(model(&module), &tools, "clk").expect("the model builds");
    let inputs: Vec<&str> = peer.inputs().iter().map(|p| p.name.as_str()).collect();
    let unit = GatherUnit::build(&config).expect("the model builds");
    let stimulus = unit
        .stimulus(&tasks, &Stalls::NONE, 0, &inputs)
        .expect("the unit runs");

    let mut ratios: Vec<f64> = (0..RUNS)
        .map(|_| {
            let report = peer.compare(&stimulus, ROUNDS).expect("both sides agree");
            println!(
                "{} cycles, medians of {ROUNDS} interleaved rounds: Rust {:.1} ns a cycle, C++ \
                 {:.1} ns a cycle, ratio {:.3}, checksum {:016x}",
                report.cycles, report.rust_ns, report.cpp_ns, report.ratio, report.checksum
            );
            report.ratio
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    let median = ratios.get(RUNS / 2).copied().expect("runs");
    println!(
        "ratio: least {:.3}, median {median:.3}, most {:.3}",
        ratios[0],
        ratios[RUNS - 1]
    );
    assert!(
        median >= LEAST,
        "driven from Rust, the unit runs below {LEAST} of its speed from C++"
    );
}
