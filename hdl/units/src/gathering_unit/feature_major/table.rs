//! The MVoxel feature table, feature-major: bank `row mod B` holds all channels of a row, one word
//! for each channel.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{Feed, IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::passes::{Passes, Settings};
use super::shape::Shape;
use crate::circuits::{bits_for, is, plus_one, popcount};
use crate::gathering_unit::shared::table_checks::table_checks;
use crate::gathering_unit::shared::table_halves::TableHalves;
use crate::memory::{Size, halves};

/// Builds `mft`. A beat carries one channel of B rows, one word for each bank; banks read
/// independently.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn table(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let shape = Shape::of(config);
    let bits = config.gu.feature_bits;
    let size = Size {
        words: shape.rows,
        bits,
    };
    let bank = halves("mft_halves", size, 1)?;
    let mut builder = ModuleBuilder::new("mft");
    let m = &mut builder;
    m.doc(
        "double-buffered, feature-major MVoxel feature table. Bank b holds every channel of the \
         rows b, b + B, b + 2B and so on.",
    );
    let inputs = Inputs::declare(m, &shape, bits);
    let table = TableHalves::declare(m, Ty::u(shape.rows_bits()));
    let written = write(m, &shape, &inputs, &table);
    let readable = table.advance(m, written.done, written.rows_after, inputs.release);
    m.section("Reader");
    let write_line = m.truncate(written.block, shape.line_bits);
    let write_address = m.cat(&[write_line, written.channel]);
    let write_address = m.name(write_address, "write_address");
    let some_read = m.any(inputs.read);
    let half_of_words = table.read_last(m, some_read);
    let loaded = table.loaded(m);
    let mut addresses = vec![];
    for b in (0..shape.banks).rev() {
        let line = m.slice(inputs.lines, b * shape.line_bits, shape.line_bits);
        addresses.extend([line, inputs.channel]);
    }
    let addresses = m.cat(&addresses);
    let addresses = m.name(addresses, "addresses");

    m.section("Banks");
    let lanes: Vec<_> = (0..shape.banks)
        .rev()
        .map(|b| m.slice(inputs.data, 16 * b, bits))
        .collect();
    let lanes = m.cat(&lanes);
    let ports = [
        ("we", Feed::Shared(written.write)),
        ("write_half", Feed::Shared(table.write)),
        ("waddr", Feed::Shared(write_address)),
        ("wdata", Feed::Each(lanes)),
        ("read_half", Feed::Shared(table.read)),
        ("loaded", Feed::Shared(loaded)),
        ("half_of_words", Feed::Shared(half_of_words)),
        ("re", Feed::Each(inputs.read)),
        ("raddr", Feed::Each(addresses)),
    ];
    let banks = m.array("bank", &bank, &[("row", shape.banks)], &ports);
    let words = m.all_out(banks, "rdata");

    m.section("Outputs");
    m.output("s_axis_mft_tready", written.ready, "");
    m.output(
        "is_loaded",
        readable.is_loaded,
        "the half to read holds its MVoxel",
    );
    let partly = [written.channel, written.block].map(|position| m.any(position));
    let empty = table.is_empty(m, &[partly[0], partly[1], written.amid]);
    m.output(
        "is_empty",
        empty,
        "no half is loaded, and none is partly written",
    );
    m.output("rows", readable.rows, "rows that the half to read holds");
    m.output("words", words, "what each bank read last");
    m.output(
        "overflow",
        written.overflow,
        "a row past the MVoxel's rows is dropped, or a block is not as it must be",
    );
    table_checks(m, "any(read)");
    builder.finish()
}

/// The inputs.
struct Inputs {
    settings: Settings,
    valid: Signal,
    data: Signal,
    keep: Signal,
    last: Signal,
    read: Signal,
    lines: Signal,
    channel: Signal,
    release: Signal,
}

impl Inputs {
    fn declare(m: &mut ModuleBuilder, shape: &Shape, feature_bits: u32) -> Self {
        let (banks, bit) = (shape.banks, Ty::bit());
        let inputs = Self {
            settings: Settings::inputs(m),
            valid: m.input("s_axis_mft_tvalid", bit, ""),
            data: m.input(
                "s_axis_mft_tdata",
                Ty::u(16 * banks),
                "one channel of B rows, lowest row lowest",
            ),
            keep: m.input("s_axis_mft_tkeep", Ty::u(2 * banks), "rows there are"),
            last: m.input("s_axis_mft_tlast", bit, "ends the MVoxel's segment"),
            read: m.input("read", Ty::u(banks), "banks that read at the clock edge"),
            lines: m.input("lines", Ty::u(banks * shape.line_bits), "line of each"),
            channel: m.input("channel", Ty::u(shape.bank_bits), "channel of all"),
            release: m.input("done", bit, "the half that is read is done with"),
        };
        if feature_bits < 16 {
            m.unused(
                inputs.data,
                "Lanes are 16 bits wide; features fill their low bits.",
            );
        }
        inputs
    }
}

/// Effect of a beat on the writer.
struct Written {
    ready: Signal,
    /// Write enable and address.
    write: Signal,
    channel: Signal,
    block: Signal,
    /// The MVoxel is complete, with its number of rows.
    done: Signal,
    rows_after: Signal,
    overflow: Signal,
    /// Segments of the MVoxel are still to come.
    amid: Signal,
}

/// An accepted beat before its write.
struct Accepted {
    accept: Signal,
    /// Whether it has rows.
    some: Signal,
    last: Signal,
    /// Whether there is room for it.
    room: Signal,
    /// Whether it is the last channel of its block.
    channel_ends: Signal,
}

fn write(m: &mut ModuleBuilder, shape: &Shape, inputs: &Inputs, halves: &TableHalves) -> Written {
    m.section("Writer");
    let write_channel = m.reg("write_channel", Ty::u(shape.bank_bits), 0);
    let blocks = shape.rows / shape.banks;
    let block_ty = Ty::u(bits_for(blocks));
    let write_block = m.reg("write_block", block_ty, 0);
    m.note(write_block, "B rows that are written together");
    let last = inputs.last;
    let ready = halves.ready(m);
    let accept = m.and(inputs.valid, ready);
    // A beat without rows is none, but for the end that it may mark.
    let some = m.any(inputs.keep);
    let some = m.name(some, "some_rows");
    let counts = m.or(some, last);
    let accept = m.and(accept, counts);
    let accept = m.name(accept, "write_accept");
    let done = m.and(accept, last);
    let done = m.name(done, "write_done");
    let passes = Passes::declare(m, "write", shape, inputs.settings);
    passes.advance(m, done);
    let channel_ends = m.eq(write_channel, passes.top_channel);
    let channel_ends = m.name(channel_ends, "write_ends_block");
    let limit = m.param("MVOXEL_BLOCKS", blocks, block_ty, "");
    let room = m.lt(write_block, limit);
    let room = m.name(room, "write_room");
    let write = m.and(accept, room);
    let write = m.name(write, "write");
    let next_channel = plus_one(m, write_channel);
    let zero_channel = m.lit(0, write_channel.ty());
    let wraps = m.or(channel_ends, last);
    let channel_after = m.mux(wraps, zero_channel, next_channel);
    m.set_next_if(write_channel, accept, channel_after);
    let next_block = plus_one(m, write_block);
    let zero_block = m.lit(0, block_ty);
    let grows = m.and(channel_ends, room);
    let block_after = m.mux(grows, next_block, write_block);
    let block_after = m.mux(last, zero_block, block_after);
    m.set_next_if(write_block, accept, block_after);
    let beat = Accepted {
        accept,
        some,
        last,
        room,
        channel_ends,
    };
    let kept: Vec<_> = (0..shape.banks)
        .map(|b| m.bit(inputs.keep, 2 * b))
        .collect();
    let first_channel = is(m, write_channel, 0);
    let first_channel = m.name(first_channel, "begins_block");
    let block = Block {
        kept: kept.clone(),
        first: first_channel,
        ends: channel_ends,
    };
    let misshapen = block.misshapen(m, inputs.keep, [accept, last, some]);
    let rows_after = rows_after(m, shape, &beat, &kept, write_block);
    let no_room = m.not(room);
    let overflow = m.all_of(&[accept, some, no_room]);
    Written {
        ready,
        write,
        channel: write_channel,
        block: write_block,
        done,
        rows_after,
        overflow: m.or(overflow, misshapen),
        amid: passes.amid(m),
    }
}

/// Rows of the half including this beat: those of earlier blocks, and its own.
fn rows_after(
    m: &mut ModuleBuilder,
    shape: &Shape,
    beat: &Accepted,
    kept: &[Signal],
    write_block: Signal,
) -> Signal {
    let count_ty = Ty::u(shape.rows_bits());
    let kept = popcount(m, kept);
    let kept = m.extend(kept, count_ty.width);
    let none = m.lit(0, count_ty);
    let kept = m.mux(beat.room, kept, none);
    let kept = m.name(kept, "rows_of_block");
    let before = m.extend(write_block, count_ty.width);
    let before = m.shl_const(before, shape.bank_bits);
    let with_block = m.add(before, kept);
    let with_block = m.name(with_block, "rows_with_block");
    let held = m.reg("rows_held", count_ty, 0);
    m.note(held, "rows of the blocks that are written");
    let rows_after = m.mux(beat.some, with_block, held);
    let rows_after = m.name(rows_after, "rows_after");
    let held_after = m.mux(beat.last, none, rows_after);
    let block_over = m.or(beat.channel_ends, beat.last);
    let block_over = m.and(beat.accept, block_over);
    m.set_next_if(held, block_over, held_after);
    rows_after
}

/// Position of a beat in its block: one channel of B rows.
struct Block {
    /// Whether each row is present.
    kept: Vec<Signal>,
    /// Whether it is the block's first channel, and whether it is the last.
    first: Signal,
    ends: Signal,
}

impl Block {
    /// Whether a beat violates the rules of blocks: whole rows from row 0 on, the same rows for
    /// every channel, fewer than B in the last block only, and an end after the last channel.
    fn misshapen(
        &self,
        m: &mut ModuleBuilder,
        keep: Signal,
        [accept, last, some]: [Signal; 3],
    ) -> Signal {
        let mut wrong = vec![];
        for (b, low) in self.kept.iter().enumerate() {
            let high = m.bit(keep, 2 * b as u32 + 1);
            wrong.push(m.xor(*low, high));
            if b > 0 {
                let gap = m.not(self.kept[b - 1]);
                wrong.push(m.and(*low, gap));
            }
        }
        let highest_first: Vec<_> = self.kept.iter().rev().copied().collect();
        let rows = m.cat(&highest_first);
        let of_block = m.data_reg("block_rows", rows.ty());
        m.note(of_block, "rows that the block's first channel has");
        let begins = m.all_of(&[accept, some, self.first]);
        m.set_next_if(of_block, begins, rows);
        let later = m.not(self.first);
        let differs = m.ne(rows, of_block);
        wrong.push(m.and(later, differs));

        let partial = m.reg("block_partial", Ty::bit(), 0);
        m.note(partial, "the block before has fewer than B rows");
        let over = m.or(self.ends, last);
        let over = m.and(accept, over);
        let full = m.all(keep);
        let not_full = m.not(full);
        let goes_on = m.not(last);
        let then_partial = m.and(not_full, goes_on);
        m.set_next_if(partial, over, then_partial);
        wrong.push(m.and(self.first, partial));
        let amid = m.not(self.ends);
        wrong.push(m.and(last, amid));
        let wrong = m.any_of(&wrong);
        let with_rows = m.and(some, wrong);
        let none = m.not(some);
        let without = m.all_of(&[none, last, later]);
        let wrong = m.or(with_rows, without);
        let wrong = m.and(accept, wrong);
        m.name(wrong, "block_misshapen")
    }
}
