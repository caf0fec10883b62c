//! Synthesis of one unit, from netlist to cells.

#[cfg(test)]
mod cache_tests;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use potamoi_base::content_hash;
use potamoi_formats::config::Config;
use potamoi_netlist::{Header, MemoryMacro, Module, verilog};
use potamoi_result_cache::{self as result_cache, Key};
use serde::{Deserialize, Serialize};

use super::cache_keys::UnitInputs;
use super::error::{CHECK_LIBRARY, cannot_keep};
use super::netlist::{self, MemoryArea, ModuleArea, Types};
use super::script::{BUFFERED, LIBRARY, MAPPED, NETLIST, PERIOD, STATISTICS, Scripts, scripts};
use super::tools::{FINISH, SYNTH, TIMING, left_nothing};
use super::unit_report::FlopMemory;
use super::work_folder::WorkFolder;
use super::{Library, NetlistDigests, SynthError, Tools, UnitKind, UnitReport, fanout, memories};

/// A synthesised unit, new or cached.
#[derive(Debug)]
pub struct SynthesisedUnit {
    /// Its report.
    pub report: UnitReport,
    /// Its gate-level netlist.
    pub netlist: String,
    /// Its key in the cache, in which no net is named.
    pub(crate) key: String,
    /// Hash of the Verilog that it was made from. A cached unit may have been made from Verilog with
    /// other names.
    pub(crate) verilog: String,
    /// Modules of its instances, by the names that they had then.
    pub(crate) instances: BTreeMap<String, String>,
    /// Whether it was cached.
    pub is_cached: bool,
}

/// Steps that [`synthesise`] reports: mapped, buffered, timed.
pub const STEPS: u64 = 3;

/// Synthesises a unit; cached in `cache` by the netlists of its modules, library, scripts and
/// programs. If interrupted, it leaves nothing in the cache. `step` is called after each step.
///
/// Names of nodes and the printed text are no part of the key: of a cached unit, the ends of the
/// longest path and the nets of the netlist may have earlier names.
///
/// # Errors
/// A program fails or prints output that is not understood; files cannot be written.
pub fn synthesise(
    config: &Config,
    unit: UnitKind,
    library: &Library,
    tools: &Tools,
    cache: &Path,
    step: &dyn Fn(),
) -> Result<SynthesisedUnit, SynthError> {
    let sources = Sources::new(config, unit)?;
    sources.synthesise(library, tools, cache, Reuse::Cached, step)
}

/// `made` with the names of today: `None` where it has them, otherwise synthesised again, and the
/// cached one replaced.
///
/// # Errors
/// As [`synthesise`].
pub(super) fn remade_with_names(
    made: &SynthesisedUnit,
    config: &Config,
    unit: UnitKind,
    library: &Library,
    tools: &Tools,
    cache: &Path,
) -> Result<Option<SynthesisedUnit>, SynthError> {
    let sources = Sources::new(config, unit)?;
    if made.verilog == sources.hash() {
        return Ok(None);
    }
    let remade = sources.synthesise(library, tools, cache, Reuse::SameVerilog, &|| ());
    remade.map(Some)
}

/// Cached units that can be used.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Reuse {
    /// Those of the same netlists.
    Cached,
    /// Those of the same Verilog.
    SameVerilog,
}

/// A unit's netlist and Verilog.
struct Sources {
    unit: UnitKind,
    module: Arc<Module>,
    /// Verilog by file name.
    files: BTreeMap<String, String>,
}

impl Sources {
    fn new(config: &Config, unit: UnitKind) -> Result<Self, SynthError> {
        let module = unit.module(config)?;
        let header = Header {
            origin: String::new(),
            command: String::new(),
        };
        Ok(Self {
            unit,
            files: verilog(&module, &header),
            module,
        })
    }

    fn hash(&self) -> String {
        content_hash::hash_of(&self.files).to_hex().to_string()
    }

    fn synthesise(
        &self,
        library: &Library,
        tools: &Tools,
        cache: &Path,
        reuse: Reuse,
        step: &dyn Fn(),
    ) -> Result<SynthesisedUnit, SynthError> {
        let (unit, files) = (self.unit, &self.files);
        let (macros, flop_memories) = memories::split(&self.module, unit);
        let is_macro = |file: &str| macros.iter().any(|m| file == format!("{}.v", m.module));
        let (memories, logic): (Vec<&str>, Vec<&str>) = files
            .keys()
            .map(String::as_str)
            .partition(|file| is_macro(file));
        let version = tools.yosys_version();
        let scripts = scripts(unit.top(), &logic, &memories, library, version);
        let netlists = NetlistDigests::new(&self.module);

        let inputs = UnitInputs {
            unit,
            yosys: &tools.yosys,
            opensta: &tools.opensta,
            library: &library.sha256,
            scripts: [&scripts.yosys, &scripts.finish, &scripts.sta],
            others: &scripts.others,
            netlists: &netlists,
        };
        let key = inputs.key();
        std::fs::create_dir_all(cache).map_err(cannot_keep(cache))?;
        let [kept, kept_netlist] = ["json", "v"].map(|ending| key.file(cache, ending));
        let own = self.hash();
        if let Some(found) = result_cache::read::<Kept>(&kept)
            && let Some(netlist) = result_cache::read_text(&kept_netlist)
            && hash_of(&netlist) == found.netlist
            && (reuse == Reuse::Cached || found.verilog == own)
        {
            return Ok(found.made(netlist, &key, true));
        }

        let mapped = Mapped::run((unit, files), &scripts, library, tools, step)?;
        let instances = self.module.instances();
        let found = Kept {
            report: mapped.report(unit, netlists, library, macros, flop_memories)?,
            netlist: hash_of(&mapped.netlist),
            verilog: own,
            instances: instances
                .map(|(name, module)| (name, module.to_owned()))
                .collect(),
        };
        let netlist = mapped.netlist;
        result_cache::write_text(&kept_netlist, &netlist).map_err(cannot_keep(&kept_netlist))?;
        result_cache::write(&kept, &found).map_err(cannot_keep(&kept))?;
        Ok(found.made(netlist, &key, false))
    }
}

/// A cached unit beside its netlist.
#[derive(Serialize, Deserialize)]
struct Kept {
    report: UnitReport,
    /// Hash of its netlist.
    netlist: String,
    /// Hash of its Verilog.
    verilog: String,
    /// Modules of its instances.
    instances: BTreeMap<String, String>,
}

impl Kept {
    fn made(self, netlist: String, key: &Key, is_cached: bool) -> SynthesisedUnit {
        SynthesisedUnit {
            report: self.report,
            netlist,
            key: key.hex(),
            verilog: self.verilog,
            instances: self.instances,
            is_cached,
        }
    }
}

/// Error for tool output that is not understood.
fn not_understood(unit: UnitKind, tool: &'static str, what: &str) -> SynthError {
    SynthError::Output {
        tool,
        unit: unit.top(),
        what: what.to_owned(),
        remedy: CHECK_LIBRARY,
    }
}

/// Results of the tools for a unit.
struct Mapped {
    /// Cells of each module, by type.
    types: Types,
    /// Inserted buffers by module.
    buffers: BTreeMap<String, u64>,
    /// Output of OpenSTA.
    timing: String,
    /// Gate-level netlist.
    netlist: String,
}

impl Mapped {
    /// Maps, buffers and times Verilog in a folder of its own; `step` is called after each.
    fn run(
        (unit, files): (UnitKind, &BTreeMap<String, String>),
        scripts: &Scripts,
        library: &Library,
        tools: &Tools,
        step: &dyn Fn(),
    ) -> Result<Self, SynthError> {
        let folder = WorkFolder::new()?;
        for (file, text) in files {
            folder.write(file, text)?;
        }
        for (file, text) in &scripts.others {
            folder.write(file, text)?;
        }
        folder.write(LIBRARY, &library.text)?;
        folder.write(SYNTH, &scripts.yosys)?;
        folder.write(FINISH, &scripts.finish)?;
        folder.write(TIMING, &scripts.sta)?;
        let no = |what: &str| not_understood(unit, "yosys", what);
        let nothing = |what: &str| left_nothing("yosys", unit.top(), what);
        tools.yosys(folder.path(), SYNTH, unit.top())?;
        step();
        let mapped = folder.read(MAPPED);
        let mapped = mapped.ok_or_else(|| nothing("leaves no netlist"))?;
        let buffered = fanout::limit(mapped.as_bytes(), unit.top(), library);
        let (buffered, buffers) = buffered.ok_or_else(|| no("netlist as JSON"))?;
        folder.write(BUFFERED, &buffered)?;
        tools.yosys(folder.path(), FINISH, unit.top())?;
        step();
        let timing = tools.sta(folder.path(), unit.top())?;
        step();
        let statistics = folder.read(STATISTICS);
        let statistics = statistics.ok_or_else(|| nothing("leaves no statistics"))?;
        let types = netlist::read_types(&statistics).ok_or_else(|| no("statistics"))?;
        let netlist = folder.read(NETLIST);
        let netlist = netlist.ok_or_else(|| nothing("leaves no netlist in cells"))?;
        Ok(Self {
            types,
            buffers,
            timing,
            netlist,
        })
    }

    /// Area by module and the longest path; macros and memories of flip-flops come from the
    /// Verilog.
    fn report(
        &self,
        unit: UnitKind,
        netlists: NetlistDigests,
        library: &Library,
        macros: Vec<MemoryMacro>,
        flop_memories: Vec<FlopMemory>,
    ) -> Result<UnitReport, SynthError> {
        let no = |tool, what: &str| not_understood(unit, tool, what);
        let modules = netlist::modules(&self.types, unit.top(), &macros, library)
            .map_err(|kind| no("yosys", &format!("known cell in place of `{kind}`")))?;
        let path = longest_path(&self.timing).ok_or_else(|| no("sta", "path"))?;
        let sum = |of: fn(&ModuleArea) -> u64| modules.iter().map(|m| m.count * of(m)).sum();
        let period_ps = (PERIOD - path.slack) * library.time_ps;
        Ok(UnitReport {
            unit: unit.to_string(),
            netlists,
            cells: sum(|m| m.cells),
            flops: sum(|m| m.flops),
            buffers: modules
                .iter()
                .map(|m| m.count * self.buffers.get(&m.module).copied().unwrap_or_default())
                .sum(),
            area_um2: modules.iter().map(|m| m.count as f64 * m.area_um2).sum(),
            period_ps,
            clock_ghz: 1e3 / period_ps,
            path: path.ends,
            path_cells: path.cells,
            modules,
            memories: macros.into_iter().map(MemoryArea::from).collect(),
            flop_memories,
            with_memories: None,
            power: None,
        })
    }
}

fn hash_of(netlist: &str) -> String {
    blake3::hash(netlist.as_bytes()).to_hex().to_string()
}

pub(super) struct LongestPath {
    pub(super) slack: f64,
    pub(super) ends: [String; 2],
    pub(super) cells: u64,
}

/// Reads the report of OpenSTA's `report_checks`.
pub(super) fn longest_path(text: &str) -> Option<LongestPath> {
    let after = |start: &str| {
        let line = text.lines().find(|line| line.starts_with(start))?;
        line[start.len()..]
            .split_whitespace()
            .next()
            .map(str::to_owned)
    };
    let slack = text.lines().find(|line| line.contains(" slack ("))?;
    let slack: f64 = slack.split_whitespace().next()?.parse().ok()?;
    // Rows of cells, from the first pin to the arrival.
    let rows = text
        .lines()
        .take_while(|line| !line.contains("data arrival"));
    let is_pin = |line: &&str| line.contains(" ^ ") || line.contains(" v ");
    let cells = rows
        .filter(is_pin)
        .filter(|line| line.contains('('))
        .count();
    slack.is_finite().then_some(LongestPath {
        slack,
        ends: [after("Startpoint: ")?, after("Endpoint: ")?],
        cells: cells as u64,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn paths_are_read() {
        let text = "Startpoint: _5_ (rising edge-triggered flip-flop clocked by clk)\n\
                    Endpoint: r/_7_ (rising edge-triggered flip-flop clocked by clk)\n\n   \
                    0.0 0.0 ^ _5_/CK (DFF)\n   1.5 1.5 v _5_/Q (DFF)\n   0.5 2.0 ^ u1/Y (NAND)\n   \
                    2.0 data arrival time\n  3.25   slack (MET)\n";
        let path = longest_path(text).unwrap();
        assert_eq!(path.ends, ["_5_", "r/_7_"]);
        assert_eq!((path.slack, path.cells), (3.25, 3));
        assert!(longest_path("No paths found.\n").is_none());
    }
}
