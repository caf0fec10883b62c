//! Passes of an operation through the iterative engine.

use std::ops::Range;

use super::{Pipeline, PowerRegister, PowerStage};
use crate::units::OpCode;

/// A pass through the engine's registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// An exponential of the operand.
    Power,
    /// `ln(1 + power)`, in the same steps without a tail.
    Logarithm,
    /// An exponential of that logarithm.
    SecondPower,
}

/// The passes of an operation, in sequence.
///
/// A registered unit waits between two passes: what the first leaves goes through the
/// [registers of a power](PowerRegister) before the second starts from it. After a logarithm that
/// is the last pass it waits a clock: the sum is registered before the next operation's start takes
/// the place of the remainder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Passes {
    passes: Vec<(Pass, Range<u32>)>,
    /// Clocks after the last pass.
    after: u32,
}

impl Passes {
    /// The passes of `op` with this power pipeline and these registers; none for an operation outside
    /// the engine.
    #[must_use]
    pub fn of(
        op: OpCode,
        power: &Pipeline<PowerStage>,
        registers: &Pipeline<PowerRegister>,
    ) -> Self {
        let order: &[Pass] = match op {
            OpCode::Exp | OpCode::OneMinusExp => &[Pass::Power],
            OpCode::Softplus => &[Pass::Power, Pass::Logarithm],
            OpCode::Sigmoid => &[Pass::Power, Pass::Logarithm, Pass::SecondPower],
            _ => &[],
        };
        let mut from = 0;
        let passes = order.iter().map(|&pass| {
            let clocks = match pass {
                Pass::Power | Pass::SecondPower => power.cycles(),
                Pass::Logarithm => power.turn(),
            };
            let clocks = from..from + clocks;
            from = clocks.end + registers.cycles();
            (pass, clocks)
        });
        let passes: Vec<_> = passes.collect();
        let ends_in_sum = matches!(passes.last(), Some((Pass::Logarithm, _)));
        Self {
            after: u32::from(ends_in_sum && registers.cycles() > 0),
            passes,
        }
    }

    /// Clocks of a pass, counted from acceptance; `None` where the operation does not have it.
    #[must_use]
    pub fn clocks(&self, pass: Pass) -> Option<Range<u32>> {
        let own = self.passes.iter().find(|(other, _)| *other == pass);
        own.map(|(_, clocks)| clocks.clone())
    }

    /// Clocks from accepting the operation to accepting the next; one for an operation without
    /// passes.
    #[must_use]
    pub fn cycles(&self) -> u32 {
        let last = self.passes.last();
        last.map_or(1, |(_, clocks)| clocks.end + self.after)
    }
}
