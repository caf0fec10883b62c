//! Live pixels of the tiles in flight, a word a row, and rows that have some, a word a tile.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::drain::Drain;
use super::formats::{PIXEL, Widths};
use crate::circuits::{is, ones};

/// Pixels of a row, rows of a tile.
const SIDE: u32 = 16;
/// Bits of a column or row.
const PLACE: u32 = 4;

/// A word of `SIDE` bits without one of them.
fn without(m: &mut ModuleBuilder, word: Signal, place: Signal) -> Signal {
    let one = m.lit(1, Ty::u(SIDE));
    let own = m.shl(one, place);
    let own = m.slice(own, 0, SIDE);
    let others = m.not(own);
    m.and(word, others)
}

/// Declares the memories; returns the words of the row and the tile that are asked for. A pixel that
/// stops is live no more from the next clock on.
pub(super) fn live(
    m: &mut ModuleBuilder,
    w: &Widths,
    drain: &Drain,
    [stops, pixel]: [Signal; 2],
    [row, tile]: [Signal; 2],
) -> [Signal; 2] {
    let all = m.lit(ones(SIDE), Ty::u(SIDE));
    let word_of = |m: &mut ModuleBuilder, name: &str, words: u32, low: u32, stops: Signal| {
        let memory = m.memory(name, words, SIDE, "");
        let address = |m: &mut ModuleBuilder, pixel: Signal| m.slice(pixel, low, w.pixel() - low);
        let own = address(m, pixel);
        let before = m.mem_read_async(memory, own);
        let before = m.name(before, &format!("{name}_before"));
        let place = m.slice(pixel, low - PLACE, PLACE);
        let after = without(m, before, place);
        let after = m.name(after, &format!("{name}_after"));
        let lowest = m.slice(drain.pixel, 0, low);
        let first = is(m, lowest, 0);
        let clears = m.and(drain.clears, first);
        let clears = m.name(clears, &format!("{name}_clears"));
        let cleared = address(m, drain.pixel);
        let at = m.mux(clears, cleared, own);
        let at = m.name(at, &format!("{name}_at"));
        let word = m.mux(clears, all, after);
        let writes = m.or(clears, stops);
        m.mem_write(memory, writes, at, word);
        (memory, after)
    };
    let (rows, left) = word_of(m, "live", w.tiles * SIDE, PLACE, stops);
    let some = m.any(left);
    let none = m.not(some);
    let ends = m.and(stops, none);
    let (tiles, _) = word_of(m, "alive", w.tiles, PIXEL, ends);
    let of_row = m.mem_read_async(rows, row);
    let of_tile = m.mem_read_async(tiles, tile);
    [
        m.name(of_row, "live_asked_for"),
        m.name(of_tile, "alive_asked_for"),
    ]
}
