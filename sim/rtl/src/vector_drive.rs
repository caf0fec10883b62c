//! Drives the vector unit's ports, cycle by cycle.

use potamoi_cycles::{Exponents, Plan, Source, VectorInputs};
use potamoi_formats::units::{VECTOR_UNIT, VectorOp};

use super::engine::{Engine, Job};
use super::model::RtlError;
use super::post_failure_window::PostFailureWindow;

/// Cycles without a handshake after which a unit counts as hanging.
const PATIENCE: u64 = 20_000;

/// One operation on operands of equal length; it begins a new vector.
#[derive(Debug, Clone, Copy)]
pub struct VectorBatch<'a> {
    /// The operation.
    pub op: VectorOp,
    /// First operands.
    pub a: &'a [i32],
    /// Second operands, as many as first ones.
    pub b: &'a [i32],
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
    /// Smallest exponent; used with early termination only.
    pub(super) exponent: u32,
    /// Index of the first element among those of all batches.
    pub(super) ordinal: usize,
    /// Whether it is the batch's last.
    pub(super) last: bool,
}

impl<'a> Vectors<'a> {
    pub(super) fn new(
        batches: &[VectorBatch<'a>],
        lanes: usize,
        exponents: &Exponents,
    ) -> Result<Self, RtlError> {
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
                    exponent: exponents.least(batch.op.code, a),
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

/// Outputs of the unit in one cycle.
pub(super) struct VectorSeen<'a> {
    pub(super) ready: bool,
    pub(super) idle: bool,
    /// Results and valid lanes, if any.
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

/// Cycles and counters of a run.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct VectorTotals {
    /// Cycles until the last results were accepted.
    pub cycles: u64,
    /// Vectors accepted, by the unit's counter.
    pub vectors: u64,
    /// Cycles in which a vector was accepted or stepped, by the unit's counter.
    pub busy: u64,
    /// Cycles in which a vector was refused only by back-pressure, by the unit's counter.
    pub stall_out: u64,
    /// Its sticky flags.
    pub errors: u64,
}

/// One run on any engine.
pub(super) struct Drive<'a, W> {
    pub(super) vectors: &'a Vectors<'a>,
    pub(super) plan: Plan,
    /// Cycles observed after the last results.
    pub(super) drain: u64,
    pub(super) watch: &'a mut W,
}

/// The unit's ports.
struct Ports<P> {
    /// Valid, ready, data, keep, last, user.
    input: [P; 6],
    /// Valid, ready, data, keep, last.
    output: [P; 5],
    /// Vectors, busy, stalls.
    counters: [P; 3],
    errors: P,
    idle: P,
}

impl<P: Copy> Ports<P> {
    fn find<E: Engine<Port = P>>(engine: &E) -> Result<Self, RtlError> {
        let input = |name: &str| engine.port(&format!("s_axis_vec_{name}"));
        let output = |name: &str| engine.port(&format!("m_axis_vec_{name}"));
        let stat = |name: &str| engine.port(&format!("stat_{name}"));
        Ok(Self {
            input: [
                input("tvalid")?,
                input("tready")?,
                input("tdata")?,
                input("tkeep")?,
                input("tlast")?,
                input("tuser")?,
            ],
            output: [
                output("tvalid")?,
                output("tready")?,
                output("tdata")?,
                output("tkeep")?,
                output("tlast")?,
            ],
            counters: [stat("vectors")?, stat("busy")?, stat("stall_out")?],
            errors: stat("errors")?,
            idle: engine.port("idle")?,
        })
    }

    fn counters<E: Engine<Port = P>>(&self, engine: &E) -> Result<[u64; 3], RtlError> {
        let [vectors, busy, stalls] = self.counters.map(|port| engine.get(port));
        Ok([vectors?, busy?, stalls?])
    }
}

/// Sets the `tkeep` of the first lanes, with so many bytes a lane.
pub(super) fn keep_lanes(keep: &mut [u32], lanes: usize, bytes: usize) {
    for byte in 0..lanes * bytes {
        keep[byte / 32] |= 1 << (byte % 32);
    }
}

/// Port words: operands with their valid lanes, and results with theirs.
struct VectorWords {
    operands: Vec<u32>,
    kept: Vec<u32>,
    results: Vec<u32>,
    lanes: Vec<u32>,
}

impl VectorWords {
    fn new<E: Engine>(engine: &E, ports: &Ports<E::Port>) -> Self {
        let words = |port| vec![0u32; engine.words(port)];
        Self {
            operands: words(ports.input[2]),
            kept: words(ports.input[3]),
            results: words(ports.output[2]),
            lanes: words(ports.output[3]),
        }
    }

    /// Drives a vector on the input.
    fn show<E: Engine>(
        &mut self,
        engine: &mut E,
        ports: &Ports<E::Port>,
        vector: &Vector<'_>,
    ) -> Result<(), RtlError> {
        self.operands.fill(0);
        self.kept.fill(0);
        for (i, (a, b)) in vector.a.iter().zip(vector.b).enumerate() {
            self.operands[2 * i] = *a as u32;
            self.operands[2 * i + 1] = *b as u32;
        }
        keep_lanes(&mut self.kept, vector.a.len(), 8);
        let [_, _, data, keep, last, user] = ports.input;
        engine.set_words(data, &self.operands)?;
        engine.set_words(keep, &self.kept)?;
        engine.set(last, u64::from(vector.last))?;
        engine.set(user, u64::from(vector.op.field()))
    }

    /// The results on the output, if it is valid.
    fn seen<'a, E: Engine>(
        &'a mut self,
        engine: &'a E,
        ports: &Ports<E::Port>,
    ) -> Result<Option<ResultSeen<'a>>, RtlError> {
        let [valid, _, data, keep, last] = ports.output;
        if engine.get(valid)? != 1 {
            return Ok(None);
        }
        engine.get_words(data, &mut self.results)?;
        engine.get_words(keep, &mut self.lanes)?;
        Ok(Some(ResultSeen {
            data: &self.results,
            unknown: engine.unknown(data),
            keep: &self.lanes,
            last: engine.get(last)? == 1,
        }))
    }
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
        let ports = Ports::find(engine)?;
        let ([valid, ready, ..], [_, out_ready, ..]) = (ports.input, ports.output);
        for port in [valid, out_ready, engine.port("cfg_clear")?] {
            engine.set(port, 0)?;
        }
        engine.reset()?;
        let mut source = Source::new(vectors.list.iter());
        let mut words = VectorWords::new(engine, &ports);
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
            if let Some(vector) = vector.filter(|_| !shown) {
                words.show(engine, &ports, &vector)?;
                shown = true;
            }
            engine.settle()?;
            let seen = VectorSeen {
                ready: engine.get(ready)? == 1,
                idle: engine.get(ports.idle)? == 1,
                counters: ports.counters(engine)?,
                result: words.seen(engine, &ports)?,
            };
            let inputs = VectorInputs {
                op: vector.map(|v| v.op.code.code()),
                exponent: vector.map_or(0, |v| v.exponent),
                ready: willing.sink,
            };
            let moved = [
                vector.is_some() && seen.ready,
                seen.result.is_some() && willing.sink,
            ];
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
        [totals.vectors, totals.busy, totals.stall_out] = ports.counters(engine)?;
        totals.errors = engine.get(ports.errors)?;
        Ok(totals)
    }
}

impl<W: VectorWatch> VectorWatch for PostFailureWindow<W> {
    fn cycle(
        &mut self,
        cycle: u64,
        inputs: &VectorInputs,
        seen: &VectorSeen<'_>,
    ) -> Result<(), RtlError> {
        self.after(|w| w.cycle(cycle, inputs, seen))
    }
}
