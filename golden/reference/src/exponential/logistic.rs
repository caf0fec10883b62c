//! Sigmoid and softplus: two and three passes through the engine's registers.
//!
//! `softplus(x) = max(x, 0) + ln(1 + exp(-|x|))`, `sigmoid(x) = exp(-softplus(-x))`. The logarithm
//! is multiplicative normalisation: factors `1 + 2^-i` bring `y = 1 + exp(-|x|)` up towards 2, and
//! their logarithms, the constants that the exponential subtracts, are subtracted from a start of
//! ln 2. The remaining distance to 2 is its own logarithm to first order, for
//! `-ln(1 - z) = z + ..`.

use potamoi_formats::fixed::{Rounding, round_shift};

use potamoi_formats::config::{Engine, ExpConfig};

use super::{ReferenceExponential, align};
use crate::logarithms::ln_one_plus_power;

impl ReferenceExponential {
    /// The operation `softplus` of a code with the input's fraction bits:
    /// `ln(1 + exp(a))` with F fraction bits, at most the largest signed 32-bit
    /// code.
    #[must_use]
    pub fn softplus(&self, a: i32) -> i32 {
        let sum = self.softplus_sum(i64::from(a)).max(0);
        let (from, to) = (self.engine.constant_bits, self.output_bits);
        let result = match to.checked_sub(from) {
            Some(more) => sum << more,
            None => round_shift(sum, from - to, Rounding::HalfUp),
        };
        result.min(i128::from(i32::MAX)) as i32
    }

    /// The operation `sigmoid` of a code with the input's fraction bits: U0.F,
    /// `1 / (1 + exp(-a))`.
    #[must_use]
    pub fn sigmoid(&self, a: i32) -> i32 {
        let bits = self.engine.constant_bits;
        let sum = self.softplus_sum(-i64::from(a));
        let s = sum.clamp(0, (16 << bits) - 1) as i64;
        let raw = self.form.power(s, s >= 8 << bits);
        let most = (1 << self.output_bits) - 1;
        self.round(raw.accumulator, -raw.exponent).min(most) as i32
    }

    /// `ln(1 + exp(x))` with the constants' fraction bits, before it is rounded;
    /// a unit or so below 0 is possible.
    #[must_use]
    pub(crate) fn softplus_sum(&self, x: i64) -> i128 {
        let (from, to) = (self.input.frac_bits(), self.engine.constant_bits);
        let size = x.abs().min((16 << from.min(24)) - 1);
        let s = align(size, from, to);
        let raw = self.form.power(s, s >= 8 << to);
        let k = raw.exponent.clamp(-31, 0).unsigned_abs();
        let exp = align(raw.accumulator, k, 0);
        let linear = i128::from(x.max(0)) << to.saturating_sub(from);
        linear + i128::from(self.logarithm.of(exp))
    }
}

/// The constants of the logarithm: those of the restoring form.
#[derive(Debug, Clone)]
pub(super) struct Logarithm {
    engine: Engine,
    steps: Vec<(u32, i64)>,
    /// ln 2 as the engine computes it from 1, so that ln 1 is exactly 0.
    start: i64,
}

impl Logarithm {
    /// For an engine whose widths are limited already.
    pub(super) fn new(config: &ExpConfig, engine: Engine) -> Self {
        let steps = 1..=config.iterations.min(31);
        let bits = engine.constant_bits;
        let steps: Vec<_> = steps.map(|i| (i, ln_one_plus_power(i, bits))).collect();
        Self {
            start: normalise(&engine, &steps, 0),
            engine,
            steps,
        }
    }

    /// `ln(1 + e)` with the constants' fraction bits; `e` has the accumulator's. Exactly 0 for 0.
    fn of(&self, e: i64) -> i64 {
        self.start - normalise(&self.engine, &self.steps, e)
    }
}

/// The constants of the factors that bring `1 + e` up towards 2, less half of the product reached:
/// `-ln(1 + e)` up to a constant.
fn normalise(engine: &Engine, steps: &[(u32, i64)], e: i64) -> i64 {
    let one = 1i64 << engine.accumulator_bits;
    let (mut accumulator, mut sum) = (one + e, 0);
    for &(i, c) in steps {
        let more = accumulator + (accumulator >> i) + (accumulator >> (i - 1) & 1);
        if accumulator < 2 * one && more < 2 * one {
            accumulator = more;
            sum += c;
        }
    }
    // Half of it: one fraction bit more.
    let (from, to) = (engine.accumulator_bits + 1, engine.constant_bits);
    sum - match to.checked_sub(from) {
        Some(more) => accumulator << more,
        None => accumulator >> (from - to),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn anchors_of_the_default_engine() {
        let twin = ReferenceExponential::new(&ExpConfig::default());
        assert_eq!(twin.sigmoid(0), 32_768);
        // sigmoid(1) * 65536 = 47911.1; softplus(1) * 65536 = 86065.5.
        assert!((twin.sigmoid(8192) - 47_911).abs() <= 1);
        assert!((twin.softplus(8192) - 86_066).abs() <= 1);
        // ln 2 * 65536 = 45426.09.
        assert!((twin.softplus(0) - 45_426).abs() <= 1);
        for (a, sigmoid, softplus) in [
            (i32::MIN, 0, 0),
            (-16 << 13, 0, 0),
            (16 << 13, 65_535, 16 << 16),
            (1000 << 13, 65_535, 1000 << 16),
            (i32::MAX, 65_535, i32::MAX),
        ] {
            assert_eq!(
                (twin.sigmoid(a), twin.softplus(a)),
                (sigmoid, softplus),
                "{a}"
            );
        }
    }

    /// The logarithm of the engine's own constants, against double precision.
    #[test]
    fn logarithms_are_exact_at_one_and_close_elsewhere() {
        for (bits, n) in [(24, 12), (30, 16), (36, 20)] {
            let twin = ReferenceExponential::new(&ExpConfig {
                iterations: n,
                accumulator_bits: Some(bits),
                constant_bits: Some(bits),
                ..ExpConfig::default()
            });
            assert_eq!(twin.logarithm.of(0), 0);
            for step in 0..=1000i64 {
                let e = (step << bits) / 1000;
                let exact = (e as f64 * 2f64.powi(-(bits as i32))).ln_1p();
                let off = twin.logarithm.of(e) as f64 * 2f64.powi(-(bits as i32)) - exact;
                // Twice (one end each): the first order, and n sums and constants.
                let most =
                    2f64.powi(-2 * n as i32) + f64::from(2 * n + 2) * 2f64.powi(-(bits as i32));
                assert!(
                    off.abs() <= most,
                    "{bits} bits, {n}: ln(1 + {e}) is {off:e} off"
                );
            }
        }
    }
}
