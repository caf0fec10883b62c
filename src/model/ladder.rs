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

/// Cycles of a unit.
type Cycles = fn(&Rung) -> u64;

pub(crate) fn print(rungs: &[Rung]) {
    let Some(truth) = rungs.last() else { return };
    // A unit that does nothing in the frame has no column.
    let units: [(&str, Cycles); 3] = [
        ("gathering unit, cycles", |own| own.gather_cycles),
        ("vector unit, cycles", |own| own.vector_cycles),
        ("splat units, cycles", |own| own.splat_cycles),
    ];
    let busy = units.iter().filter(|(_, cycles)| cycles(truth) > 0);
    let busy: Vec<_> = busy.collect();
    let mut head = vec![""];
    head.extend(busy.iter().flat_map(|(name, _)| [*name, "error"]));
    head.extend(["frame, us", "error", "wall time, s"]);
    let mut table = tables::plain(head);
    let off = |own: f64, truth: f64| format!("{:+.2} %", 100.0 * (own / truth - 1.0));
    for own in rungs {
        let mut row = vec![own.way.to_owned()];
        row.extend(busy.iter().flat_map(|(_, cycles)| {
            let (own, truth) = (cycles(own), cycles(truth));
            [own.to_string(), off(own as f64, truth as f64)]
        }));
        row.extend([
            format!("{:.1}", own.frame_ns * 1e-3),
            off(own.frame_ns, truth.frame_ns),
            format!("{:.2}", own.wall_s),
        ]);
        table.add_row(row);
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
