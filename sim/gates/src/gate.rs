//! What the cells of a library compute.

use super::function::Truth;

/// A cell's function. Its state in a simulation is a word of bits: inputs in order, of a
/// flip-flop without its clock but with the bit that it holds, then outputs in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Gate {
    /// Its name in the library.
    pub name: String,
    /// Input pins, in order; of a flip-flop without its clock.
    pub inputs: Vec<String>,
    /// Output pins, in order.
    pub outputs: Vec<String>,
    /// Of the inputs, and of the held bit.
    pub functions: Vec<Truth>,
    /// What it holds, if it is a flip-flop.
    pub flop: Option<Flop>,
}

/// A flip-flop that takes its next value with the rising edge of a pin.
#[derive(Debug, Clone, PartialEq)]
pub struct Flop {
    /// The pin of its clock.
    pub clock: String,
    /// Names of the held bit and of its complement in functions.
    pub held: [String; 2],
    /// Of the inputs, and of the held bit.
    pub next: Truth,
}

impl Gate {
    /// Bits that outputs are functions of.
    #[must_use]
    pub fn variables(&self) -> usize {
        self.inputs.len() + usize::from(self.flop.is_some())
    }

    /// Bits of the state.
    #[must_use]
    pub fn bits(&self) -> usize {
        self.variables() + self.outputs.len()
    }

    /// The outputs' bits for inputs, as they stand in the state.
    #[inline]
    #[must_use]
    pub fn outputs_of(&self, inputs: usize) -> usize {
        let mut bits = 0;
        for (o, function) in self.functions.iter().enumerate() {
            bits |= usize::from(function.at(inputs)) << o;
        }
        bits << self.variables()
    }
}
