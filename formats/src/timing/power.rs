//! Clocks and stages of an exponential.

use super::Pipeline;

/// Clocks from knowing a power's exponent to an early termination: the lanes tell the unit that
/// none has more steps, and the unit tells the lanes.
pub const AGREEMENT: u32 = 2;

/// Work on a power in one clock, or before one register stage of the pipelined engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PowerStage {
    /// As many steps of the recurrence as fit into a clock; clocks are numbered from 0.
    Steps(u32),
    /// Multiplication by 1 + the residual.
    Tail,
    /// Multiplication by `log2 e`.
    PowerOfTwo,
    /// Function of the fraction of the base-two exponent.
    Mantissa,
}

/// A register stage that a registered unit has beside the [stages of a power](PowerStage).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PowerRegister {
    /// What the first step starts from.
    Start,
    /// Two addends of the product with `log2 e`, of straight pieces.
    PowerAddends,
    /// Two addends of the function of the fraction, of straight pieces.
    MantissaAddends,
    /// The power by its exponent, before the result's rounding.
    Scaled,
}

impl Pipeline<PowerRegister> {
    /// The stages of a unit that is `registered`. Straight pieces have `multiplications`, the first
    /// one unless the operand `is_scaled`.
    #[must_use]
    pub fn power_registers(registered: bool, multiplications: bool, is_scaled: bool) -> Self {
        Self::built([
            (PowerRegister::Start, registered),
            (
                PowerRegister::PowerAddends,
                registered && multiplications && !is_scaled,
            ),
            (
                PowerRegister::MantissaAddends,
                registered && multiplications,
            ),
            (PowerRegister::Scaled, registered),
        ])
    }
}

impl Pipeline<PowerStage> {
    /// A recurrence: `turn` clocks of steps, then the tail, if built.
    #[must_use]
    pub fn recurrence(turn: u32, tail: bool) -> Self {
        let steps = (0..turn).map(PowerStage::Steps);
        Self::new(steps.chain(tail.then_some(PowerStage::Tail)))
    }

    /// An exponential in base two; the operand is first multiplied by `log2 e`, unless it
    /// `is_scaled`.
    #[must_use]
    pub fn power_of_two(is_scaled: bool) -> Self {
        Self::built([
            (PowerStage::PowerOfTwo, !is_scaled),
            (PowerStage::Mantissa, true),
        ])
    }

    /// Clocks of the steps: one turn of the shift registers.
    #[must_use]
    pub fn turn(&self) -> u32 {
        let steps = self.stages().filter(|s| matches!(s, PowerStage::Steps(_)));
        steps.count() as u32
    }
}
