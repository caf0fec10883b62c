//! One lane: entries, requests, crossbar input, and reducer of a ray sample.

use std::sync::Arc;

use potamoi_formats::config::{Config, Modes};
use potamoi_netlist::{Instance, IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::shape::Shape;
use crate::gathering_unit::shared::reducer::reducer;
use crate::memory::{Size, ram_1r1w};

/// Words of a lane's entries: two halves of eight vertices.
const ENTRY_WORDS: u32 = 16;

/// Builds `gather_lane`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn lane(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let shape = Shape::of(config);
    let below = Below::of(config)?;
    let mut builder = ModuleBuilder::new("gather_lane");
    let m = &mut builder;
    m.doc(&format!(
        "one lane: holds two entries, asks {} banks for their rows, and reduces what the crossbar brings.",
        shape.banks
    ));
    let entries = Entries::build(m, config, &below);
    let step = Step::build(m, &shape, &entries);
    let words = StageD::build(m, config, &shape, &entries, &step);
    let reduced = reduce(m, config, &below, &step, &words);
    m.section("Outputs");
    m.output("wants", step.wants, "bank that the lane asks, if it does");
    m.output("line", step.line, "row within that bank");
    m.output("is_pending", step.pending, "not served yet in this step");
    m.output("kept", step.kept, "the lane holds an entry");
    let outside = m.not(words.in_range);
    let outside = m.and(words.served, outside);
    m.output("outside", outside, "a row that was not loaded");
    m.output("result", reduced.result, "of the channel that completes");
    m.output("result_slot", reduced.slot, "its entry's slot");
    m.output("result_kept", reduced.kept, "it is of an entry");
    m.begin_checks();
    m.assert(
        "asks",
        "is_pending -> any(wants)",
        "A lane that is not served yet asks a bank.",
    );
    builder.finish()
}

/// Submodules of a lane.
struct Below {
    entries: Arc<Module>,
    slots: Arc<Module>,
    reducer: Arc<Module>,
    /// Width of a weight in the entry memory, in bits; 0 where no entry has weights.
    weight_bits: u32,
}

impl Below {
    fn of(config: &Config) -> Result<Self, IrErrors> {
        let weight_bits = match config.gu.modes {
            Modes::Unstructured => 0,
            _ => config.gu.weight_bits + 1,
        };
        Ok(Self {
            entries: ram_1r1w(
                "lane_entries",
                Size {
                    words: ENTRY_WORDS,
                    bits: 16 + weight_bits,
                },
            )?,
            slots: ram_1r1w(
                "lane_slots",
                Size {
                    words: 2,
                    bits: config.rit.slot_bits,
                },
            )?,
            reducer: reducer(config)?,
            weight_bits,
        })
    }
}

/// A register that samples `from` with `enable`.
fn stage(m: &mut ModuleBuilder, name: &str, from: Signal, enable: Signal) -> Signal {
    let reg = m.data_reg(name, from.ty());
    m.set_next_if(reg, enable, from);
    reg
}

/// The lane's entries, and the read of the next step.
struct Entries {
    words: Instance,
    slots: Instance,
    /// Whether each half has a valid entry.
    kept: [Signal; 2],
    read: Signal,
    read_half: Signal,
}

impl Entries {
    fn build(m: &mut ModuleBuilder, config: &Config, below: &Below) -> Self {
        m.section("Entries: one is loaded while the other is gathered");
        let bit = Ty::bit();
        let write = m.input("write", bit, "a vertex for this lane");
        let write_half = m.input("write_half", bit, "");
        let write_vertex = m.input("write_vertex", Ty::u(3), "");
        let write_kept = m.input("write_kept", bit, "the vertex is of an entry");
        let write_entry = m.input("write_entry", bit, "the lane's entry is complete or void");
        let row = m.input("row", Ty::u(16), "");
        let slot = m.input("slot", Ty::u(config.rit.slot_bits), "");
        let read = m.input("read", bit, "the next step begins after the clock edge");
        let read_half = m.input("read_half", bit, "");
        let read_vertex = m.input("read_vertex", Ty::u(3), "");
        let word = if below.weight_bits > 0 {
            let weight = m.input("weight", Ty::u(below.weight_bits), "");
            m.cat(&[weight, row])
        } else {
            row
        };
        let waddr = m.cat(&[write_half, write_vertex]);
        let raddr = m.cat(&[read_half, read_vertex]);
        let words = m.instance(
            "entries",
            &below.entries,
            &[
                ("we", write),
                ("waddr", waddr),
                ("wdata", word),
                ("re", read),
                ("raddr", raddr),
            ],
        );
        let write_slot = m.and(write, write_entry);
        let slots = m.instance(
            "slots",
            &below.slots,
            &[
                ("we", write_slot),
                ("waddr", write_half),
                ("wdata", slot),
                ("re", read),
                ("raddr", read_half),
            ],
        );
        // A void entry is settled without a vertex.
        let is_entry = m.and(write, write_kept);
        let kept = [0, 1].map(|h| {
            let kept = m.data_reg(&format!("kept_{h}"), bit);
            let here = if h == 1 {
                write_half
            } else {
                m.not(write_half)
            };
            let here = m.and(write_entry, here);
            m.set_next_if(kept, here, is_entry);
            kept
        });
        Self {
            words,
            slots,
            kept,
            read,
            read_half,
        }
    }
}

/// The current step of the lane.
struct Step {
    /// The vertex: row, with the weight above.
    word: Signal,
    row: Signal,
    kept: Signal,
    pending: Signal,
    /// Whether the lane is served in this round.
    served: Signal,
    bank: Signal,
    wants: Signal,
    line: Signal,
}

impl Step {
    fn build(m: &mut ModuleBuilder, shape: &Shape, entries: &Entries) -> Self {
        m.section("The step: asks until it is granted");
        let bit = Ty::bit();
        let fire = m.input("fire", bit, "a round of the step");
        let granted = m.input("granted", bit, "the round serves this lane");
        let word = m.out(entries.words, "rdata");
        let row = m.slice(word, 0, 16);
        let row = m.name(row, "step_row");
        let kept = m.data_reg("step_kept", bit);
        let next_kept = m.mux(entries.read_half, entries.kept[1], entries.kept[0]);
        m.set_next_if(kept, entries.read, next_kept);
        let pending = m.reg("pending", bit, 0);
        let served = m.and(fire, granted);
        let served = m.name(served, "served");
        let waits = m.not(served);
        let left = m.and(pending, waits);
        let pending_after = m.mux(entries.read, next_kept, left);
        m.set_next(pending, pending_after);
        let bank = m.slice(row, 0, shape.bank_bits);
        let bank = m.name(bank, "bank");
        let wants: Vec<_> = (0..shape.banks)
            .rev()
            .map(|b| {
                let b = m.lit(b, bank.ty());
                let mine = m.eq(bank, b);
                m.and(pending, mine)
            })
            .collect();
        let wants = m.cat(&wants);
        let line = m.slice(row, shape.bank_bits, shape.line_bits);
        Self {
            word,
            row,
            kept,
            pending,
            served,
            bank,
            wants,
            line,
        }
    }
}

/// Stage D: the banks' words, from which the lane selects one.
struct StageD {
    served: Signal,
    in_range: Signal,
    slot: Signal,
    kept: Signal,
    feature: Signal,
}

impl StageD {
    fn build(
        m: &mut ModuleBuilder,
        config: &Config,
        shape: &Shape,
        entries: &Entries,
        step: &Step,
    ) -> Self {
        m.section("Stage D: the banks' words");
        let (banks, bits) = (shape.banks, config.gu.feature_bits);
        let rows = m.input("rows", Ty::u(shape.rows_bits()), "rows that are loaded");
        let words = m.input("words", Ty::u(banks * bits), "what each bank read last");
        let completes = m.input("completes", Ty::bit(), "the last round of a channel");
        let (row_wide, rows_wide) = (m.extend(step.row, 17), m.extend(rows, 17));
        let in_range = m.lt(row_wide, rows_wide);
        let served = m.reg("d_served", Ty::bit(), 0);
        m.set_next(served, step.served);
        let bank = stage(m, "d_bank", step.bank, step.served);
        let in_range = stage(m, "d_in_range", in_range, step.served);
        let step_slot = m.out(entries.slots, "rdata");
        let slot = stage(m, "d_slot", step_slot, completes);
        let kept = stage(m, "d_kept", step.kept, completes);

        m.section("Crossbar: the word of the lane's bank");
        let of_bank: Vec<_> = (0..banks).map(|b| m.slice(words, b * bits, bits)).collect();
        let crossed = m.select(bank, &of_bank);
        let crossed = m.name(crossed, "crossed");
        let mask = m.repeat(in_range, bits);
        Self {
            served,
            in_range,
            slot,
            kept,
            feature: m.and(crossed, mask),
        }
    }
}

/// Result of a channel, with its entry.
struct Reduced {
    result: Signal,
    slot: Signal,
    kept: Signal,
}

/// A value of the lane's entry, 0 where it has none.
fn of_entry(m: &mut ModuleBuilder, value: Signal, kept: Signal) -> Signal {
    let bits = m.as_unsigned(value);
    let mask = m.repeat(kept, bits.width());
    m.and(bits, mask)
}

/// Stages X and S: input and result of the reducer.
fn reduce(
    m: &mut ModuleBuilder,
    config: &Config,
    below: &Below,
    step: &Step,
    words: &StageD,
) -> Reduced {
    m.section("Stage X: into the reducer");
    let bit = Ty::bit();
    let d_completes = m.input("d_completes", bit, "completes, one cycle later");
    let x_completes = m.input("x_completes", bit, "completes, two cycles later");
    let served = m.reg("x_served", bit, 0);
    m.set_next(served, words.served);
    let feature = stage(m, "x_feature", words.feature, words.served);
    let feature = m.as_signed(feature);
    let mut inputs = vec![("valid", served), ("feature", feature)];
    if config.gu.modes != Modes::Unstructured {
        let first = m.input("first", bit, "the step is of vertex 0");
        let weight = m.slice(step.word, 16, below.weight_bits);
        let d_first = stage(m, "d_first", first, step.served);
        let d_weight = stage(m, "d_weight", weight, step.served);
        let x_first = stage(m, "x_first", d_first, words.served);
        let x_weight = stage(m, "x_weight", d_weight, words.served);
        inputs.extend([("first", x_first), ("weight", x_weight)]);
    }
    let inst = m.instance(below.reducer.name(), &below.reducer, &inputs);
    let result = m.out(inst, "result");
    let slot = stage(m, "x_slot", words.slot, d_completes);
    let kept = stage(m, "x_kept", words.kept, d_completes);
    let slot = stage(m, "s_slot", slot, x_completes);
    let kept = stage(m, "s_kept", kept, x_completes);
    Reduced {
        // Without an entry the reducer holds an earlier sum, and the slot is not known.
        result: of_entry(m, result, kept),
        slot: of_entry(m, slot, kept),
        kept,
    }
}
