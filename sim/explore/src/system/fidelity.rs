//! Fidelity of the models: formulas, cycle models and the Verilated hardware.

use std::time::Instant;

use potamoi_reference::{ReferenceUnits, Units};
use potamoi_rtl::RtlUnits;
use potamoi_system::system_model::Gathering;
use potamoi_system::system_model::work::{Counted, FrameWork, Replay, UnitCycles};
use schemars::JsonSchema;
use serde::Serialize;

use crate::{ExploreError, Progress, Setup};

/// Cycles and time of a frame by one method.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Rung {
    /// Name of the method.
    pub way: &'static str,
    /// Cycles of the gathering unit.
    pub gather_cycles: u64,
    /// Cycles of the vector unit.
    pub vector_cycles: u64,
    /// Cycles of all splat units; 0 without one.
    pub splat_cycles: u64,
    /// Cycles of the MAC array, the same for all methods.
    pub array_cycles: u64,
    /// Time of the frame in nanoseconds, the geometric mean of both bounds of the GPU's kernels.
    pub frame_ns: f64,
    /// Wall time of the method in seconds.
    pub wall_s: f64,
}

/// Fidelity of the cycle and memory models.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Fidelity {
    /// The scene's name.
    pub scene: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Methods, from the fastest to the Verilated units.
    pub rungs: Vec<Rung>,
    /// Memory rates beside a replay of the frame's own accesses.
    pub memory: Replay,
}

impl Fidelity {
    /// Fidelity for the full frame that a setup's camera sees, gathered by the unit.
    ///
    /// # Errors
    /// As [`rungs`].
    pub fn of(setup: &Setup, progress: &dyn Progress) -> Result<Self, ExploreError> {
        let rungs = rungs(setup)?;
        progress.now("replaying memory accesses");
        let scene = &setup.scene;
        let cache = setup.system.gpu.cache_bytes();
        Ok(Self {
            scene: scene.name().to_owned(),
            size: [scene.camera().width, scene.camera().height],
            rungs,
            memory: Replay::of(scene, &setup.config, cache, setup.memory(), None)?,
        })
    }
}

/// The frame that a setup's camera sees by formulas, by cycle models and on the Verilated units, in
/// this order.
///
/// # Errors
/// A scene that the configuration cannot render, or Verilog that cannot be built or run.
pub fn rungs(setup: &Setup) -> Result<Vec<Rung>, ExploreError> {
    let (scene, config, model) = (&setup.scene, &setup.config, setup.model());
    let count = |units: &mut dyn Units| {
        let (array, cache) = (setup.system.array(), setup.system.gpu.cache_bytes());
        FrameWork::rendered(scene, config, array, cache, None, units)
    };
    let begun = Instant::now();
    let Counted {
        work,
        sums,
        modelled,
        ..
    } = count(&mut ReferenceUnits::new(config))?;
    let counted_s = begun.elapsed().as_secs_f64();
    // What all of them use is made once.
    model.frame(&work, Gathering::Unit)?;
    let mut rungs = vec![];
    let mut rung = |way, work: &FrameWork, before_s: f64| -> Result<(), ExploreError> {
        let begun = Instant::now();
        let frame = model.frame(work, Gathering::Unit)?;
        let total = work.total();
        rungs.push(Rung {
            way,
            gather_cycles: total.gather_cycles,
            vector_cycles: total.vector_cycles,
            splat_cycles: total.splat_cycles,
            array_cycles: total.array_cycles,
            frame_ns: frame.span_ns().mid(),
            wall_s: before_s + begun.elapsed().as_secs_f64(),
        });
        Ok(())
    };
    // Without the cycle models: what is asked for is counted all the same.
    let asked_s = counted_s - modelled.as_secs_f64();
    rung(
        "formulas on one sum",
        &work.as_one_sum(sums, config)?,
        asked_s,
    )?;
    rung("cycle models", &work, counted_s)?;
    let mut rtl = RtlUnits::new(config);
    let begun = Instant::now();
    let through = count(&mut rtl)?.work;
    let simulated_s = begun.elapsed().as_secs_f64();
    let cycles = rtl.cycles();
    // Cycles of the hardware stand for those of the models.
    let measured = through.with_cycles(UnitCycles {
        gather: cycles.gather,
        vector: cycles.vector,
        splat: cycles.splat,
    });
    rung("Verilated units", &measured, simulated_s)?;
    Ok(rungs)
}
