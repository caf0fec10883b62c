//! Tiles in flight: alpha, transmittance and colour of their pixels.
//!
//! | stage | computes |
//! |---|---|
//! | 0 | a lane's exponential, with its opacity, pixel and colour |
//! | 1 | opacity times exponential |
//! | 2 | alpha; the transmittance is read, unless an earlier pair of the pixel is in stages 3 to 5 |
//! | 3 | the transmittance comes; `65536 - alpha` |
//! | 4 | `T (65536 - alpha)` |
//! | 5 | the stop test; the new transmittance is written; the pixel's live bit |
//! | 6 | `T - T'` times the colour; the sums are read |
//! | 7 | the sums come |
//! | 8 | the sums are written |

use std::sync::Arc;

use potamoi_formats::fixed::Rounding;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::drain::{Drain, Port};
use super::formats::{COLOUR_SUM, PIXEL, TRANSMITTANCE, Widths};
use super::live::live;
use super::rows::moved;
use crate::circuits::{bits_for, is, wrapping};
use crate::memory::{Size, ram_1r1w};

/// Alpha 1, U0.16.
const FULL: u32 = 1 << 16;
/// Bits of an alpha, the cap included.
const ALPHA: u32 = 17;
/// Bits of `T (65536 - alpha)`.
const PRODUCT: u32 = TRANSMITTANCE + ALPHA;

/// Registers of a pair in a stage.
#[derive(Clone, Copy)]
struct Pair {
    valid: Signal,
    pixel: Signal,
    colour: Signal,
}

impl Pair {
    fn declare(m: &mut ModuleBuilder, w: &Widths, stage: u32) -> Self {
        Self {
            valid: m.reg(&format!("valid_{stage}"), Ty::bit(), 0),
            pixel: m.data_reg(&format!("pixel_{stage}"), Ty::u(w.pixel())),
            colour: m.data_reg(&format!("colour_{stage}"), Ty::u(48)),
        }
    }

    /// Takes over a pair where `enable`; it is one if `valid`.
    fn take(self, m: &mut ModuleBuilder, from: Self, valid: Signal, enable: Signal) {
        m.set_next_if(self.valid, enable, valid);
        m.set_next_if(self.pixel, enable, from.pixel);
        m.set_next_if(self.colour, enable, from.colour);
    }
}

/// Builds `splat_tiles`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn tiles(w: &Widths) -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("splat_tiles");
    let m = &mut builder;
    m.doc("alpha, transmittance and colour of the pixels of all tiles in flight.");
    let bit = Ty::bit();
    let valid = m.input("valid", bit, "a vector of exponentials");
    let results = m.input(
        "results",
        Ty::u(w.lanes * w.exponential),
        "the first lane lowest",
    );
    let infos = m.input("infos", Ty::u(w.lanes * (w.info() + 1)), "of each lane");
    let cap = m.input("alpha_cap", Ty::u(ALPHA), "largest alpha, U0.16");
    let min = m.input("alpha_min", Ty::u(ALPHA), "smaller alphas do not count");
    let stop = m.input(
        "stop_below",
        Ty::u(PRODUCT),
        "of T (65536 - alpha), 36 fraction bits",
    );
    let last_slot = m.input("last_slot", Ty::u(w.slot), "tiles are given up to this one");
    let drains = m.input("drain", bit, "gives all pixels, and clears them");
    let sink = m.input("out_ready", bit, "the pixel is taken");
    let row = m.input("row_addr", Ty::u(w.slot + 4), "a row of a tile");
    let tile = m.input("tile_addr", Ty::u(w.slot), "a tile");

    m.section("Memories, and the pass that gives and clears them");
    let memory = |name, bits| {
        let words = w.tiles << PIXEL;
        ram_1r1w(name, Size { words, bits })
    };
    let of_transmittance = memory("splat_transmittance", TRANSMITTANCE + 1)?;
    let transmittance = m.instance("transmittance", &of_transmittance, &[]);
    let of_colour = memory("splat_colour", 3 * COLOUR_SUM)?;
    let colours = m.instance("colours", &of_colour, &[]);
    let drain = Drain::build(m, w, drains, sink, last_slot);

    m.section("Pairs in stages");
    let stages = [0, 1, 2, 3, 4, 5, 6].map(|i| Pair::declare(m, w, i));
    let [zero, one, two, three, four, five, six] = stages;
    let busy_pixel = [three, four, five].map(|later| {
        let same = m.eq(two.pixel, later.pixel);
        m.and(later.valid, same)
    });
    let waits = m.any_of(&busy_pixel);
    let waits = m.and(two.valid, waits);
    let waits = m.name(waits, "waits");
    let moves = m.not(waits);
    let moves = m.name(moves, "moves");
    let always = m.lit(1, bit);

    m.section("Lane of the vector");
    let lane = m.reg("lane", Ty::u(bits_for((w.lanes - 1).max(1))), 0);
    let steps = m.and(valid, moves);
    let steps = m.name(steps, "steps");
    let last = is(m, lane, w.lanes - 1);
    let last = m.name(last, "last_lane");
    let pop = m.and(steps, last);
    let pop = m.name(pop, "takes_vector");
    let end = m.lit(w.lanes - 1, lane.ty());
    let next = wrapping(m, lane, end);
    m.set_next_if(lane, steps, next);
    let one_of = |m: &mut ModuleBuilder, all: Signal, width: u32| {
        let lanes = 0..w.lanes;
        let parts: Vec<Signal> = lanes.map(|i| m.slice(all, i * width, width)).collect();
        match parts[..] {
            [only] => only,
            _ => m.select(lane, &parts),
        }
    };
    let result = one_of(m, results, w.exponential);
    let result = m.name(result, "result");
    let info = one_of(m, infos, w.info() + 1);
    let info = m.name(info, "info");
    let opacity = m.slice(info, w.pixel() + 48, 16);
    let is_pair = m.bit(info, w.info());
    let pair = Pair {
        valid: m.and(valid, is_pair),
        pixel: m.slice(info, 0, w.pixel()),
        colour: m.slice(info, w.pixel(), 48),
    };
    zero.take(m, pair, pair.valid, moves);
    let opacity = moved(m, "opacity_0", opacity, moves);
    let result = moved(m, "result_0", result, moves);
    one.take(m, zero, zero.valid, moves);
    let product = m.mul(opacity, result);
    let product = moved(m, "product_1", product, moves);

    m.section("Alpha");
    let alpha = m.round(product, w.exponential, Rounding::HalfUp);
    let alpha = m.extend(alpha, ALPHA);
    let above = m.gt(alpha, cap);
    let alpha = m.mux(above, cap, alpha);
    let alpha = m.name(alpha, "alpha");
    let counts = m.ge(alpha, min);
    let counts = m.and(one.valid, counts);
    two.take(m, one, counts, moves);
    let alpha = moved(m, "alpha_2", alpha, moves);

    m.section("Transmittance");
    let reads = m.and(two.valid, moves);
    let reads = m.name(reads, "reads");
    three.take(m, two, reads, always);
    let alpha = moved(m, "alpha_3", alpha, always);
    let word = m.out(transmittance, "rdata");
    four.take(m, three, three.valid, always);
    let whole = m.lit(FULL, Ty::u(ALPHA));
    let rest = m.sub(whole, alpha);
    let rest = moved(m, "passes_4", rest, always);
    let word = moved(m, "word_4", word, always);
    let has_stopped = m.bit(word, TRANSMITTANCE);
    let before = m.slice(word, 0, TRANSMITTANCE);
    let before = m.name(before, "earlier");
    let is_live = m.not(has_stopped);
    let goes_on = m.and(four.valid, is_live);
    let product = m.mul(before, rest);
    five.take(m, four, goes_on, always);
    let before = moved(m, "before_5", before, always);
    let product = moved(m, "product_5", product, always);
    let below = m.lt(product, stop);
    let below = m.name(below, "below_stop");
    let stops = m.and(five.valid, below);
    let stops = m.name(stops, "stops");
    let goes_on = m.not(below);
    let draws = m.and(five.valid, goes_on);
    let draws = m.name(draws, "draws");
    let after = m.round(product, 16, Rounding::HalfUp);
    let after = m.slice(after, 0, TRANSMITTANCE);
    let weight = m.sub(before, after);
    let kept = m.mux(below, before, after);
    let state = m.cat(&[below, kept]);
    let port = Port {
        reads,
        read_at: two.pixel,
        writes: five.valid,
        write_at: five.pixel,
        word: state,
    };
    drain.connect(m, transmittance, &port, 1 << (TRANSMITTANCE - 1));

    m.section("Live pixels");
    let shown = live(m, w, &drain, [stops, five.pixel], [row, tile]);

    m.section("Colour");
    six.take(m, five, draws, always);
    let weight = moved(m, "weight_6", weight, always);
    let channels = [2, 1, 0];
    let added = channels.map(|i| {
        let channel = m.slice(six.colour, 16 * i, 16);
        let product = m.mul(weight, channel);
        m.slice(product, 0, COLOUR_SUM)
    });
    let added = m.cat(&added);
    let added = moved(m, "added_7", added, always);
    let added = moved(m, "added", added, always);
    let read = m.out(colours, "rdata");
    let sums = moved(m, "sums", read, always);
    let (mut last_valid, mut pixel) = (six.valid, six.pixel);
    let mut late = vec![];
    for stage in [7, 8] {
        let valid = m.reg(&format!("valid_{stage}"), bit, 0);
        m.set_next(valid, last_valid);
        last_valid = valid;
        late.push(valid);
        pixel = moved(m, &format!("pixel_{stage}"), pixel, always);
    }
    let word = channels.map(|i| {
        let [sum, own] = [sums, added].map(|all| m.slice(all, COLOUR_SUM * i, COLOUR_SUM));
        m.add(sum, own)
    });
    let word = m.cat(&word);
    let port = Port {
        reads: six.valid,
        read_at: six.pixel,
        writes: last_valid,
        write_at: pixel,
        word,
    };
    drain.connect(m, colours, &port, 0);

    m.section("Outputs");
    m.output("pop", pop, "takes the vector at the clock edge");
    let valid = stages.iter().map(|stage| stage.valid);
    let valid: Vec<Signal> = valid.chain(late).collect();
    let busy = m.any_of(&valid);
    m.output("busy", busy, "a pair is on its way");
    m.output("row_live", shown[0], "live pixels of the row");
    m.output("tile_alive", shown[1], "rows of the tile with live pixels");
    m.output("draining", drain.is_active, "pixels are given, or cleared");
    m.output("out_valid", drain.offers, "a pixel");
    let word = m.out(transmittance, "rdata");
    let left = m.slice(word, 0, TRANSMITTANCE);
    m.output("out_transmittance", left, "U1.20");
    m.output(
        "out_colour",
        read,
        "three sums of 32 fraction bits, the first channel lowest",
    );
    m.output("out_last", drain.is_last, "the last pixel");
    m.output("drawn", draws, "a pair contributes");
    m.output("stopped", stops, "a pair ends its pixel");
    builder.finish()
}
