//! Report of a gate-level unit.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::netlist::{MemoryArea, ModuleArea};
use super::netlist_digests::NetlistDigests;
use super::power_report::Power;

/// A gate-level unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct UnitReport {
    /// Its top module.
    pub unit: String,
    /// Digests of the netlists that it was made from.
    pub netlists: NetlistDigests,
    /// Cells of the whole unit.
    pub cells: u64,
    /// Flip-flops among them.
    pub flops: u64,
    /// Buffers between modules among them.
    pub buffers: u64,
    /// Cell area in square micrometres, without memories.
    pub area_um2: f64,
    /// Longest path in picoseconds, with clock-to-output and setup.
    pub period_ps: f64,
    /// Clock in gigahertz for that period.
    pub clock_ghz: f64,
    /// Start and end of the longest path.
    pub path: [String; 2],
    /// Cells on it.
    pub path_cells: u64,
    /// Its modules, the top one first.
    pub modules: Vec<ModuleArea>,
    /// Its memories, not part of cells and areas.
    pub memories: Vec<MemoryArea>,
    /// Memories of flip-flops, part of cells and areas.
    pub flop_memories: Vec<FlopMemory>,
    /// Its longest path with the memories' access times, where known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub with_memories: Option<WithMemories>,
    /// Its power, if requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power: Option<Power>,
}

/// The longest path of a unit, including paths from and to its memories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WithMemories {
    /// Access time of each memory module in picoseconds, at the library's node.
    pub access_ps: BTreeMap<String, f64>,
    /// Longest path in picoseconds, before wires.
    pub period_ps: f64,
    /// Clock in gigahertz for that period.
    pub clock_ghz: f64,
    /// Start and end of the longest path.
    pub path: [String; 2],
    /// Cells on it, a memory among them.
    pub path_cells: u64,
}

/// A memory made of flip-flops in its unit's netlist.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FlopMemory {
    /// Its module.
    pub memory: String,
    /// The unit's top module.
    pub of: String,
    /// Number of instances.
    pub count: u64,
    /// Words.
    pub words: u64,
    /// Width of a word in bits.
    pub bits: u64,
    /// Reason why it is no macro.
    pub why: String,
}
