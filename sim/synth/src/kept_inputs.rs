//! What each kept result of this crate depends on, and its key.
//!
//! Programs are parts by what they say of their version, libraries by the SHA-256 of their text.

use std::collections::BTreeMap;

use potamoi_formats::config::Config;
use potamoi_kept::Key;
use serde::Serialize;

use crate::fanout::{FAN_OUT, LOAD};
use crate::{UnitKind, UnitReport};

/// Of a unit in cells.
#[derive(Clone, Copy)]
pub(crate) struct UnitInputs<'a> {
    pub(crate) unit: UnitKind,
    pub(crate) yosys: &'a str,
    pub(crate) opensta: &'a str,
    pub(crate) library: &'a str,
    /// Of Yosys before and after fan-out is limited, and of OpenSTA.
    pub(crate) scripts: [&'a str; 3],
    /// Files that the scripts read, by name.
    pub(crate) others: &'a [(&'static str, String)],
    pub(crate) verilog: &'a BTreeMap<String, String>,
}

impl UnitInputs<'_> {
    pub(crate) fn key(&self) -> Key {
        Key::new(self.unit.to_string(), "potamoi-synth 5")
            .text("limits", &format!("{FAN_OUT} {LOAD}"))
            .text("yosys", self.yosys)
            .text("opensta", self.opensta)
            .text("library", self.library)
            .value("scripts", &self.scripts)
            .value("other_files", &self.others)
            .value("verilog", self.verilog)
    }
}

/// Of a netlist that is timed once more.
#[derive(Clone, Copy)]
pub(crate) struct RetimeInputs<'a> {
    pub(crate) unit: UnitKind,
    /// What is looked for, and the version of how it is read.
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

/// Of a module, or of a library's cells, as Yosys writes it.
#[derive(Clone, Copy)]
pub(crate) struct MappedInputs<'a> {
    pub(crate) unit: &'a str,
    pub(crate) yosys: &'a str,
    pub(crate) library: &'a str,
    pub(crate) script: &'a str,
    /// Verilog and what the script reads beside it, by name.
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

/// Of a unit's power. Programs are in it by the netlists that they made.
#[derive(Clone)]
pub(crate) struct PowerInputs<'a, W> {
    pub(crate) unit: UnitKind,
    pub(crate) library: &'a str,
    pub(crate) scene: &'a str,
    pub(crate) report: &'a UnitReport,
    pub(crate) config: &'a Config,
    pub(crate) netlist: &'a str,
    /// Netlist and shares of work of each part that is simulated.
    pub(crate) parts: Vec<(&'a str, &'a [(f64, W)])>,
}

impl<W: Serialize> PowerInputs<'_, W> {
    pub(crate) fn key(&self) -> Key {
        Key::new(format!("{}-power", self.unit), "potamoi-power 3")
            .text("library", self.library)
            .text("scene", self.scene)
            .value("report", self.report)
            .value("configuration", self.config)
            .text("netlist", self.netlist)
            .value("parts", &self.parts)
    }
}

/// Of a unit in an FPGA.
#[derive(Clone, Copy)]
pub(crate) struct FpgaInputs<'a> {
    pub(crate) unit: UnitKind,
    pub(crate) yosys: &'a str,
    pub(crate) nextpnr: &'a str,
    pub(crate) script: &'a str,
    /// Of nextpnr; the seed is among them.
    pub(crate) arguments: &'a [&'a str],
    pub(crate) verilog: &'a BTreeMap<String, String>,
}

impl FpgaInputs<'_> {
    pub(crate) fn key(&self) -> Key {
        Key::new(format!("{}-ecp5", self.unit), "potamoi-fpga 1")
            .text("yosys", self.yosys)
            .text("nextpnr", self.nextpnr)
            .text("script", self.script)
            .value("arguments", &self.arguments)
            .value("verilog", self.verilog)
    }
}

/// Of a memory.
#[derive(Clone, Copy)]
pub(crate) struct MemoryInputs<'a> {
    pub(crate) cacti: &'a str,
    /// Words, bits, ports that read or write, that write, that read.
    pub(crate) shape: [u64; 5],
    /// What CACTI is given.
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
