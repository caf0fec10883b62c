//! One build of a unit with all its mutants.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use potamoi_netlist::{Header, PortInfo, verilog};
use potamoi_prove::Unit;
use tempfile::TempDir;

use crate::tools::{no_result, read, write};
use crate::{Mutant, MutateError, Tools};

/// Input that tells which mutant is active.
pub(crate) const SELECT: &str = "potamoi_mutant";

/// Which mutants a design gets.
#[derive(Debug, Clone)]
pub struct Draw {
    /// Mutants of every module; fewer where it has fewer.
    pub mutants: u32,
    /// Modules that get mutants, by name; all if there is none.
    pub modules: BTreeSet<String>,
    /// Seed of the mutants; equal seeds draw equal ones.
    pub seed: u64,
}

/// A unit with its mutants.
#[derive(Debug)]
pub struct Design {
    /// The unit without a fault.
    pub unit: Unit,
    /// The mutants, those of a module together.
    pub mutants: Vec<Mutant>,
    folder: TempDir,
}

impl Design {
    /// Draws the mutants.
    ///
    /// # Errors
    /// Yosys fails, or a file cannot be written.
    pub fn new(tools: &Tools, unit: &Unit, draw: &Draw) -> Result<Self, MutateError> {
        let folder = unit.files()?;
        let (count, seed) = (draw.mutants, draw.seed);
        let modules = chosen_modules(unit, &draw.modules);
        let mut lines = unit.load().to_vec();
        // The checks are not mutated. They are deleted after they are read, so that cells are named
        // as where they are proven.
        lines.push("delete */t:potamoi_* */t:$paramod*potamoi_*".to_owned());
        lines.push(format!("hierarchy -top {}", unit.module.name()));
        lines.push("opt_clean -purge".to_owned());
        lines.push("write_rtlil hardware.il".to_owned());
        for module in &modules {
            // The read port of a memory is no cell of the hardware: what feeds it and what it feeds are.
            lines.push(format!(
                "mutate -list {count} -seed {seed} -o {module}.list {module}/c:* {module}/t:$memrd* %d"
            ));
        }
        tools.yosys(folder.path(), &lines, &unit.name)?;
        let mut mutants = vec![];
        for module in &modules {
            let list = read(&folder.path().join(format!("{module}.list")))?;
            for line in list.lines() {
                let mutant = Mutant::parse(mutants.len() + 1, line);
                mutants.push(mutant.ok_or_else(|| no_result("yosys", &unit.name, line))?);
            }
        }
        let design = Self {
            unit: unit.clone(),
            mutants,
            folder,
        };
        tools.yosys(design.folder.path(), &design.build(), &unit.name)?;
        Ok(design)
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Bits of the input that selects.
    pub(crate) const fn width(&self) -> u32 {
        usize::BITS - self.mutants.len().leading_zeros()
    }

    fn build(&self) -> Vec<String> {
        let (width, top) = (self.width(), self.unit.module.name());
        let mut lines = vec![
            "read_rtlil hardware.il".to_owned(),
            format!("add -global_input {SELECT} {width}"),
        ];
        let faults = self.mutants.iter();
        lines.extend(faults.map(|m| format!("{} -ctrl {SELECT} {width} {}", m.command, m.number)));
        lines.push("write_rtlil mutated.il".to_owned());
        lines.push(format!("rename {top} {top}_mutated"));
        lines.push("write_verilog -noattr mutated.v".to_owned());
        lines
    }

    /// Verilog of the unit, by file. The active mutant is `number`, unless a simulation is given
    /// another as `+mutant=N`.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn verilog(&self, number: usize) -> Result<BTreeMap<String, String>, MutateError> {
        let top = self.unit.module.name();
        Ok(BTreeMap::from([
            (format!("{top}.v"), self.wrapper(number)),
            (
                format!("{top}_mutated.v"),
                read(&self.folder().join("mutated.v"))?,
            ),
        ]))
    }

    fn wrapper(&self, number: usize) -> String {
        let top = self.unit.module.name();
        let width = self.width();
        let ports = self.unit.module.ports();
        let declared: Vec<String> = ports.iter().map(declaration).collect();
        let names = ports.iter().map(|p| p.name.as_str());
        let mut text = format!(
            "module {top} (\n  input wire clk,\n  input wire rst_n,\n{}\n);\n  \
             reg [{}:0] mutant;\n  \
             initial if (!$value$plusargs(\"mutant=%d\", mutant)) mutant = {width}'d{number};\n  \
             {top}_mutated unit (\n    .{SELECT}(mutant)",
            declared.join(",\n"),
            width - 1
        );
        for name in ["clk", "rst_n"].into_iter().chain(names) {
            let _ = write!(text, ",\n    .{name}({name})");
        }
        text + "\n  );\nendmodule\n"
    }

    /// Writes the netlist of a module for a miter: submodules are cut, and memories are registers.
    pub(crate) fn blif(&self, tools: &Tools, module: &str) -> Result<String, MutateError> {
        let file = format!("{module}.blif");
        let below = modules(&self.unit).into_iter();
        let below: Vec<String> = below.map(|b| format!("{module}/t:{b}")).collect();
        let lines = [
            "read_rtlil mutated.il".to_owned(),
            format!("memory_map {module}"),
            // All other things that are selected would be outputs, too.
            format!("expose -evert {}", below.join(" ")),
            format!("opt_clean {module}"),
            "design -save all".to_owned(),
            "design -reset".to_owned(),
            format!("design -copy-from all -as {module} {module}"),
            // What is undefined is the same in all mutants.
            "setundef -zero".to_owned(),
            "opt_expr; opt_clean; techmap; simplemap; opt_expr; opt_clean; aigmap".to_owned(),
            format!("write_blif {file}"),
        ];
        tools.yosys(self.folder(), &lines, module)?;
        read(&self.folder().join(file))
    }

    /// The netlist without a fault, in RTLIL.
    pub(crate) fn netlist(&self) -> Result<String, MutateError> {
        read(&self.folder().join("hardware.il"))
    }

    pub(crate) fn write(&self, name: &str, text: &str) -> Result<(), MutateError> {
        write(&self.folder().join(name), text)
    }
}

/// Modules of a unit that get mutants: those of these names, or all if there is none. Units within the
/// SoC top are mutated by themselves.
#[must_use]
pub fn chosen_modules(unit: &Unit, names: &BTreeSet<String>) -> BTreeSet<String> {
    let mut all = unit.module.modules_outside(&unit.apart);
    all.retain(|module| names.is_empty() || names.contains(module));
    all
}

/// All modules of a unit by name.
fn modules(unit: &Unit) -> Vec<String> {
    let files = verilog(&unit.module, &Header::default());
    let names = files.keys().filter_map(|file| file.strip_suffix(".v"));
    names.map(str::to_owned).collect()
}

fn declaration(port: &PortInfo) -> String {
    let way = if port.output { "output" } else { "input" };
    let width = port.ty.width;
    format!("  {way} wire [{}:0] {}", width - 1, port.name)
}
