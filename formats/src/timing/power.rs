//! Clocks of an exponential.

use super::Pipeline;

/// Clocks from the one in which a power's exponent is known to the one that an early out ends
/// with: the lanes tell the unit that none has more steps, and the unit tells the lanes.
pub const AGREEMENT: u32 = 2;

/// What is done to a power in one clock, or in front of one register stage of the pipelined form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PowerStage {
    /// Steps of the recurrence, as many as one clock takes; numbered from 0.
    Steps(u32),
    /// The multiplication by 1 + the residual.
    Tail,
    /// The multiplication by `log2 e`.
    PowerOfTwo,
    /// A function of what lies behind the power of two's point.
    Mantissa,
}

impl Pipeline<PowerStage> {
    /// The recurrence: so many clocks of steps, then the tail, where it is built.
    #[must_use]
    pub fn recurrence(turn: u32, tail: bool) -> Self {
        let steps = (0..turn).map(PowerStage::Steps);
        Self::new(steps.chain(tail.then_some(PowerStage::Tail)))
    }

    /// A power of two: the operand is brought to base two unless it `is_scaled` already.
    #[must_use]
    pub fn power_of_two(is_scaled: bool) -> Self {
        Self::built([
            (PowerStage::PowerOfTwo, !is_scaled),
            (PowerStage::Mantissa, true),
        ])
    }

    /// Clocks of steps: a turn of the shift registers.
    #[must_use]
    pub fn turn(&self) -> u32 {
        let steps = self.stages().filter(|s| matches!(s, PowerStage::Steps(_)));
        steps.count() as u32
    }
}
