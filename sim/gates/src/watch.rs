//! Delays, and the observer of transitions.

use super::flat::Flat;

/// Delays in time steps, at least 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Delays {
    /// Delay of each cell by input pin (for a flip-flop its clock alone), output, and whether that
    /// falls or rises.
    pub cells: Vec<u32>,
    /// Start of each cell's delays.
    pub from: Vec<u32>,
    /// Delay of memories from the clock edge.
    pub memory: u32,
}

impl Delays {
    #[inline]
    pub(super) fn of(&self, flat: &Flat, cell: u32, pin: u8, output: usize, rises: bool) -> usize {
        let outputs = flat.gate(cell).outputs.len();
        let at = (usize::from(pin) * outputs + output) * 2 + usize::from(rises);
        self.cells[self.from[cell as usize] as usize + at] as usize
    }
}

/// Observer of all transitions. States are those before the transition.
pub trait Watch {
    /// A net changes.
    fn net(&mut self, net: u32);
    /// An input of a cell changes.
    fn input(&mut self, cell: u32, pin: u8, state: u16);
    /// An output of a cell changes because of an input, 0 for a flip-flop's clock; its inputs are
    /// up to date.
    fn output(&mut self, cell: u32, output: u8, pin: u8, state: u16);
    /// The clock of a flip-flop rises or falls.
    fn clock(&mut self, cell: u32, state: u16, rises: bool);
}

/// An observer that ignores everything.
#[derive(Debug)]
pub struct NoCount;

impl Watch for NoCount {
    fn net(&mut self, _: u32) {}
    fn input(&mut self, _: u32, _: u8, _: u16) {}
    fn output(&mut self, _: u32, _: u8, _: u8, _: u16) {}
    fn clock(&mut self, _: u32, _: u16, _: bool) {}
}
