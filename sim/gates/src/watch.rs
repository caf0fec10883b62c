//! When a netlist moves, and who is told.

use super::flat::Flat;

/// Delays in steps of time, 1 and up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Delays {
    /// Of each cell by input pin (of a flip-flop its clock alone), output, and whether
    /// that falls or rises.
    pub cells: Vec<u32>,
    /// Where those of each cell begin.
    pub from: Vec<u32>,
    /// Of memories, from the clock's edge.
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

/// Told of everything that moves. States are as before the change.
pub trait Watch {
    /// A net changes.
    fn net(&mut self, net: u32);
    /// An input of a cell changes.
    fn input(&mut self, cell: u32, pin: u8, state: u16);
    /// An output of a cell changes because of an input, 0 for a flip-flop's clock; its
    /// inputs are as they are now.
    fn output(&mut self, cell: u32, output: u8, pin: u8, state: u16);
    /// The clock of a flip-flop rises or falls.
    fn clock(&mut self, cell: u32, state: u16, rises: bool);
}

/// Nobody is told.
#[derive(Debug)]
pub struct NoCount;

impl Watch for NoCount {
    fn net(&mut self, _: u32) {}
    fn input(&mut self, _: u32, _: u8, _: u16) {}
    fn output(&mut self, _: u32, _: u8, _: u8, _: u16) {}
    fn clock(&mut self, _: u32, _: u16, _: bool) {}
}
