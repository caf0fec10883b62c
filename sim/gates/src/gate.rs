//! Functions of a library's cells.

use super::function::Truth;

/// Function of a cell. Its state in a simulation is a word of bits: inputs in order (for a
/// flip-flop without its clock, but with its stored bit), then outputs in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Gate {
    /// Its name in the library.
    pub name: String,
    /// Input pins in order; for a flip-flop without its clock.
    pub inputs: Vec<String>,
    /// Output pins, in order.
    pub outputs: Vec<String>,
    /// Function of each output, of the inputs and the stored bit.
    pub functions: Vec<Truth>,
    /// Stored bit, if it is a flip-flop.
    pub flop: Option<Flop>,
}

/// A rising-edge flip-flop.
#[derive(Debug, Clone, PartialEq)]
pub struct Flop {
    /// Clock pin.
    pub clock: String,
    /// Names of the stored bit and of its complement in functions.
    pub held: [String; 2],
    /// Next value, as a function of the inputs and the stored bit.
    pub next: Truth,
}

impl Gate {
    /// Number of variables of the output functions.
    #[must_use]
    pub fn variables(&self) -> usize {
        self.inputs.len() + usize::from(self.flop.is_some())
    }

    /// Number of bits of the state.
    #[must_use]
    pub fn bits(&self) -> usize {
        self.variables() + self.outputs.len()
    }

    /// Output bits for these inputs, in their position in the state.
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
