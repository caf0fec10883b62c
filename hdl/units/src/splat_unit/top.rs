//! The unit: its stages, and the end of a job.

use std::sync::Arc;

use potamoi_formats::config::{Config, SuConfig};
use potamoi_formats::units::SPLAT_UNIT;
use potamoi_netlist::{Instance, IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::formats::{COLOUR_SUM, TRANSMITTANCE, Widths};
use super::limits::ADDRESS;
use super::pixels::pixels;
use super::powers::powers;
use super::rows::{INDEX, rows};
use super::setup::setup;
use super::tiles::tiles;
use crate::circuits::{bits_for, counter, is, ones, sticky};
use crate::fifo::fifo;

/// Rows of spans that wait for their pixels.
const ROWS: u32 = 4;
/// Bits of a record.
const RECORD: u32 = 256;
/// Bytes of a word of the limits.
const WORD: u32 = 4;
/// Bits of a record without its rank.
const USED: u32 = 224;
/// Bits of a tile's column or row in the picture.
const TILE: u32 = 12;

/// Builds the splat unit of a configuration.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub fn splat_unit(config: &Config, su: &SuConfig) -> Result<Arc<Module>, IrErrors> {
    let w = Widths::of(config, su);
    let mut builder = ModuleBuilder::new(SPLAT_UNIT);
    let m = &mut builder;
    m.doc("composites records of Gaussians, in depth order, into the pixels of tiles.");
    let bit = Ty::bit();
    let clear = m.input("cfg_clear", bit, "clears the counters");
    let cap = m.input("cfg_alpha_cap", Ty::u(17), "largest alpha, U0.16");
    let min = m.input("cfg_alpha_min", Ty::u(17), "smaller alphas do not count");
    let stop = m.input(
        "cfg_stop_below",
        Ty::u(38),
        "a pixel ends below it, 36 fraction bits",
    );
    let centred = m.input(
        "cfg_centred",
        bit,
        "pixel centres lie at half a pixel, not at 0",
    );
    let last_slot = m.input(
        "cfg_last_slot",
        Ty::u(w.slot),
        "pixels of tiles 0 to this are given",
    );
    let valid = m.input(
        "s_axis_spl_tvalid",
        bit,
        "a record in a tile, or a word of the limits",
    );
    let data = m.input(
        "s_axis_spl_tdata",
        Ty::u(RECORD),
        "the record; or a word of the limits from bit 8, and its address in bits 6 .. 0",
    );
    let keep = m.input(
        "s_axis_spl_tkeep",
        Ty::u(RECORD / 8),
        "all bytes of a record, four of a word of the limits, or none",
    );
    let last = m.input("s_axis_spl_tlast", bit, "ends the job: pixels follow");
    let user = m.input(
        "s_axis_spl_tuser",
        Ty::u(w.slot + 2 * TILE + 8),
        "slot; the tile's column and row, 12 bits each; its last pixel's column and row, 4 each",
    );
    let sink = m.input("m_axis_pix_tready", bit, "");

    m.section("End of a job");
    let ending = m.reg("ending", bit, 0);
    let tile = m.instance("tile_state", &tiles(&w)?, &[]);
    let draining = m.out(tile, "draining");
    let blocked = m.or(ending, draining);
    let open = m.not(blocked);
    let open = m.name(open, "open");

    m.section("Forms and rows");
    let front = m.instance("front", &setup(&w)?, &[]);
    let takes = m.out(front, "ready");
    let ready = m.and(open, takes);
    let enters = m.and(valid, ready);
    let is_record = m.bit(keep, WORD);
    let begins_word = m.bit(keep, 0);
    let no_record = m.not(is_record);
    let is_word = m.and(begins_word, no_record);
    let limit_we = m.and(enters, is_word);
    let limit_addr = m.slice(data, 0, ADDRESS);
    let limit_data = m.slice(data, 8, w.power + 1);
    let offered = m.all_of(&[valid, open, is_record]);
    let record = m.slice(data, 0, USED);
    let rank = m.slice(data, USED, RECORD - USED);
    m.unused(rank, "the records come in depth order");
    let mut at = 0;
    let mut field = |m: &mut ModuleBuilder, bits: u32| {
        at += bits;
        m.slice(user, at - bits, bits)
    };
    for (port, bits) in [
        ("slot", w.slot),
        ("tile_x", TILE),
        ("tile_y", TILE),
        ("last_x", 4),
        ("last_y", 4),
    ] {
        let value = field(m, bits);
        m.connect(front, port, value);
    }
    for (port, signal) in [
        ("valid", offered),
        ("record", record),
        ("centred", centred),
        ("limit_we", limit_we),
        ("limit_addr", limit_addr),
        ("limit_data", limit_data),
    ] {
        m.connect(front, port, signal);
    }
    let link = |m: &mut ModuleBuilder, from: Instance, out: &str, to: Instance, port: &str| {
        let signal = m.out(from, out);
        m.connect(to, port, signal);
    };
    link(m, front, "out_slot", tile, "tile_addr");
    link(m, tile, "tile_alive", front, "rows_alive");
    let row = m.instance("row_search", &rows(&w)?, &[]);
    link(m, row, "ready", front, "out_ready");
    for (out, port) in [
        ("out_valid", "valid"),
        ("p_start", "p_start"),
        ("q_start", "q_start"),
        ("out_l11", "l11"),
        ("out_l21", "l21"),
        ("out_l22", "l22"),
        ("out_rows", "rows"),
        ("out_search", "search"),
        ("out_limit", "limit"),
        ("out_slot", "slot"),
        ("out_last_x", "last_x"),
        ("out_opacity", "opacity"),
        ("out_colour", "colour"),
    ] {
        link(m, front, out, row, port);
    }
    link(m, row, "live_addr", tile, "row_addr");
    link(m, tile, "row_live", row, "live");

    m.section("Pixels of rows");
    let parts = [
        "out_mask",
        "out_row",
        "out_last",
        "out_index",
        "out_p",
        "out_q",
        "out_beyond",
    ];
    let word: Vec<Signal> = parts
        .iter()
        .map(|port| {
            let part = m.out(row, port);
            m.as_unsigned(part)
        })
        .collect();
    let widths: Vec<u32> = word.iter().map(|part| part.width()).collect();
    let pushes = m.out(row, "push");
    let word = m.cat(&word);
    let queue = fifo("splat_row_fifo", ROWS, word.width())?;
    let queue = m.instance("row_fifo", &queue, &[("push", pushes), ("push_data", word)]);
    let walk = m.instance("pixel_walk", &pixels(&w)?, &[]);
    let pops = m.out(walk, "next_row");
    m.connect(queue, "pop", pops);
    let held = m.reg("rows_held", Ty::u(bits_for(ROWS)), 0);
    let one = m.lit(1, held.ty());
    let (more, less) = (m.add(held, one), m.sub(held, one));
    let next = m.mux(pushes, more, less);
    let changes = m.xor(pushes, pops);
    m.set_next_if(held, changes, next);
    let most = is(m, held, ROWS);
    let room = m.not(most);
    m.connect(row, "room", room);
    link(m, queue, "valid", walk, "valid");
    let word = m.out(queue, "data");
    let mut high = word.width();
    for (port, width) in ["mask", "row", "last", "index", "p", "q", "beyond"]
        .into_iter()
        .zip(widths)
    {
        high -= width;
        let part = m.slice(word, high, width);
        let part = if port == "p" { m.as_signed(part) } else { part };
        m.connect(walk, port, part);
        if port == "index" {
            m.connect(row, "pixel_index", part);
        }
    }
    link(m, row, "pixel_l11", walk, "l11");
    link(m, walk, "limit_index", row, "limit_index");
    link(m, row, "entry_limit", walk, "limit");
    link(m, row, "entry_info", walk, "entry_info");
    link(m, walk, "entry_done", row, "entry_done");

    m.section("Exponentials");
    let power = m.instance("exponential", &powers(config, &w)?, &[]);
    link(m, walk, "out_valid", power, "valid");
    link(m, walk, "out_power", power, "power");
    link(m, walk, "out_info", power, "info");
    link(m, power, "ready", walk, "out_ready");
    let inside =
        [(front, "busy"), (row, "in_flight"), (walk, "out_valid")].map(|(i, n)| m.out(i, n));
    let before = m.any_of(&inside);
    let none = m.not(before);
    let flush = m.and(ending, none);
    let flush = m.name(flush, "flush");
    m.connect(power, "flush", flush);
    link(m, power, "out_valid", tile, "valid");
    link(m, power, "out_results", tile, "results");
    link(m, power, "out_infos", tile, "infos");
    link(m, tile, "pop", power, "pop");
    let after = [power, tile].map(|i| m.out(i, "busy"));
    let works = m.or(after[0], after[1]);
    let rests = m.not(works);
    let drain = m.and(flush, rests);
    let drain = m.name(drain, "drain");
    let begins = m.and(enters, last);
    let not_yet = m.not(drain);
    let stays = m.and(ending, not_yet);
    let next = m.or(begins, stays);
    m.set_next(ending, next);
    for (port, signal) in [
        ("alpha_cap", cap),
        ("alpha_min", min),
        ("stop_below", stop),
        ("last_slot", last_slot),
        ("drain", drain),
        ("out_ready", sink),
    ] {
        m.connect(tile, port, signal);
    }

    m.section("Counters, and flags of broken promises");
    let all = m.lit(ones(RECORD / 8), keep.ty());
    let four = m.lit(ones(WORD), keep.ty());
    let nothing = m.lit(0, keep.ty());
    let right = [all, four, nothing].map(|allowed| m.eq(keep, allowed));
    let right = m.any_of(&right);
    let wrong = m.not(right);
    let torn = m.and(enters, wrong);
    let settings = m.cat(&[cap, min, stop, centred, last_slot]);
    let past = m.data_reg("settings_before", settings.ty());
    m.set_next(past, settings);
    let other = m.ne(settings, past);
    let job_open = m.reg("job_open", bit, 0);
    let [gives, at_last] = ["out_valid", "out_last"].map(|name| m.out(tile, name));
    let given = m.all_of(&[gives, at_last, sink]);
    let not_given = m.not(given);
    let stays = m.and(job_open, not_given);
    let next = m.or(enters, stays);
    m.set_next(job_open, next);
    let busy = job_open;
    let sums = m.out(walk, "summed");
    let [power_valid, power_ready] =
        [(walk, "out_valid"), (power, "ready")].map(|(i, n)| m.out(i, n));
    let kept = m.and(power_valid, power_ready);
    let enters_record = m.and(enters, is_record);
    let [drawn, stopped] = ["drawn", "stopped"].map(|name| m.out(tile, name));
    let moved = m.and(other, busy);
    let flags = [
        sticky(m, "setting_moved", clear, moved),
        sticky(m, "torn_beat", clear, torn),
    ];
    let flags = m.cat(&flags);
    m.output(
        "stat_errors",
        flags,
        "0: bytes kept that are none of the three; 1: a setting moved while the unit was not idle",
    );
    let bits = config.gu.counter_bits;
    for (name, when, doc) in [
        ("stat_busy", busy, "cycles in which it was not idle"),
        ("stat_records", enters_record, "records in tiles"),
        (
            "stat_square_sums",
            sums,
            "pairs of pixel and record whose power was computed",
        ),
        (
            "stat_exponentials",
            kept,
            "of those, the pairs that the cut kept",
        ),
        ("stat_drawn", drawn, "pairs that contribute to a pixel"),
        ("stat_stopped", stopped, "pairs that end a pixel"),
    ] {
        let register = counter(m, name, bits, clear, when, None);
        m.output(name, register, doc);
    }

    m.section("Outputs");
    m.output_low_in_reset("s_axis_spl_tready", ready, "does not depend on tvalid");
    link_out(m, tile);
    let idle = m.not(busy);
    m.output(
        "idle",
        idle,
        "no beat of a job was taken, or all pixels of it were",
    );
    builder.finish()
}

/// The stream of pixels.
fn link_out(m: &mut ModuleBuilder, tile: Instance) {
    let offered = m.out(tile, "out_valid");
    m.output("m_axis_pix_tvalid", offered, "a pixel");
    let left = m.out(tile, "out_transmittance");
    let sums = m.out(tile, "out_colour");
    let pad = m.lit(0, Ty::u(40 - COLOUR_SUM));
    let mut parts = vec![];
    for channel in [2, 1, 0] {
        let sum = m.slice(sums, COLOUR_SUM * channel, COLOUR_SUM);
        parts.extend([pad, sum]);
    }
    let above = m.lit(0, Ty::u(24 - TRANSMITTANCE));
    parts.extend([above, left]);
    let data = m.cat(&parts);
    m.output(
        "m_axis_pix_tdata",
        data,
        "transmittance (24 bits, U1.20); three colour sums (40 bits each, 32 fraction bits)",
    );
    let last = m.out(tile, "out_last");
    m.output("m_axis_pix_tlast", last, "the last pixel");
}

const _: () = assert!(INDEX == 3, "numbers of entries in flight");
