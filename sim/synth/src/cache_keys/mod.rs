//! Cache keys: the inputs of each cached result of this crate.
//!
//! Programs enter a key by their reported version, libraries by the SHA-256 of their text, Verilog by
//! the digests of the netlists that it was printed from, except where nets are found by name.

use std::collections::BTreeMap;

use potamoi_formats::config::Config;
use potamoi_result_cache::Key;
use serde::Serialize;

use crate::fanout::{FAN_OUT, LOAD};
use crate::{NetlistDigests, UnitKind, UnitReport};

/// Inputs of a synthesised unit.
#[derive(Clone, Copy)]
pub(crate) struct UnitInputs<'a> {
    pub(crate) unit: UnitKind,
    pub(crate) yosys: &'a str,
    pub(crate) opensta: &'a str,
    pub(crate) library: &'a str,
    /// Scripts of Yosys before and after fan-out is limited, and of OpenSTA.
    pub(crate) scripts: [&'a str; 3],
    /// Files that the scripts read, by name, apart from Verilog.
    pub(crate) others: &'a [(&'static str, String)],
    /// What the Verilog says; its text is no part of the key.
    pub(crate) netlists: &'a NetlistDigests,
}

impl UnitInputs<'_> {
    pub(crate) fn key(&self) -> Key {
        Key::new(self.unit.to_string(), "potamoi-synth 8")
            .text("limits", &format!("{FAN_OUT} {LOAD}"))
            .text("yosys", self.yosys)
            .text("opensta", self.opensta)
            .text("library", self.library)
            .value("scripts", &self.scripts)
            .value("other_files", &self.others)
            .value("netlists", self.netlists)
    }
}

/// Inputs of a netlist that is timed again.
#[derive(Clone, Copy)]
pub(crate) struct RetimeInputs<'a> {
    pub(crate) unit: UnitKind,
    /// The result wanted, and the version of its reader.
    pub(crate) wanted: [&'a str; 2],
    pub(crate) opensta: &'a str,
    pub(crate) library: &'a str,
    pub(crate) script: &'a str,
    pub(crate) netlist: &'a str,
    /// Files that the script reads, by name.
    pub(crate) others: &'a [(&'a str, &'a str)],
}

impl RetimeInputs<'_> {
    pub(crate) fn key(&self) -> Key {
        let [name, version] = self.wanted;
        Key::new(format!("{}-{name}", self.unit), version)
            .text("opensta", self.opensta)
            .text("library", self.library)
            .text("script", self.script)
            .text("netlist", self.netlist)
            .value("other_files", &self.others)
    }
}

/// Inputs of a module or of a library's cells in Yosys's output.
#[derive(Clone, Copy)]
pub(crate) struct MappedInputs<'a> {
    pub(crate) unit: &'a str,
    pub(crate) yosys: &'a str,
    pub(crate) library: &'a str,
    pub(crate) script: &'a str,
    /// Verilog and other files that the script reads, by name: nets are found by their names.
    pub(crate) texts: &'a BTreeMap<&'a str, &'a str>,
}

impl MappedInputs<'_> {
    pub(crate) fn key(&self) -> Key {
        Key::new(format!("{}-cells", self.unit), "potamoi-netlist 1")
            .text("yosys", self.yosys)
            .text("library", self.library)
            .text("script", self.script)
            .value("verilog", self.texts)
    }
}

/// Inputs of a module in Yosys's output whose nets are not named.
#[derive(Clone, Copy)]
pub(crate) struct NamelessInputs<'a> {
    pub(crate) unit: &'a str,
    pub(crate) yosys: &'a str,
    pub(crate) library: &'a str,
    pub(crate) script: &'a str,
    /// Files that the script reads, by name, apart from Verilog.
    pub(crate) others: &'a [(&'static str, String)],
    pub(crate) netlists: &'a NetlistDigests,
}

impl NamelessInputs<'_> {
    pub(crate) fn key(&self) -> Key {
        Key::new(format!("{}-nameless", self.unit), "potamoi-netlist 1")
            .text("yosys", self.yosys)
            .text("library", self.library)
            .text("script", self.script)
            .value("other_files", &self.others)
            .value("netlists", self.netlists)
    }
}

/// Inputs of a unit's power. Programs enter through the keys of the netlists that they made.
#[derive(Clone)]
pub(crate) struct PowerInputs<'a, W> {
    pub(crate) unit: UnitKind,
    pub(crate) library: &'a str,
    pub(crate) scene: &'a str,
    pub(crate) report: &'a UnitReport,
    pub(crate) config: &'a Config,
    /// Key of the unit's netlist.
    pub(crate) netlist: &'a str,
    /// Key of the netlist and weighted work of each simulated part.
    pub(crate) parts: Vec<(String, &'a [(f64, W)])>,
}

impl<W: Serialize> PowerInputs<'_, W> {
    pub(crate) fn key(&self) -> Key {
        Key::new(format!("{}-power", self.unit), "potamoi-power 4")
            .text("library", self.library)
            .text("scene", self.scene)
            .value("report", self.report)
            .value("configuration", self.config)
            .text("netlist", self.netlist)
            .value("parts", &self.parts)
    }
}

/// Inputs of a unit on an FPGA.
#[derive(Clone, Copy)]
pub(crate) struct FpgaInputs<'a> {
    pub(crate) unit: UnitKind,
    pub(crate) yosys: &'a str,
    pub(crate) nextpnr: &'a str,
    pub(crate) script: &'a str,
    /// Arguments of nextpnr, seed included.
    pub(crate) arguments: &'a [&'a str],
    /// What the Verilog says; its text is no part of the key.
    pub(crate) netlists: &'a NetlistDigests,
}

impl FpgaInputs<'_> {
    pub(crate) fn key(&self) -> Key {
        Key::new(format!("{}-ecp5", self.unit), "potamoi-fpga 2")
            .text("yosys", self.yosys)
            .text("nextpnr", self.nextpnr)
            .text("script", self.script)
            .value("arguments", &self.arguments)
            .value("netlists", self.netlists)
    }
}

/// Inputs of a memory.
#[derive(Clone, Copy)]
pub(crate) struct MemoryInputs<'a> {
    pub(crate) cacti: &'a str,
    /// Words, bits, read-write ports, write ports, read ports.
    pub(crate) shape: [u64; 5],
    /// Configuration of CACTI.
    pub(crate) configuration: &'a str,
}

impl MemoryInputs<'_> {
    pub(crate) fn key(&self) -> Key {
        Key::new("memory", "potamoi-cacti 1")
            .text("cacti", self.cacti)
            .value("shape", &self.shape)
            .text("configuration", self.configuration)
    }
}

#[cfg(test)]
mod tests;
