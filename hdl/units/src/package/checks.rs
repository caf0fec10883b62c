//! Proofs for SymbiYosys, and the modules that the checks are instances of.

use std::collections::BTreeMap;

use potamoi_netlist::{Header, check_modules};

use super::{Package, Unit};

/// Folder of the modules.
const CHECKS: &str = "checks";

/// The modules, and a task for each unit.
pub(super) fn files(package: &Package) -> BTreeMap<String, String> {
    let header = Header {
        origin: package.origin.join("\n// "),
        command: String::new(),
    };
    let modules = check_modules(&header).into_iter();
    let modules = modules.map(|(file, text)| (format!("{CHECKS}/{file}"), text));
    let mut files: BTreeMap<String, String> = modules.collect();
    let checks: Vec<String> = files.keys().cloned().collect();
    for unit in &package.units {
        files.insert(format!("{}.sby", unit.name), task(package, unit, &checks));
    }
    files
}

fn task(package: &Package, unit: &Unit, checks: &[String]) -> String {
    let paths: Vec<&str> = unit
        .verilog
        .iter()
        .chain(checks)
        .map(String::as_str)
        .collect();
    let names: Vec<&str> = paths
        .iter()
        .filter_map(|path| path.rsplit('/').next())
        .collect();
    let cut: String = match unit.data_modules.is_empty() {
        true => String::new(),
        false => format!("cutpoint {}\n", unit.data_modules.join(" ")),
    };
    format!(
        "{}#\n# SymbiYosys, with Yices: sby -f {}.sby. Data is left out: modules without checks give any\n\
         # outputs, and one bit of a payload stands for all.\n\n\
         [tasks]\nprove\ncover\n\n\
         [options]\nprove: mode prove\nprove: depth 2\ncover: mode cover\ncover: depth 30\n\n\
         [engines]\nsmtbmc yices\n\n\
         [script]\nread_verilog -formal -DPOTAMOI_CHECKS -DPOTAMOI_ONE_BIT {}\n\
         hierarchy -top {}\nproc\n{cut}flatten\nprep -top {}\n\n[files]\n{}\n",
        package.head("#"),
        unit.name,
        names.join(" "),
        unit.top,
        unit.top,
        paths.join("\n"),
    )
}
