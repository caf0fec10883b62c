//! The interface that every form of the exponential implements.

use std::fmt::Debug;

/// The engine's registers after its last step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Raw {
    /// `R_accum`, with the engine's `accumulator_bits` fraction bits: the mantissa.
    pub accumulator: i64,
    /// `R_remain` before the tail, with the engine's `constant_bits` fraction bits.
    pub remain: i64,
    /// Binary exponent: the result is `accumulator * 2^exponent`.
    pub exponent: i32,
}

/// The bias of the exponent in one-minus-exp of values of at least 8.
pub(super) const FAR_BIAS: u32 = 24;

/// A form with the constants of a configuration.
pub(super) trait Form: Debug + Send + Sync {
    /// The power of minus `value`, which has the constants' fraction bits; `far` marks values of
    /// at least 8.
    fn power(&self, value: i64, far: bool) -> Raw;

    /// C99 statements that set `int64_t accumulator` and `int32_t exponent` to the power of minus
    /// `int64_t value`, as [`Form::power`] does for values that are not far. They may call the
    /// functions at the top of the header ([`super::c_header()`]).
    fn c_power(&self) -> String;

    /// The power of a signed value with the constants' fraction bits, for the general output.
    fn signed_power(&self, value: i64) -> Raw {
        self.power(-value, false)
    }

    /// Whether operands are signed for every output and the result is the rounded accumulator.
    fn is_bare(&self) -> bool {
        false
    }
}
