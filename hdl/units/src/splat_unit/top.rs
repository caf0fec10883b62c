//! The unit: its stages, and the end of a job.

use std::sync::Arc;

use potamoi_formats::config::{Config, SuConfig};
use potamoi_formats::units::SPLAT_UNIT;
use potamoi_netlist::{Instance, IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::formats::{COLOUR_SUM, TRANSMITTANCE, Widths};
use super::inputs::{Inputs, RECORD, TILE, WORD};
use super::limits::ADDRESS;
use super::pixels::pixels;
use super::powers::powers;
use super::rows::rows;
use super::setup::setup;
use super::tiles::tiles;
use crate::circuits::{bits_for, counter, is};
use crate::fifo::fifo;

/// Rows of spans that wait for their pixels.
const ROWS: u32 = 4;
/// Bits of a record without its rank.
const USED: u32 = 224;

/// Builds the splat unit of a configuration.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub fn splat_unit(config: &Config, su: &SuConfig) -> Result<Arc<Module>, IrErrors> {
    let w = Widths::of(config, su);
    let mut builder = ModuleBuilder::new(SPLAT_UNIT);
    let m = &mut builder;
    m.doc("composites records of Gaussians, in depth order, into the pixels of tiles.");
    let inputs = Inputs::declare(m, &w);
    m.section("Whether the job ends: its last beat was taken");
    let ending = m.reg("ending", Ty::bit(), 0);
    let parts = Parts {
        tile: m.instance("tile_state", &tiles(&w)?, &[]),
        front: m.instance("front", &setup(&w)?, &[]),
        row: m.instance("row_search", &rows(&w)?, &[]),
        walk: m.instance("pixel_walk", &pixels(&w)?, &[]),
        power: m.instance("exponential", &powers(config, su, &w)?, &[]),
    };
    m.section("Forms and rows");
    let accepted = parts.connect_front(m, &w, &inputs, ending);
    parts.connect_rows(m);
    m.section("Pixels of rows");
    parts.connect_walk(m)?;
    m.section("Exponentials");
    parts.connect_powers(m);
    m.section("Transmittance and colour, and the end of a job");
    parts.connect_end(m, &inputs, (ending, accepted.enters));
    m.section("Counters, and flags of broken promises");
    let busy = parts.job_open(m, &inputs, accepted.enters);
    let bits = config.gu.counter_bits;
    parts.count(m, (inputs.clear, busy), &accepted, bits);
    inputs.flag(m, busy, [accepted.enters, accepted.is_dropped]);
    m.section("Outputs");
    m.output_low_in_reset(
        "s_axis_spl_tready",
        accepted.ready,
        "does not depend on tvalid",
    );
    link_out(m, parts.tile);
    let idle = m.not(busy);
    m.output(
        "idle",
        idle,
        "no beat of a job was taken, or all pixels of it were",
    );
    builder.finish()
}

/// The beat at the input.
struct Accepted {
    ready: Signal,
    enters: Signal,
    /// A record in a tile whose pixels are given.
    is_taken: Signal,
    /// A record in another one.
    is_dropped: Signal,
}

/// Parts of the unit.
struct Parts {
    tile: Instance,
    front: Instance,
    row: Instance,
    walk: Instance,
    power: Instance,
}

/// Connects an output of one part to an input of another.
fn link(m: &mut ModuleBuilder, (from, out): (Instance, &str), (to, port): (Instance, &str)) {
    let signal = m.out(from, out);
    m.connect(to, port, signal);
}

impl Parts {
    /// The beat goes to the forms, or into the table of limits, while no job ends. A record in a tile whose
    /// pixels are not given goes nowhere: what it draws would stay for a later job.
    fn connect_front(
        &self,
        m: &mut ModuleBuilder,
        w: &Widths,
        inputs: &Inputs,
        ending: Signal,
    ) -> Accepted {
        let Inputs { data, keep, .. } = *inputs;
        let draining = m.out(self.tile, "draining");
        let blocked = m.or(ending, draining);
        let open = m.not(blocked);
        let open = m.name(open, "open");
        let takes = m.out(self.front, "ready");
        let ready = m.and(open, takes);
        let ready = m.name(ready, "takes_beat");
        let enters = m.and(inputs.valid, ready);
        let enters = m.name(enters, "enters");
        let is_record = m.bit(keep, WORD);
        let begins_word = m.bit(keep, 0);
        let no_record = m.not(is_record);
        let is_word = m.and(begins_word, no_record);
        let slot = m.slice(inputs.user, 0, w.slot);
        let is_given = m.le(slot, inputs.last_slot);
        let is_given = m.name(is_given, "tile_is_given");
        let is_taken = m.and(is_record, is_given);
        let is_taken = m.name(is_taken, "is_taken");
        let not_given = m.not(is_given);
        let is_dropped = m.and(is_record, not_given);
        let rank = m.slice(data, USED, RECORD - USED);
        m.unused(rank, "the records come in depth order");
        for (port, signal) in [
            ("valid", m.all_of(&[inputs.valid, open, is_taken])),
            ("record", m.slice(data, 0, USED)),
            ("centred", inputs.centred),
            ("limit_we", m.and(enters, is_word)),
            ("limit_addr", m.slice(data, 0, ADDRESS)),
            ("limit_data", m.slice(data, 8, w.power + 1)),
        ] {
            m.connect(self.front, port, signal);
        }
        let mut at = 0;
        for (port, bits) in [
            ("slot", w.slot),
            ("tile_x", TILE),
            ("tile_y", TILE),
            ("last_x", 4),
            ("last_y", 4),
        ] {
            let field = m.slice(inputs.user, at, bits);
            m.connect(self.front, port, field);
            at += bits;
        }
        Accepted {
            ready,
            enters,
            is_taken,
            is_dropped,
        }
    }

    /// Rows of a record, and their live pixels.
    fn connect_rows(&self, m: &mut ModuleBuilder) {
        let Self {
            tile, front, row, ..
        } = *self;
        link(m, (front, "out_slot"), (tile, "tile_addr"));
        link(m, (tile, "tile_alive"), (front, "rows_alive"));
        link(m, (row, "ready"), (front, "out_ready"));
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
            link(m, (front, out), (row, port));
        }
        link(m, (row, "live_addr"), (tile, "row_addr"));
        link(m, (tile, "row_live"), (row, "live"));
    }

    /// Rows wait in a FIFO for their pixels.
    fn connect_walk(&self, m: &mut ModuleBuilder) -> Result<(), IrErrors> {
        let Self { row, walk, .. } = *self;
        let fields = ["mask", "row", "last", "index", "p", "q", "beyond"];
        let parts = fields.map(|field| m.out(row, &format!("out_{field}")));
        let word = parts.map(|part| m.as_unsigned(part));
        let word = m.cat(&word);
        let queue = fifo("splat_row_fifo", ROWS, word.width())?;
        let [pushes, pops] = [(row, "push"), (walk, "next_row")].map(|(i, n)| m.out(i, n));
        let links = [("push", pushes), ("push_data", word), ("pop", pops)];
        let queue = m.instance("row_fifo", &queue, &links);
        let held = m.reg("rows_held", Ty::u(bits_for(ROWS)), 0);
        let one = m.lit(1, held.ty());
        let (more, less) = (m.add(held, one), m.sub(held, one));
        let next = m.mux(pushes, more, less);
        let changes = m.xor(pushes, pops);
        m.set_next_if(held, changes, next);
        let most = is(m, held, ROWS);
        let room = m.not(most);
        m.connect(row, "room", room);
        link(m, (queue, "valid"), (walk, "valid"));
        let word = m.out(queue, "data");
        let mut high = word.width();
        for (field, part) in fields.into_iter().zip(parts) {
            high -= part.width();
            let value = m.slice(word, high, part.width());
            let value = match field {
                "p" => m.as_signed(value),
                _ => value,
            };
            m.connect(walk, field, value);
            if field == "index" {
                m.connect(row, "pixel_index", value);
            }
        }
        link(m, (walk, "limit_index"), (row, "limit_index"));
        link(m, (walk, "entry_done"), (row, "entry_done"));
        link(m, (row, "pixel_l11"), (walk, "l11"));
        link(m, (row, "entry_limit"), (walk, "limit"));
        link(m, (row, "entry_info"), (walk, "entry_info"));
        Ok(())
    }

    fn connect_powers(&self, m: &mut ModuleBuilder) {
        let Self {
            walk, power, tile, ..
        } = *self;
        link(m, (walk, "out_valid"), (power, "valid"));
        link(m, (walk, "out_power"), (power, "power"));
        link(m, (walk, "out_info"), (power, "info"));
        link(m, (power, "ready"), (walk, "out_ready"));
        link(m, (power, "out_valid"), (tile, "valid"));
        link(m, (power, "out_results"), (tile, "results"));
        link(m, (power, "out_infos"), (tile, "infos"));
        link(m, (tile, "pop"), (power, "pop"));
    }

    /// The end of a job: the last vector is filled up when no pair is before the lanes, and the pixels
    /// are given when none is behind.
    fn connect_end(
        &self,
        m: &mut ModuleBuilder,
        inputs: &Inputs,
        (ending, enters): (Signal, Signal),
    ) {
        let inside = [
            (self.front, "busy"),
            (self.row, "in_flight"),
            (self.walk, "out_valid"),
        ];
        let inside = inside.map(|(part, name)| m.out(part, name));
        let before = m.any_of(&inside);
        let none = m.not(before);
        let flush = m.and(ending, none);
        let flush = m.name(flush, "flush");
        m.connect(self.power, "flush", flush);
        let after = [self.power, self.tile].map(|part| m.out(part, "busy"));
        let works = m.or(after[0], after[1]);
        let rests = m.not(works);
        let drain = m.and(flush, rests);
        let drain = m.name(drain, "drain");
        let begins = m.and(enters, inputs.last);
        let not_yet = m.not(drain);
        let stays = m.and(ending, not_yet);
        let next = m.or(begins, stays);
        m.set_next(ending, next);
        for (port, signal) in [
            ("alpha_cap", inputs.cap),
            ("alpha_min", inputs.min),
            ("stop_below", inputs.stop),
            ("last_slot", inputs.last_slot),
            ("drain", drain),
            ("out_ready", inputs.sink),
        ] {
            m.connect(self.tile, port, signal);
        }
    }

    /// Whether a job is open: from its first beat to its last pixel.
    fn job_open(&self, m: &mut ModuleBuilder, inputs: &Inputs, enters: Signal) -> Signal {
        let job_open = m.reg("job_open", Ty::bit(), 0);
        let [gives, at_last] = ["out_valid", "out_last"].map(|name| m.out(self.tile, name));
        let given = m.all_of(&[gives, at_last, inputs.sink]);
        let not_given = m.not(given);
        let stays = m.and(job_open, not_given);
        let next = m.or(enters, stays);
        m.set_next(job_open, next);
        job_open
    }

    fn count(
        &self,
        m: &mut ModuleBuilder,
        (clear, busy): (Signal, Signal),
        accepted: &Accepted,
        bits: u32,
    ) {
        let [offers, takes] =
            [(self.walk, "out_valid"), (self.power, "ready")].map(|(part, n)| m.out(part, n));
        let counted = [
            ("stat_busy", busy, "cycles in which it was not idle"),
            (
                "stat_records",
                m.and(accepted.enters, accepted.is_taken),
                "records in tiles that are given",
            ),
            (
                "stat_square_sums",
                m.out(self.walk, "summed"),
                "pairs of pixel and record whose power was computed",
            ),
            (
                "stat_exponentials",
                m.and(offers, takes),
                "of those, the pairs that the cut kept",
            ),
            (
                "stat_drawn",
                m.out(self.tile, "drawn"),
                "pairs that contribute to a pixel",
            ),
            (
                "stat_stopped",
                m.out(self.tile, "stopped"),
                "pairs that end a pixel",
            ),
        ];
        for (name, when, doc) in counted {
            let register = counter(m, name, bits, clear, when, None);
            m.output(name, register, doc);
        }
    }
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
