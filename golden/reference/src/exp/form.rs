//! What a form of the exponential computes.

use std::fmt::Debug;

/// What the engine holds after its last step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Raw {
    /// `R_accum`, with [`Engine::accumulator_bits`] fraction bits: the
    /// mantissa.
    pub accumulator: i64,
    /// `R_remain` before the tail, with [`Engine::constant_bits`] fraction
    /// bits.
    pub remain: i64,
    /// Binary exponent: the result is `accumulator * 2^exponent`.
    pub exponent: i32,
}

/// The exponent's bias for one-minus-exp of values of 8 and more.
pub(super) const FAR_BIAS: u32 = 24;

/// A form with the constants of a configuration.
pub(super) trait Form: Debug + Send + Sync {
    /// The power of minus a value with the constants' fraction bits; `far` of values of 8 and
    /// more.
    fn power(&self, value: i64, far: bool) -> Raw;

    /// The power of a signed value with the constants' fraction bits, of the general output.
    fn signed_power(&self, value: i64) -> Raw {
        self.power(-value, false)
    }

    /// Whether operands are signed whatever the output, and the result is the accumulator, rounded.
    fn is_bare(&self) -> bool {
        false
    }
}
