//! Tiles in flight: alpha, transmittance and colour of their pixels.
//!
//! | stage | computes |
//! |---|---|
//! | 0 | a lane's exponential, with its opacity, pixel and colour |
//! | 1, 2 | opacity times exponential; without these if the opacity is in the power |
//! | 3 | alpha; the transmittance is read, unless an earlier pair of the pixel is in stages 4 to 7 |
//! | 4 | the transmittance comes; `65536 - alpha` |
//! | 5, 6 | `T (65536 - alpha)` |
//! | 7 | the stop test; the new transmittance is written |
//! | 8 | `T - T'`; the pixel's live bit |
//! | 9, 10 | `T - T'` times the colour; the sums are read |
//! | 11 | the sums come |
//! | 12 | the sums are written |

mod alpha;
mod colour;
mod transmittance;

use std::sync::Arc;

use potamoi_formats::config::SplatOpacity;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use self::alpha::Vector;
use self::transmittance::Chain;
use super::drain::Drain;
use super::formats::{COLOUR_SUM, PIXEL, TRANSMITTANCE, Widths};
use super::live::live;
use crate::memory::{Size, ram_1r1w};

/// Stages of a pair with its colour.
const STAGES: usize = 10;
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
    fn declare(m: &mut ModuleBuilder, w: &Widths, stage: usize) -> Self {
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
    let vector = Vector::declare(m, w);
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
    let mut declared = vec![];
    let stages: [Pair; STAGES] = std::array::from_fn(|stage| {
        // Without a product stage 3 follows stage 0.
        if w.opacity == SplatOpacity::InPower && (1..3).contains(&stage) {
            return declared[0];
        }
        let own = Pair::declare(m, w, stage);
        declared.push(own);
        own
    });
    let at_read = stages[3];
    let behind = &stages[4..8];
    let busy_pixel: Vec<Signal> = behind
        .iter()
        .map(|later| {
            let same = m.eq(at_read.pixel, later.pixel);
            m.and(later.valid, same)
        })
        .collect();
    let waits = m.any_of(&busy_pixel);
    let waits = m.and(at_read.valid, waits);
    let waits = m.name(waits, "waits");
    let moves = m.not(waits);
    let moves = m.name(moves, "moves");

    let (factors, pop) = vector.next_lane(m, w, stages[0], moves);
    let alpha = vector.alpha(m, &factors, &stages, moves)?;
    let chain = Chain {
        memory: transmittance,
        drain: &drain,
        stop,
        moves,
    };
    let drawn = chain.build(m, &stages, alpha)?;
    m.section("Live pixels");
    let stopped = [drawn.stops, stages[8].pixel];
    let shown = live(m, w, &drain, stopped, [row, tile]);
    let late = colour::sums(m, &stages, drawn.weight, (colours, &drain))?;

    let valid = declared.iter().map(|stage| stage.valid);
    let valid: Vec<Signal> = valid.chain([drawn.stops]).chain(late).collect();
    let busy = m.any_of(&valid);

    m.section("Outputs");
    m.output("pop", pop, "takes the vector at the clock edge");
    m.output("busy", busy, "a pair is on its way");
    m.output("row_live", shown[0], "live pixels of the row");
    m.output("tile_alive", shown[1], "rows of the tile with live pixels");
    m.output("draining", drain.is_active, "pixels are given, or cleared");
    m.output("out_valid", drain.offers, "a pixel");
    let word = m.out(transmittance, "rdata");
    let left = m.slice(word, 0, TRANSMITTANCE);
    m.output("out_transmittance", left, "U1.20");
    let read = m.out(colours, "rdata");
    m.output(
        "out_colour",
        read,
        "three sums of 32 fraction bits, the first channel lowest",
    );
    m.output("out_last", drain.is_last, "the last pixel");
    m.output("drawn", stages[8].valid, "a pair contributes");
    m.output("stopped", drawn.stops, "a pair ends its pixel");
    builder.finish()
}
