//! The exponential of a lane, and the alpha of its pair: stages 0 to 3.

use potamoi_formats::config::SplatOpacity;
use potamoi_formats::fixed::Rounding;
use potamoi_netlist::{IrErrors, ModuleBuilder, Signal, Ty};

use super::{ALPHA, Pair};
use crate::circuits::{bits_for, is, wrapping};
use crate::splat_unit::formats::Widths;
use crate::splat_unit::product::product_of;
use crate::splat_unit::registers::moved;

/// The vector of exponentials that is offered, and the thresholds of an alpha.
pub(super) struct Vector {
    valid: Signal,
    results: Signal,
    infos: Signal,
    cap: Signal,
    min: Signal,
    /// Bits of an exponential.
    exponential: u32,
}

impl Vector {
    pub(super) fn declare(m: &mut ModuleBuilder, w: &Widths) -> Self {
        let results = Ty::u(w.lanes * w.exponential);
        let infos = Ty::u(w.lanes * (w.info() + 1));
        Self {
            valid: m.input("valid", Ty::bit(), "a vector of exponentials"),
            results: m.input("results", results, "the first lane lowest"),
            infos: m.input("infos", infos, "of each lane"),
            cap: m.input("alpha_cap", Ty::u(ALPHA), "largest alpha, U0.16"),
            min: m.input("alpha_min", Ty::u(ALPHA), "smaller alphas do not count"),
            exponential: w.exponential,
        }
    }
}

/// A lane's exponential and its opacity: factors of the alpha.
pub(super) struct Factors {
    /// `None` where it is in the power.
    opacity: Option<Signal>,
    result: Signal,
}

impl Vector {
    /// The lanes of the vector, one a clock, into stage 0; and whether the vector is taken.
    pub(super) fn next_lane(
        &self,
        m: &mut ModuleBuilder,
        w: &Widths,
        zero: Pair,
        moves: Signal,
    ) -> (Factors, Signal) {
        m.section("Lane of the vector");
        let steps = m.and(self.valid, moves);
        let steps = m.name(steps, "steps");
        // A vector of one lane is taken at once.
        let (lane, pop) = match w.lanes {
            1 => (None, steps),
            lanes => {
                let lane = m.reg("lane", Ty::u(bits_for(lanes - 1)), 0);
                let last = is(m, lane, lanes - 1);
                let last = m.name(last, "last_lane");
                let end = m.lit(lanes - 1, lane.ty());
                let next = wrapping(m, lane, end);
                m.set_next_if(lane, steps, next);
                (Some(lane), m.and(steps, last))
            }
        };
        let pop = m.name(pop, "takes_vector");
        let one_of = |m: &mut ModuleBuilder, all: Signal, width: u32| {
            let lanes = 0..w.lanes;
            let parts: Vec<Signal> = lanes.map(|i| m.slice(all, i * width, width)).collect();
            match lane {
                None => parts[0],
                Some(lane) => m.select(lane, &parts),
            }
        };
        let result = one_of(m, self.results, w.exponential);
        let result = m.name(result, "result");
        let info = one_of(m, self.infos, w.info() + 1);
        let info = m.name(info, "info");
        let is_factor = w.opacity == SplatOpacity::Multiplied;
        let opacity = is_factor.then(|| m.slice(info, w.pixel() + 48, 16));
        let is_pair = m.bit(info, w.info());
        let pair = Pair {
            valid: m.and(self.valid, is_pair),
            pixel: m.slice(info, 0, w.pixel()),
            colour: m.slice(info, w.pixel(), 48),
        };
        zero.take(m, pair, pair.valid, moves);
        let factors = Factors {
            opacity: opacity.map(|opacity| moved(m, "opacity_0", opacity, moves)),
            result: moved(m, "result_0", result, moves),
        };
        (factors, pop)
    }

    /// The alpha of the pair in stage 3; smaller ones than the smallest are no pairs there.
    ///
    /// # Errors
    /// The netlist's own checks.
    pub(super) fn alpha(
        &self,
        m: &mut ModuleBuilder,
        factors: &Factors,
        stages: &[Pair],
        moves: Signal,
    ) -> Result<Signal, IrErrors> {
        m.section("Alpha");
        let alpha = match factors.opacity {
            Some(opacity) => {
                let product = product_of(m, "opacities", (opacity, factors.result), moves)?;
                stages[1].take(m, stages[0], stages[0].valid, moves);
                stages[2].take(m, stages[1], stages[1].valid, moves);
                let product = moved(m, "product_2", product, moves);
                let alpha = m.round(product, self.exponential, Rounding::HalfUp);
                m.extend(alpha, ALPHA)
            }
            None => {
                let alpha = m.extend(factors.result, ALPHA);
                m.shl_const(alpha, 16 - self.exponential)
            }
        };
        let above = m.gt(alpha, self.cap);
        let alpha = m.mux(above, self.cap, alpha);
        let alpha = m.name(alpha, "alpha");
        let counts = m.ge(alpha, self.min);
        let counts = m.and(stages[2].valid, counts);
        stages[3].take(m, stages[2], counts, moves);
        Ok(moved(m, "alpha_3", alpha, moves))
    }
}
