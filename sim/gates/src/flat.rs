//! A netlist without its hierarchy: cells, the nets between them, and of each cell the
//! kind of module that it is of.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_netlist::Module;

use super::gate::Gate;

/// Nets that are always 0 and always 1.
pub(super) const CONSTANTS: u32 = 2;

/// A cell of the netlist.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// Of [`Flat::gates`].
    pub gate: u16,
    /// Of [`Flat::modules`].
    pub module: u16,
    /// Its first pin.
    pub(super) first: u32,
}

/// What gives a net its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driver {
    /// Nothing yet; 0 where nothing reads it.
    None,
    /// It is always 0, or always 1.
    Constant,
    /// A port of the top module.
    Port,
    /// A cell's output.
    Cell {
        /// The cell.
        cell: u32,
        /// Which of its outputs.
        output: u8,
    },
    /// A memory in this kind of module.
    Memory {
        /// Of [`Flat::modules`].
        module: u16,
    },
}

/// An input of a cell.
#[derive(Debug, Clone, Copy)]
pub struct Sink {
    /// The cell.
    pub cell: u32,
    /// Which of its inputs.
    pub pin: u8,
}

/// A port of the top module or of a memory.
#[derive(Debug, Clone)]
pub struct FlatPort {
    /// Its name.
    pub name: String,
    /// Whether it is an output.
    pub output: bool,
    /// Its nets, lowest bit first.
    pub nets: Vec<u32>,
}

/// A memory, which is no cell.
#[derive(Debug, Clone)]
pub struct FlatMemory {
    /// What it does, clock by clock.
    pub module: Arc<Module>,
    /// The kind of module that it is in.
    pub inside: u16,
    /// All but the clock.
    pub ports: Vec<FlatPort>,
}

/// A kind of module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModuleKind {
    /// Its name.
    pub name: String,
    /// How many there are.
    pub count: u64,
}

/// A netlist without its hierarchy.
#[derive(Debug, Default)]
pub struct Flat {
    /// Kinds of cell in use.
    pub gates: Vec<Gate>,
    /// Kinds of module, the top one first.
    pub modules: Vec<ModuleKind>,
    /// Cells of the whole netlist.
    pub cells: Vec<Cell>,
    /// Nets of each cell's inputs, then of its outputs.
    pub(super) pins: Vec<u32>,
    /// Of the top module, `clk` left out.
    pub ports: Vec<FlatPort>,
    /// Memories, which are left out of the cells.
    pub memories: Vec<FlatMemory>,
    /// Nets of the top module that its author named.
    pub named: BTreeMap<String, u32>,
    /// Of each net, what drives it.
    pub drivers: Vec<Driver>,
    /// Where the readers of each net begin, and end.
    pub(super) sinks_from: Vec<u32>,
    pub(super) sinks: Vec<Sink>,
    /// Flip-flops.
    pub flops: Vec<u32>,
    /// Cells of logic, each after those that it depends on.
    pub order: Vec<u32>,
    /// Of each cell of logic, the most cells of logic on a way to its outputs.
    pub levels: Vec<u32>,
}

impl Flat {
    /// How many nets there are.
    #[must_use]
    pub fn nets(&self) -> usize {
        self.drivers.len()
    }

    /// The kind of a cell.
    #[must_use]
    pub fn gate(&self, cell: u32) -> &Gate {
        &self.gates[usize::from(self.cells[cell as usize].gate)]
    }

    /// Nets of a cell's inputs, by pin.
    #[inline]
    #[must_use]
    pub fn inputs(&self, cell: u32) -> &[u32] {
        let first = self.cells[cell as usize].first as usize;
        &self.pins[first..first + self.gate(cell).inputs.len()]
    }

    /// Nets of a cell's outputs, by pin.
    #[inline]
    #[must_use]
    pub fn outputs(&self, cell: u32) -> &[u32] {
        let gate = self.gate(cell);
        let first = self.cells[cell as usize].first as usize + gate.inputs.len();
        &self.pins[first..first + gate.outputs.len()]
    }

    /// What reads a net.
    #[inline]
    #[must_use]
    pub fn sinks(&self, net: u32) -> &[Sink] {
        let at = |net: usize| self.sinks_from[net] as usize;
        &self.sinks[at(net as usize)..at(net as usize + 1)]
    }
}
