//! The chain of transmittances: stages 3 to 8.

use potamoi_formats::fixed::Rounding;
use potamoi_netlist::{Instance, IrErrors, ModuleBuilder, Signal, Ty};

use super::{ALPHA, Pair};
use crate::splat_unit::drain::{Drain, Port};
use crate::splat_unit::formats::TRANSMITTANCE;
use crate::splat_unit::product::product_of;
use crate::splat_unit::registers::moved;

/// Alpha 1, U0.16.
const FULL: u32 = 1 << 16;

/// What the chain is built from.
pub(super) struct Chain<'a> {
    /// Transmittances, with a bit for pixels that have stopped.
    pub(super) memory: Instance,
    pub(super) drain: &'a Drain,
    pub(super) stop: Signal,
    pub(super) moves: Signal,
}

/// What comes out of the chain, in stage 8.
pub(super) struct Passed {
    /// The pair ended its pixel.
    pub(super) stops: Signal,
    /// `T - T'`.
    pub(super) weight: Signal,
}

impl Chain<'_> {
    /// The transmittance after the pair of each stage: a pair in stage 8 contributes.
    ///
    /// # Errors
    /// The netlist's own checks.
    pub(super) fn build(
        &self,
        m: &mut ModuleBuilder,
        stages: &[Pair],
        alpha: Signal,
    ) -> Result<Passed, IrErrors> {
        m.section("Transmittance");
        let always = m.lit(1, Ty::bit());
        let reads = m.and(stages[3].valid, self.moves);
        let reads = m.name(reads, "reads");
        stages[4].take(m, stages[3], reads, always);
        let alpha = moved(m, "alpha_4", alpha, always);
        let word = m.out(self.memory, "rdata");
        stages[5].take(m, stages[4], stages[4].valid, always);
        let whole = m.lit(FULL, Ty::u(ALPHA));
        let rest = m.sub(whole, alpha);
        let rest = moved(m, "passes_5", rest, always);
        let word = moved(m, "word_5", word, always);
        let has_stopped = m.bit(word, TRANSMITTANCE);
        let is_live = m.not(has_stopped);
        let goes_on = m.and(stages[5].valid, is_live);
        let before = m.slice(word, 0, TRANSMITTANCE);
        let before = m.name(before, "earlier");
        let product = product_of(m, "passing", (before, rest), always)?;
        stages[6].take(m, stages[5], goes_on, always);
        let before = moved(m, "before_6", before, always);
        stages[7].take(m, stages[6], stages[6].valid, always);
        let before = moved(m, "before_7", before, always);
        let product = moved(m, "product_7", product, always);
        let below = m.lt(product, self.stop);
        let below = m.name(below, "below_stop");
        let stops = m.and(stages[7].valid, below);
        let goes_on = m.not(below);
        let draws = m.and(stages[7].valid, goes_on);
        let after = m.round(product, 16, Rounding::HalfUp);
        let after = m.slice(after, 0, TRANSMITTANCE);
        let kept = m.mux(below, before, after);
        let state = m.cat(&[below, kept]);
        let port = Port {
            reads,
            read_at: stages[3].pixel,
            writes: stages[7].valid,
            write_at: stages[7].pixel,
            word: state,
        };
        let clear = 1 << (TRANSMITTANCE - 1);
        self.drain.connect(m, self.memory, &port, clear);
        stages[8].take(m, stages[7], draws, always);
        let stopped = m.reg("stops_8", Ty::bit(), 0);
        m.set_next(stopped, stops);
        let before = moved(m, "before_8", before, always);
        let after = moved(m, "after_8", after, always);
        Ok(Passed {
            stops: stopped,
            weight: m.sub(before, after),
        })
    }
}
