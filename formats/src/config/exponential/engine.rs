//! Widths of an exponential engine.

/// Every derived width of the engine. Both sides build from these numbers and
/// compute their own constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Engine {
    /// Fraction bits of `R_accum`.
    pub accumulator_bits: u32,
    /// Fraction bits of `R_remain` and of the constants.
    pub constant_bits: u32,
    /// Initial `R_accum` above 1, in units of its last bit.
    pub offset: i32,
    /// Whether the truncation error is centred, by adding `2^-(n+1)` to the initial value. Only
    /// without tail, and where the constants are wide enough.
    pub centred: bool,
    /// Exponent digits `ln 2 * 2^j`, `j = digits-1 .. 0`; of radix 4, `4^j`.
    pub digits: u32,
    /// Initial `R_remain` in units of `ln 2`.
    pub bias: u32,
    /// Total steps: `digits + n`.
    pub steps: u32,
}
