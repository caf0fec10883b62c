//! Flat netlists: cells with the kind of module that each is in, and the nets between them.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_netlist::Module;

use super::gate::Gate;

/// Number of constant nets: 0 and 1.
pub(super) const CONSTANTS: u32 = 2;

/// A cell of the netlist.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// Index in [`Flat::gates`].
    pub gate: u16,
    /// Index in [`Flat::modules`].
    pub module: u16,
    /// Index of its first pin.
    pub(super) first: u32,
}

/// Driver of a net.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driver {
    /// Undriven; 0 where nothing reads it.
    None,
    /// It is always 0, or always 1.
    Constant,
    /// A port of the top module.
    Port,
    /// A cell's output.
    Cell {
        /// Index of the cell.
        cell: u32,
        /// Index of its output.
        output: u8,
    },
    /// A memory.
    Memory {
        /// Kind of module that contains it, an index in [`Flat::modules`].
        module: u16,
    },
}

/// A cell input that reads a net.
#[derive(Debug, Clone, Copy)]
pub struct Sink {
    /// Index of the cell.
    pub cell: u32,
    /// Index of its input.
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

/// A memory macro.
#[derive(Debug, Clone)]
pub struct FlatMemory {
    /// Its behaviour.
    pub module: Arc<Module>,
    /// Kind of module that contains it.
    pub inside: u16,
    /// Ports except the clock.
    pub ports: Vec<FlatPort>,
}

/// A kind of module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModuleKind {
    /// Its name.
    pub name: String,
    /// Number of instances.
    pub count: u64,
}

/// A netlist without hierarchy.
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
    /// Ports of the top module, without `clk`.
    pub ports: Vec<FlatPort>,
    /// Memories, which are no cells.
    pub memories: Vec<FlatMemory>,
    /// Named nets of the top module.
    pub named: BTreeMap<String, u32>,
    /// Driver of each net.
    pub drivers: Vec<Driver>,
    /// Start of each net's readers in the list of sinks, and its end.
    pub(super) sinks_from: Vec<u32>,
    pub(super) sinks: Vec<Sink>,
    /// Indices of flip-flops.
    pub flops: Vec<u32>,
    /// Combinational cells in topological order.
    pub order: Vec<u32>,
    /// Level of each combinational cell: the longest path of such cells to its outputs.
    pub levels: Vec<u32>,
}

impl Flat {
    /// Number of nets.
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

    /// Readers of a net.
    #[inline]
    #[must_use]
    pub fn sinks(&self, net: u32) -> &[Sink] {
        let at = |net: usize| self.sinks_from[net] as usize;
        &self.sinks[at(net as usize)..at(net as usize + 1)]
    }
}
