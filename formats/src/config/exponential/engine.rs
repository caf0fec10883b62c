//! The widths of an engine.

/// Every derived width of the engine. Both sides build from these numbers and
/// compute their own constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Engine {
    /// Fraction bits of `R_accum`.
    pub accumulator_bits: u32,
    /// Fraction bits of `R_remain` and of the constants.
    pub constant_bits: u32,
    /// Start of `R_accum`, in units of its last bit above 1.
    pub offset: i32,
    /// Whether the truncation is centred: `2^-(n+1)` is added at the start.
    /// Without tail only, and where the constants reach that far.
    pub centred: bool,
    /// Exponent digits `ln 2 * 2^j`, `j = digits-1 .. 0`; of radix 4, `4^j`.
    pub digits: u32,
    /// Start of `R_remain` in units of `ln 2`.
    pub bias: u32,
    /// Steps in all: `digits + n`.
    pub steps: u32,
}
