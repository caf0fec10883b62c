//! One lane: a ray sample's entry, its requests, its side of the crossbar, and
//! its reducer.

use std::sync::Arc;

use potamoi_formats::config::{Config, Modes};
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::shape::Shape;
use crate::circuits::ram;
use crate::gathering_unit::shared::reducer::reducer;

/// Words of a lane's entries: two halves of eight vertices.
const ENTRY_WORDS: u32 = 16;

/// Builds `gather_lane`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn lane(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let shape = Shape::of(config);
    let gu = &config.gu;
    let (banks, bits) = (shape.banks, gu.feature_bits);
    let weighs = gu.modes != Modes::Unstructured;
    let weight_bits = if weighs { gu.weight_bits + 1 } else { 0 };
    let (bit, slot_ty) = (Ty::bit(), Ty::u(config.rit.slot_bits));
    let entry_ram = ram("lane_entries", ENTRY_WORDS, 16 + weight_bits, 1)?;
    let slot_ram = ram("lane_slots", 2, slot_ty.width, 1)?;
    let reducer_module = reducer(config)?;
    let mut builder = ModuleBuilder::new("gather_lane");
    let m = &mut builder;
    m.doc(&format!(
        "one lane: holds two entries, asks {banks} banks for their rows, and reduces what the crossbar brings."
    ));

    m.section("Entries: one is loaded while the other is gathered");
    let write = m.input("write", bit, "a vertex for this lane");
    let write_half = m.input("write_half", bit, "");
    let write_vertex = m.input("write_vertex", Ty::u(3), "");
    let write_kept = m.input("write_kept", bit, "the entry is one");
    let write_entry = m.input("write_entry", bit, "the lane's entry is complete or void");
    let row = m.input("row", Ty::u(16), "");
    let slot = m.input("slot", slot_ty, "");
    let read = m.input("read", bit, "the next step begins after the clock edge");
    let read_half = m.input("read_half", bit, "");
    let read_vertex = m.input("read_vertex", Ty::u(3), "");
    let word = if weighs {
        let weight = m.input("weight", Ty::u(weight_bits), "");
        m.cat(&[weight, row])
    } else {
        row
    };
    let waddr = m.cat(&[write_half, write_vertex]);
    let raddr = m.cat(&[read_half, read_vertex]);
    let entries = m.instance(
        "entries",
        &entry_ram,
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
        &slot_ram,
        &[
            ("we", write_slot),
            ("waddr", write_half),
            ("wdata", slot),
            ("re", read),
            ("raddr", read_half),
        ],
    );
    let kept = [0, 1].map(|h| {
        let kept = m.reg(&format!("kept_{h}"), bit, 0);
        let here = if h == 1 {
            write_half
        } else {
            m.not(write_half)
        };
        let here = m.and(write_entry, here);
        m.set_next_if(kept, here, write_kept);
        kept
    });

    m.section("The step: asks until it is granted");
    let fire = m.input("fire", bit, "a round of the step");
    let granted = m.input("granted", bit, "the round serves this lane");
    let word = m.out(entries, "rdata");
    let step_row = m.slice(word, 0, 16);
    let step_row = m.name(step_row, "step_row");
    let step_kept = m.reg("step_kept", bit, 0);
    let next_kept = m.mux(read_half, kept[1], kept[0]);
    m.set_next_if(step_kept, read, next_kept);
    let pending = m.reg("pending", bit, 0);
    let served = m.and(fire, granted);
    let served = m.name(served, "served");
    let waits = m.not(served);
    let left = m.and(pending, waits);
    let pending_after = m.mux(read, next_kept, left);
    m.set_next(pending, pending_after);
    let bank = m.slice(step_row, 0, shape.bank_bits);
    let bank = m.name(bank, "bank");
    let wants: Vec<_> = (0..banks)
        .rev()
        .map(|b| {
            let b = m.lit(b, bank.ty());
            let mine = m.eq(bank, b);
            m.and(pending, mine)
        })
        .collect();
    let wants = m.cat(&wants);
    let line = m.slice(step_row, shape.bank_bits, shape.line_bits);

    m.section("Stage D: the banks' words");
    let rows = m.input("rows", Ty::u(shape.rows_bits()), "rows that are loaded");
    let words = m.input("words", Ty::u(banks * bits), "what each bank read last");
    let completes = m.input("completes", bit, "the last round of a channel");
    let (row_wide, rows_wide) = (m.extend(step_row, 17), m.extend(rows, 17));
    let in_range = m.lt(row_wide, rows_wide);
    let d_served = m.reg("d_served", bit, 0);
    m.set_next(d_served, served);
    let stage = |m: &mut ModuleBuilder, name: &str, from: Signal, en: Signal| {
        let reg = m.reg(name, from.ty(), 0);
        m.set_next_if(reg, en, from);
        reg
    };
    let d_bank = stage(m, "d_bank", bank, served);
    let d_in_range = stage(m, "d_in_range", in_range, served);
    let step_slot = m.out(slots, "rdata");
    let d_slot = stage(m, "d_slot", step_slot, completes);
    let d_kept = stage(m, "d_kept", step_kept, completes);

    m.section("Crossbar: the word of the lane's bank");
    let of_bank: Vec<_> = (0..banks).map(|b| m.slice(words, b * bits, bits)).collect();
    let crossed = m.select(d_bank, &of_bank);
    let crossed = m.name(crossed, "crossed");
    let mask = m.repeat(d_in_range, bits);
    let feature = m.and(crossed, mask);

    m.section("Stage X: into the reducer");
    let d_completes = m.input("d_completes", bit, "completes, one cycle later");
    let x_completes = m.input("x_completes", bit, "completes, two cycles later");
    let x_served = m.reg("x_served", bit, 0);
    m.set_next(x_served, d_served);
    let x_feature = stage(m, "x_feature", feature, d_served);
    let x_feature = m.as_signed(x_feature);
    let mut inputs = vec![("valid", x_served), ("feature", x_feature)];
    if weighs {
        let first = m.input("first", bit, "the step is of vertex 0");
        let weight = m.slice(word, 16, weight_bits);
        let d_first = stage(m, "d_first", first, served);
        let d_weight = stage(m, "d_weight", weight, served);
        let x_first = stage(m, "x_first", d_first, d_served);
        let x_weight = stage(m, "x_weight", d_weight, d_served);
        inputs.extend([("first", x_first), ("weight", x_weight)]);
    }
    let inst = m.instance(reducer_module.name(), &reducer_module, &inputs);
    let result = m.out(inst, "result");
    let x_slot = stage(m, "x_slot", d_slot, d_completes);
    let x_kept = stage(m, "x_kept", d_kept, d_completes);
    let slot_out = stage(m, "s_slot", x_slot, x_completes);
    let kept_out = stage(m, "s_kept", x_kept, x_completes);

    m.section("Outputs");
    m.output("wants", wants, "bank that the lane asks, if it does");
    m.output("line", line, "row within that bank");
    m.output("is_pending", pending, "not served yet in this step");
    m.output("kept", step_kept, "the lane holds an entry");
    let outside = m.not(d_in_range);
    let outside = m.and(d_served, outside);
    m.output("outside", outside, "a row that was not loaded");
    m.output("result", result, "of the channel that completes");
    m.output("result_slot", slot_out, "its entry's slot");
    m.output("result_kept", kept_out, "it is of an entry");
    builder.finish()
}
