//! Drives the vector unit on any engine.

use potamoi_formats::config::Config;
use potamoi_formats::units::{VECTOR_UNIT, VectorOp};
use potamoi_hdl::vu::vector_unit;

use super::engine::{Engine, EngineKind, Job, Runner};
use super::excerpt::{Linger, Window};
use super::model::RtlError;
use crate::cycles::{Plan, Source, Stalls, VectorInputs};

/// Cycles without a handshake after which a unit is taken to hang.
const PATIENCE: u64 = 20_000;
/// More cycles than a dump goes on after a failure.
const LINGER: u64 = 64;

/// One operation on operands of one length; a new vector begins with it.
#[derive(Debug, Clone, Copy)]
pub struct VectorBatch<'a> {
    /// The operation.
    pub op: VectorOp,
    /// First operands.
    pub a: &'a [i32],
    /// Second operands, as many.
    pub b: &'a [i32],
}

/// A vector unit, ready to run.
pub struct VectorUnit {
    lanes: usize,
    runner: Runner,
}

/// What the unit shows in one cycle.
pub(super) struct VectorSeen<'a> {
    pub(super) ready: bool,
    /// Results and kept lanes, if valid.
    pub(super) result: Option<ResultSeen<'a>>,
    /// Vectors, busy, stalls.
    pub(super) counters: [u64; 3],
}

/// A vector of results on the ports.
#[derive(Clone, Copy)]
pub(super) struct ResultSeen<'a> {
    pub(super) data: &'a [u32],
    pub(super) unknown: Option<&'a [u32]>,
    pub(super) keep: &'a [u32],
    pub(super) last: bool,
}

pub(super) trait VectorWatch {
    fn cycle(
        &mut self,
        cycle: u64,
        inputs: &VectorInputs,
        seen: &VectorSeen<'_>,
    ) -> Result<(), RtlError>;
}

/// What a run took.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct VectorTotals {
    /// Cycles until the last results were accepted.
    pub cycles: u64,
    /// Vectors accepted, from the unit's counter.
    pub vectors: u64,
    /// Cycles in which a vector was accepted or stepped, from its counter.
    pub busy: u64,
    /// Cycles in which only the lack of room refused one, from its counter.
    pub stall_out: u64,
    /// Its sticky flags.
    pub errors: u64,
}

/// What a run gave.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VectorRun {
    /// Results, one an element.
    pub results: Vec<i32>,
    /// Cycle in which each vector was accepted, and in which its results were.
    pub vectors: Vec<(u64, u64)>,
    /// What it took.
    pub totals: VectorTotals,
}

/// Vectors of a run: at most L elements of one operation each.
#[derive(Debug, Clone)]
pub(super) struct Vectors<'a> {
    pub(super) list: Vec<Vector<'a>>,
    pub(super) lanes: usize,
}

/// One vector.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vector<'a> {
    pub(super) op: VectorOp,
    pub(super) a: &'a [i32],
    pub(super) b: &'a [i32],
    /// First element, among those of all batches.
    pub(super) ordinal: usize,
    /// The batch's last.
    pub(super) last: bool,
}

impl<'a> Vectors<'a> {
    pub(super) fn new(batches: &[VectorBatch<'a>], lanes: usize) -> Result<Self, RtlError> {
        let mut list = vec![];
        let mut ordinal = 0;
        for batch in batches {
            let (a, b) = (batch.a.len(), batch.b.len());
            if a != b {
                let text = format!("{a} first and {b} second operands: expected as many");
                return Err(RtlError::Usage(text));
            }
            let count = a.div_ceil(lanes);
            let parts = batch.a.chunks(lanes).zip(batch.b.chunks(lanes));
            for (i, (a, b)) in parts.enumerate() {
                list.push(Vector {
                    op: batch.op,
                    a,
                    b,
                    ordinal,
                    last: i + 1 == count,
                });
                ordinal += a.len();
            }
        }
        Ok(Self { list, lanes })
    }

    pub(super) fn elements(&self) -> usize {
        self.list.last().map_or(0, |v| v.ordinal + v.a.len())
    }
}

impl VectorUnit {
    /// The Verilated unit of a configuration, built or found in the cache.
    ///
    /// # Errors
    /// A missing tool, or a failure of one.
    pub fn build(config: &Config) -> Result<Self, RtlError> {
        Self::on(EngineKind::Verilator, config)
    }

    /// The unit on an engine.
    ///
    /// # Errors
    /// As [`VectorUnit::build`].
    pub fn on(engine: EngineKind, config: &Config) -> Result<Self, RtlError> {
        Self::of_module(engine, config, &vector_unit(config)?)
    }

    /// Another netlist with the unit's ports, such as a faulty one.
    ///
    /// # Errors
    /// As [`VectorUnit::build`].
    pub fn of_module(
        engine: EngineKind,
        config: &Config,
        module: &std::sync::Arc<potamoi_hdl::ir::Module>,
    ) -> Result<Self, RtlError> {
        Ok(Self {
            lanes: config.vu.lanes as usize,
            runner: Runner::new(engine, module)?,
        })
    }

    pub(super) const fn lanes(&self) -> usize {
        self.lanes
    }

    /// Computes element by element, from reset.
    ///
    /// # Errors
    /// Operands of different lengths, or a unit that hangs or fails.
    pub fn run(
        &self,
        batches: &[VectorBatch<'_>],
        stalls: &Stalls,
        seed: u64,
    ) -> Result<VectorRun, RtlError> {
        let vectors = Vectors::new(batches, self.lanes)?;
        let mut collect = Collect {
            vectors: &vectors,
            results: Vec::with_capacity(vectors.elements()),
            times: Vec::with_capacity(vectors.list.len()),
            taken: 0,
        };
        let totals = self.watch(&vectors, stalls, seed, 0, &mut collect)?;
        Ok(VectorRun {
            results: collect.results,
            vectors: collect.times,
            totals,
        })
    }

    /// Runs under a watch, and `drain` cycles more after the last results.
    pub(super) fn watch(
        &self,
        vectors: &Vectors<'_>,
        stalls: &Stalls,
        seed: u64,
        drain: u64,
        watch: &mut impl VectorWatch,
    ) -> Result<VectorTotals, RtlError> {
        let drive = Drive {
            vectors,
            plan: Plan::new(seed, stalls)?,
            drain,
            watch,
        };
        self.runner.run(seed, drive)
    }

    /// The same run again, with a dump of a window of it. The watch's failure
    /// comes back some cycles late.
    pub(super) fn dump(
        &self,
        vectors: &Vectors<'_>,
        stalls: &Stalls,
        seed: u64,
        drain: u64,
        watch: impl VectorWatch,
        window: Window,
    ) -> Result<VectorTotals, RtlError> {
        let drive = Drive {
            vectors,
            plan: Plan::new(seed, stalls)?,
            drain: drain + LINGER,
            watch: &mut Linger::new(watch),
        };
        self.runner.run_dumped(seed, window, drive)
    }
}

/// One run, on whatever engine.
struct Drive<'a, W> {
    vectors: &'a Vectors<'a>,
    plan: Plan,
    drain: u64,
    watch: &'a mut W,
}

impl<W: VectorWatch> Job for Drive<'_, W> {
    type Output = VectorTotals;

    fn run<E: Engine>(self, engine: &mut E) -> Result<VectorTotals, RtlError> {
        let Self {
            vectors,
            mut plan,
            drain,
            watch,
        } = self;
        let input = |name: &str| engine.port(&format!("s_axis_vec_{name}"));
        let output = |name: &str| engine.port(&format!("m_axis_vec_{name}"));
        let [valid, ready, data, keep, last, user] = [
            input("tvalid")?,
            input("tready")?,
            input("tdata")?,
            input("tkeep")?,
            input("tlast")?,
            input("tuser")?,
        ];
        let [out_valid, out_ready, out_data, out_keep, out_last] = [
            output("tvalid")?,
            output("tready")?,
            output("tdata")?,
            output("tkeep")?,
            output("tlast")?,
        ];
        let stat = |name: &str| engine.port(&format!("stat_{name}"));
        let counters = [stat("vectors")?, stat("busy")?, stat("stall_out")?];
        let errors = stat("errors")?;
        let clear = engine.port("cfg_clear")?;
        for port in [valid, out_ready, clear] {
            engine.set(port, 0)?;
        }
        engine.reset()?;
        let mut source = Source::new(vectors.list.iter());
        let mut operands = vec![0u32; engine.words(data)];
        let mut kept = vec![0u32; engine.words(keep)];
        let mut results = vec![0u32; engine.words(out_data)];
        let mut lanes = vec![0u32; engine.words(out_keep)];
        let mut totals = VectorTotals::default();
        let (mut taken, mut idle, mut left, mut shown) = (0, 0, drain, false);
        for cycle in 0.. {
            if taken == vectors.list.len() {
                if left == 0 {
                    break;
                }
                left -= 1;
            }
            let willing = plan.step();
            let vector = source.offer(willing.rit).map(|v| **v);
            engine.set(valid, u64::from(vector.is_some()))?;
            engine.set(out_ready, u64::from(willing.sink))?;
            if let Some(v) = vector.filter(|_| !shown) {
                operands.fill(0);
                kept.fill(0);
                for (i, (a, b)) in v.a.iter().zip(v.b).enumerate() {
                    operands[2 * i] = *a as u32;
                    operands[2 * i + 1] = *b as u32;
                    kept[i / 32] |= 1 << (i % 32);
                }
                engine.set_words(data, &operands)?;
                engine.set_words(keep, &kept)?;
                engine.set(last, u64::from(v.last))?;
                engine.set(user, u64::from(v.op.field()))?;
                shown = true;
            }
            engine.settle()?;
            let offered = engine.get(out_valid)? == 1;
            let mut counted = [0; 3];
            for (value, port) in counted.iter_mut().zip(counters) {
                *value = engine.get(port)?;
            }
            let result = if offered {
                engine.get_words(out_data, &mut results)?;
                engine.get_words(out_keep, &mut lanes)?;
                Some(ResultSeen {
                    data: &results,
                    unknown: engine.unknown(out_data),
                    keep: &lanes,
                    last: engine.get(out_last)? == 1,
                })
            } else {
                None
            };
            let seen = VectorSeen {
                ready: engine.get(ready)? == 1,
                result,
                counters: counted,
            };
            let inputs = VectorInputs {
                op: vector.map(|v| v.op.code.code()),
                ready: willing.sink,
            };
            let moved = [vector.is_some() && seen.ready, offered && willing.sink];
            watch.cycle(cycle, &inputs, &seen)?;
            if moved[0] {
                source.accepted();
                shown = false;
            }
            if moved[1] {
                taken += 1;
                totals.cycles = cycle + 1;
            }
            engine.edge()?;
            idle = if moved.contains(&true) { 0 } else { idle + 1 };
            if idle > PATIENCE.max(drain) {
                return Err(RtlError::Hang {
                    unit: VECTOR_UNIT,
                    cycles: idle,
                    state: format!("{taken} of {} vectors came back", vectors.list.len()),
                });
            }
        }
        engine.settle()?;
        totals.vectors = engine.get(counters[0])?;
        totals.busy = engine.get(counters[1])?;
        totals.stall_out = engine.get(counters[2])?;
        totals.errors = engine.get(errors)?;
        Ok(totals)
    }
}

/// Gathers the results of a run.
struct Collect<'a> {
    vectors: &'a Vectors<'a>,
    results: Vec<i32>,
    times: Vec<(u64, u64)>,
    taken: usize,
}

impl VectorWatch for Collect<'_> {
    fn cycle(
        &mut self,
        cycle: u64,
        inputs: &VectorInputs,
        seen: &VectorSeen<'_>,
    ) -> Result<(), RtlError> {
        if let Some(result) = seen.result.filter(|_| inputs.ready) {
            let wrong = || RtlError::Usage("the unit gave more vectors than it got".to_owned());
            let vector = self.vectors.list.get(self.taken).ok_or_else(wrong)?;
            let results = &result.data[..vector.a.len()];
            self.results.extend(results.iter().map(|w| *w as i32));
            self.times.get_mut(self.taken).ok_or_else(wrong)?.1 = cycle;
            self.taken += 1;
        }
        if inputs.op.is_some() && seen.ready {
            self.times.push((cycle, 0));
        }
        Ok(())
    }
}
