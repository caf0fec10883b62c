//! The pass over all pixels at the end of a job: it gives and clears them. After a reset it clears all.

use potamoi_netlist::{Instance, ModuleBuilder, Signal, Ty};

use super::formats::{PIXEL, Widths};
use super::registers::moved;
use crate::circuits::{ones, plus_one};

/// The pass.
pub(super) struct Drain {
    /// It runs, or holds a pixel.
    pub(super) is_active: Signal,
    /// It offers a pixel.
    pub(super) offers: Signal,
    /// That is the last one.
    pub(super) is_last: Signal,
    /// A pixel is cleared.
    pub(super) clears: Signal,
    /// Which.
    pub(super) pixel: Signal,
    fetches: Signal,
    at: Signal,
}

/// What a memory is used for beside the pass.
pub(super) struct Port {
    pub(super) reads: Signal,
    pub(super) read_at: Signal,
    pub(super) writes: Signal,
    pub(super) write_at: Signal,
    pub(super) word: Signal,
}

impl Drain {
    /// A pass begins with `begins`; after a reset one runs that gives nothing.
    pub(super) fn build(
        m: &mut ModuleBuilder,
        w: &Widths,
        begins: Signal,
        sink: Signal,
        last_slot: Signal,
    ) -> Self {
        let bit = Ty::bit();
        let runs = m.reg("drain_runs", bit, 1);
        let gives = m.reg("drain_gives", bit, 0);
        let next = m.or(gives, begins);
        m.set_next(gives, next);
        let at = m.reg("drain_at", Ty::u(w.pixel()), 0);
        let holds = m.reg("drain_holds", bit, 0);
        let silent = m.not(gives);
        let taken = m.or(silent, sink);
        let taken = m.name(taken, "drain_taken");
        let empty = m.not(holds);
        let free = m.or(empty, taken);
        let fetches = m.and(runs, free);
        let fetches = m.name(fetches, "fetches");
        let last_pixel = m.lit(ones(PIXEL), Ty::u(PIXEL));
        let asked = m.cat(&[last_slot, last_pixel]);
        let all = m.lit(ones(w.pixel()), Ty::u(w.pixel()));
        let end = m.mux(gives, asked, all);
        let is_end = m.eq(at, end);
        let is_end = m.name(is_end, "drain_at_end");
        let more = plus_one(m, at);
        let none = m.lit(0, at.ty());
        let next = m.mux(is_end, none, more);
        m.set_next_if(at, fetches, next);
        let ends = m.and(fetches, is_end);
        let stays = m.not(ends);
        let stays = m.and(runs, stays);
        let next = m.or(begins, stays);
        m.set_next(runs, next);
        let kept = m.not(taken);
        let kept = m.and(holds, kept);
        let next = m.or(fetches, kept);
        m.set_next(holds, next);
        Self {
            is_active: m.or(runs, holds),
            offers: m.and(holds, gives),
            is_last: moved(m, "drain_is_last", is_end, fetches),
            clears: holds,
            pixel: moved(m, "drain_pixel", at, fetches),
            fetches,
            at,
        }
    }

    /// Connects a memory of a word a pixel.
    pub(super) fn connect(&self, m: &mut ModuleBuilder, memory: Instance, port: &Port, clear: u64) {
        let clear = m.lit(clear, port.word.ty());
        for (name, signal) in [
            ("re", m.or(self.fetches, port.reads)),
            ("raddr", m.mux(self.fetches, self.at, port.read_at)),
            ("we", m.or(self.clears, port.writes)),
            ("waddr", m.mux(self.clears, self.pixel, port.write_at)),
            ("wdata", m.mux(self.clears, clear, port.word)),
        ] {
            m.connect(memory, name, signal);
        }
    }
}
