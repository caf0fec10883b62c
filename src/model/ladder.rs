//! Three ways to the same number: formulas, cycle models, and the hardware itself.

use std::time::Instant;

use potamoi_reference::{Twins, Units};
use potamoi_rtl::RtlUnits;
use potamoi_system::soc::work::{Counted, FrameWork, Replay};
use potamoi_system::soc::{Gathering, System};
use serde::Serialize;

use super::ModelArgs;
use super::report::{self, Report};
use crate::args::Common;
use crate::failure::Failure;
use crate::model_context::Setup;
use crate::progress;
use crate::stdout::say;
use crate::tables;

/// One way.
#[derive(Serialize)]
pub(crate) struct Rung {
    pub(crate) way: &'static str,
    gather_cycles: u64,
    vector_cycles: u64,
    array_cycles: u64,
    /// Nanoseconds of the frame.
    pub(crate) frame_ns: f64,
    /// Seconds that this took here.
    pub(crate) wall_s: f64,
}

#[derive(Serialize)]
struct Ladder {
    scene: String,
    size: [u32; 2],
    rungs: Vec<Rung>,
    memory: Replay,
}

/// All of them, the hardware last.
pub(crate) fn rungs(setup: &Setup) -> Result<Vec<Rung>, Failure> {
    let (scene, config, model) = (&setup.scene, &setup.config, setup.model());
    let count = |units: &mut dyn Units| {
        let (array, cache) = (setup.system.array(), setup.system.gpu.cache_bytes);
        FrameWork::rendered(scene, config, array, cache, None, units)
    };
    let begun = Instant::now();
    let Counted {
        work,
        sums,
        modelled,
        ..
    } = count(&mut Twins::new(config))?;
    let counted_s = begun.elapsed().as_secs_f64();
    // What all of them use is made once.
    model.frame(&work, Gathering::Unit)?;
    let mut rungs = vec![];
    let mut rung = |way, work: &FrameWork, before_s: f64| -> Result<(), Failure> {
        let begun = Instant::now();
        let frame = model.frame(work, Gathering::Unit)?;
        let total = work.total();
        rungs.push(Rung {
            way,
            gather_cycles: total.gather_cycles,
            vector_cycles: total.vector_cycles,
            array_cycles: total.array_cycles,
            frame_ns: frame.span_ns,
            wall_s: before_s + begun.elapsed().as_secs_f64(),
        });
        Ok(())
    };
    // Without the cycle models: what is asked for is counted all the same.
    let asked_s = counted_s - modelled.as_secs_f64();
    rung("formulas on one sum", &work.as_one_sum(sums), asked_s)?;
    rung("cycle models", &work, counted_s)?;
    let mut rtl = RtlUnits::new(config);
    let begun = Instant::now();
    let through = count(&mut rtl)?.work;
    let simulated_s = begun.elapsed().as_secs_f64();
    let cycles = rtl.cycles();
    // Cycles of the hardware stand for those of the models.
    let measured = through.with_cycles(cycles.gather, cycles.vector);
    rung("Verilated units", &measured, simulated_s)?;
    Ok(rungs)
}

pub(super) fn run(common: &Common, args: &ModelArgs, system: &System) -> Result<(), Failure> {
    let setup = args.setup(common, system, args.scene.open()?)?;
    let spinner = progress::spinner("rendering three times");
    let rungs = rungs(&setup)?;
    spinner.set_message("replaying what it reads");
    let cache = setup.system.gpu.cache_bytes;
    let replay = Replay::of(&setup.scene, &setup.config, cache, setup.memory(), None)?;
    spinner.finish_and_clear();
    let scene = &setup.scene;
    let size = [scene.camera().width, scene.camera().height];
    say!(
        "{}, {} x {}: one frame in full, gathered by the unit; cycle models are the default",
        scene.name(),
        size[0],
        size[1]
    );
    print(&rungs);
    print_memory(&replay);
    let found = Ladder {
        scene: scene.name().to_owned(),
        size,
        rungs,
        memory: replay,
    };
    report::write(&Report::new("model --ladder", system, vec![found]), args)
}

pub(crate) fn print(rungs: &[Rung]) {
    let mut table = tables::plain([
        "",
        "gathering unit, cycles",
        "off",
        "vector unit, cycles",
        "off",
        "frame, us",
        "off",
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
    say!("{table}");
}

/// How far the rates of memory are from the frame's own accesses.
fn print_memory(replay: &Replay) {
    let mut table = tables::plain([
        "memory, of",
        "MB",
        "rates, GB/s",
        "replayed, GB/s",
        "off",
        "rates, pJ a byte",
        "replayed",
        "off",
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
    say!("the frame's first accesses in their order, through the memory's model\n{table}");
}
