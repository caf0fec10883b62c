//! What is reported of a unit in cells.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::netlist::{MemoryArea, ModuleArea};
use super::power_report::Power;

/// A unit in cells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnitReport {
    /// Its top module.
    pub unit: String,
    /// Cells of the whole unit.
    pub cells: u64,
    /// Of those, flip-flops.
    pub flops: u64,
    /// Of those, buffers of nets between modules.
    pub buffers: u64,
    /// Square micrometres of cells, memories not counted.
    pub area_um2: f64,
    /// Picoseconds of the longest path, with clock-to-output and setup.
    pub period_ps: f64,
    /// Gigahertz of that period.
    pub clock_ghz: f64,
    /// Where the longest path begins, and where it ends.
    pub path: [String; 2],
    /// Cells on it.
    pub path_cells: u64,
    /// Its modules, the top one first.
    pub modules: Vec<ModuleArea>,
    /// Its memories, left out of cells and areas.
    pub memories: Vec<MemoryArea>,
    /// Memories that are flip-flops, counted in cells and areas.
    pub flop_memories: Vec<FlopMemory>,
    /// Its longest path with the memories' access times, where these are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub with_memories: Option<WithMemories>,
    /// Its power, if it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power: Option<Power>,
}

/// The longest path of a unit, those from and to its memories among them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WithMemories {
    /// Picoseconds from the clock to a memory's outputs, by module, at the library's node.
    pub access_ps: BTreeMap<String, f64>,
    /// Picoseconds of the longest path before wires.
    pub period_ps: f64,
    /// Gigahertz of that period.
    pub clock_ghz: f64,
    /// Where the longest path begins, and where it ends.
    pub path: [String; 2],
    /// Cells on it, a memory among them.
    pub path_cells: u64,
}

/// A memory that is flip-flops in the netlist of its unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FlopMemory {
    /// Its module.
    pub memory: String,
    /// The unit's top module.
    pub of: String,
    /// How many there are.
    pub count: u64,
    /// Words.
    pub words: u64,
    /// Bits of a word.
    pub bits: u64,
    /// Why it is no macro.
    pub why: String,
}
