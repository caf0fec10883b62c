//! `potamoi model --ladder`: formulas, cycle models and the hardware compared.

use potamoi_explore::system::{Fidelity, Rung};
use potamoi_system::system_model::System;
use potamoi_system::system_model::work::Replay;

use super::ModelArgs;
use super::clock;
use super::report::Report;
use crate::args::Common;
use crate::failure::Failure;
use crate::progress::{self, Shown};
use crate::stdout::say;
use crate::tables;

pub(super) fn run(common: &Common, args: &ModelArgs, system: &System) -> Result<(), Failure> {
    let setup = args.setup(common, system, args.scene.open(common)?)?;
    let spinner = progress::spinner("rendering three times");
    let found = Fidelity::of(&setup, &Shown(&spinner))?;
    spinner.finish_and_clear();
    say!(
        "{}, {} x {}: one frame in full, gathered by the unit; cycle models are the default; {}",
        found.scene,
        found.size[0],
        found.size[1],
        clock::said(&setup.costs().clock)
    );
    print(&found.rungs);
    print_memory(&found.memory);
    args.files
        .write(&Report::new("model --ladder", system, vec![found]))
}

pub(crate) fn print(rungs: &[Rung]) {
    let mut table = tables::plain([
        "",
        "gathering unit, cycles",
        "error",
        "vector unit, cycles",
        "error",
        "frame, us",
        "error",
        "wall time, s",
    ]);
    let Some(truth) = rungs.last() else { return };
    let off = |own: f64, truth: f64| format!("{:+.2} %", 100.0 * (own / truth - 1.0));
    for own in rungs {
        table.add_row([
            own.way.to_owned(),
            own.gather_cycles.to_string(),
            off(own.gather_cycles as f64, truth.gather_cycles as f64),
            own.vector_cycles.to_string(),
            off(own.vector_cycles as f64, truth.vector_cycles as f64),
            format!("{:.1}", own.frame_ns * 1e-3),
            off(own.frame_ns, truth.frame_ns),
            format!("{:.2}", own.wall_s),
        ]);
    }
    say!("{}", tables::fitted(&table, &[]));
    say!(
        "us: the geometric mean of a frame's time where all demands of the GPU's kernels overlap and \
         where none do"
    );
}

/// Prints the memory rates beside the replay of the frame's own accesses.
fn print_memory(replay: &Replay) {
    let mut table = tables::plain([
        "memory accesses",
        "MB",
        "rates, GB/s",
        "replayed, GB/s",
        "error",
        "rates, pJ per byte",
        "replayed",
        "error",
    ]);
    for (name, found) in [
        ("misses of the GPU's cache", replay.missed),
        ("rows and entries of MVoxels", replay.loaded),
    ] {
        let Some(own) = found else { continue };
        let (rates, replayed) = (own.at_rates, own.replayed);
        let [at_rates, in_order] = [rates, replayed].map(|of| 1.0 / of.ns);
        let off = |own: f64, truth: f64| format!("{:+.1} %", 100.0 * (own / truth - 1.0));
        table.add_row([
            name.to_owned(),
            format!("{:.3}", own.bytes as f64 * 1e-6),
            format!("{at_rates:.2}"),
            format!("{in_order:.2}"),
            off(at_rates, in_order),
            format!("{:.1}", rates.pj),
            format!("{:.1}", replayed.pj),
            off(rates.pj, replayed.pj),
        ]);
    }
    let table = tables::fitted(&table, &[]);
    say!("the frame's first accesses in order, replayed on the memory model\n{table}");
}
