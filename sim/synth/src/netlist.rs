//! Contents of a netlist: cells and memories by module.

use std::collections::BTreeMap;

use potamoi_netlist::MemoryMacro;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Library;

/// A module's own cells, without those of its children.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModuleArea {
    /// Its name.
    pub module: String,
    /// Number of instances in the unit.
    pub count: u64,
    /// Cells of one.
    pub cells: u64,
    /// Flip-flops among them.
    pub flops: u64,
    /// Area of the cells of one, in square micrometres.
    pub area_um2: f64,
    /// Area of the flip-flops among them, in square micrometres.
    pub flop_area_um2: f64,
}

/// A memory macro.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MemoryArea {
    /// Module that it replaces.
    pub module: String,
    /// Number of instances.
    pub count: u64,
    /// Words.
    pub words: u64,
    /// Width of a word in bits.
    pub bits: u64,
    /// Ports that write or read, one access a cycle each.
    pub read_writes: u64,
    /// Write ports.
    pub writes: u64,
    /// Read ports.
    pub reads: u64,
}

impl From<MemoryMacro> for MemoryArea {
    fn from(own: MemoryMacro) -> Self {
        Self {
            module: own.module,
            count: own.count.into(),
            words: own.words.into(),
            bits: own.bits.into(),
            read_writes: own.read_writes.into(),
            writes: own.writes.into(),
            reads: own.reads.into(),
        }
    }
}

/// Cells by type of every module.
pub(super) type Types = BTreeMap<String, BTreeMap<String, u64>>;

/// Reads the output of Yosys's `stat -json`.
pub(super) fn read_types(text: &str) -> Option<Types> {
    #[derive(Deserialize)]
    struct Statistics {
        modules: BTreeMap<String, Module>,
    }
    #[derive(Deserialize)]
    struct Module {
        num_cells_by_type: BTreeMap<String, u64>,
    }
    let statistics: Statistics = serde_json::from_str(text).ok()?;
    let plain = |name: String| name.trim_start_matches('\\').to_owned();
    let modules = statistics.modules.into_iter();
    Some(
        modules
            .map(|(name, module)| {
                let types = module.num_cells_by_type.into_iter();
                (plain(name), types.map(|(t, n)| (plain(t), n)).collect())
            })
            .collect(),
    )
}

/// The modules of a unit, the top one first, then by name. Fails with a type that is neither a
/// cell, a module nor a memory.
pub(super) fn modules(
    types: &Types,
    top: &str,
    memories: &[MemoryMacro],
    library: &Library,
) -> Result<Vec<ModuleArea>, String> {
    let mut counts = BTreeMap::new();
    count(types, top, 1, &mut counts);
    let mut found = vec![];
    for (name, count) in &counts {
        let mut area = ModuleArea {
            module: name.clone(),
            count: *count,
            cells: 0,
            flops: 0,
            area_um2: 0.0,
            flop_area_um2: 0.0,
        };
        for (kind, number) in &types[name] {
            if let Some(cell) = library.cells.get(kind) {
                area.cells += number;
                let of_all = cell.area * *number as f64;
                area.area_um2 += of_all;
                if cell.is_flop {
                    area.flops += number;
                    area.flop_area_um2 += of_all;
                }
            } else if !types.contains_key(kind) && !memories.iter().any(|m| m.module == *kind) {
                return Err(kind.clone());
            }
        }
        found.push(area);
    }
    found.sort_by_key(|m| (m.module != top, m.module.clone()));
    Ok(found)
}

fn count(types: &Types, module: &str, times: u64, counts: &mut BTreeMap<String, u64>) {
    let Some(own) = types.get(module) else {
        return;
    };
    *counts.entry(module.to_owned()).or_default() += times;
    for (kind, number) in own {
        count(types, kind, times * number, counts);
    }
}
