//! A netlist without its hierarchy: cells, the nets between them, and of each cell the
//! kind of module that it is of.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_hdl::ir::Module;

use super::flatten::Builder;
use super::gate::Gate;

/// Nets that are always 0 and always 1.
pub(super) const CONSTANTS: u32 = 2;

/// A cell of the netlist.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell {
    /// Of [`Flat::gates`].
    pub(crate) gate: u16,
    /// Of [`Flat::modules`].
    pub(crate) module: u16,
    /// Its first pin.
    pub(super) first: u32,
}

/// What gives a net its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Driver {
    /// Nothing yet; 0 where nothing reads it.
    None,
    Constant,
    Port,
    /// A cell's output.
    Cell {
        cell: u32,
        output: u8,
    },
    /// A memory in this kind of module.
    Memory {
        module: u16,
    },
}

/// An input of a cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sink {
    pub(crate) cell: u32,
    pub(crate) pin: u8,
}

/// Nets, lowest bit first.
#[derive(Debug, Clone)]
pub(crate) struct FlatPort {
    pub(crate) name: String,
    pub(crate) output: bool,
    pub(crate) nets: Vec<u32>,
}

/// A memory, which is no cell.
#[derive(Debug, Clone)]
pub(crate) struct FlatMemory {
    pub(crate) module: Arc<Module>,
    /// The kind of module that it is in.
    pub(crate) inside: u16,
    /// All but the clock.
    pub(crate) ports: Vec<FlatPort>,
}

/// A kind of module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ModuleKind {
    pub(crate) name: String,
    /// How many there are.
    pub(crate) count: u64,
}

/// A netlist without its hierarchy.
#[derive(Debug, Default)]
pub(crate) struct Flat {
    /// Kinds of cell in use.
    pub(crate) gates: Vec<Gate>,
    /// Kinds of module, the top one first.
    pub(crate) modules: Vec<ModuleKind>,
    pub(crate) cells: Vec<Cell>,
    /// Nets of each cell's inputs, then of its outputs.
    pub(super) pins: Vec<u32>,
    /// Of the top module, `clk` left out.
    pub(crate) ports: Vec<FlatPort>,
    pub(crate) memories: Vec<FlatMemory>,
    /// Nets of the top module that its author named.
    pub(crate) named: BTreeMap<String, u32>,
    pub(crate) drivers: Vec<Driver>,
    /// Where the readers of each net begin, and end.
    pub(super) sinks_from: Vec<u32>,
    pub(super) sinks: Vec<Sink>,
    /// Flip-flops.
    pub(crate) flops: Vec<u32>,
    /// Cells of logic, each after those that it depends on.
    pub(crate) order: Vec<u32>,
    /// Of each cell of logic, the most cells of logic on a way to its outputs.
    pub(crate) levels: Vec<u32>,
}

impl Flat {
    /// Flattens the netlist of `top`. `gates` are the library's cells, `memories` the
    /// modules that are left out of the netlist.
    ///
    /// # Errors
    /// What is wrong with the netlist, or why a cell in it cannot be simulated.
    pub(crate) fn new(
        netlist: &str,
        top: &str,
        gates: &BTreeMap<String, Result<Gate, String>>,
        memories: &BTreeMap<String, Arc<Module>>,
    ) -> Result<Self, String> {
        Builder::build(netlist, top, gates, memories)
    }

    pub(crate) fn nets(&self) -> usize {
        self.drivers.len()
    }

    pub(crate) fn gate(&self, cell: u32) -> &Gate {
        &self.gates[usize::from(self.cells[cell as usize].gate)]
    }

    #[inline]
    pub(crate) fn inputs(&self, cell: u32) -> &[u32] {
        let first = self.cells[cell as usize].first as usize;
        &self.pins[first..first + self.gate(cell).inputs.len()]
    }

    #[inline]
    pub(crate) fn outputs(&self, cell: u32) -> &[u32] {
        let gate = self.gate(cell);
        let first = self.cells[cell as usize].first as usize + gate.inputs.len();
        &self.pins[first..first + gate.outputs.len()]
    }

    #[inline]
    pub(crate) fn sinks(&self, net: u32) -> &[Sink] {
        let at = |net: usize| self.sinks_from[net] as usize;
        &self.sinks[at(net as usize)..at(net as usize + 1)]
    }
}
