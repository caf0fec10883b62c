//! Proofs for SymbiYosys, and the modules that the checks are instances of.

use std::collections::BTreeMap;

use potamoi_netlist::{Header, check_modules};

use super::{Package, Proof, Unit};

/// Folder of the modules.
const CHECKS: &str = "checks";
/// Longest run in which a cover point is looked for: filling a FIFO through a pipeline takes longest.
const COVER_DEPTH: u32 = 60;

/// The modules, and a task for each unit.
pub(super) fn files(package: &Package) -> BTreeMap<String, String> {
    let mut files: BTreeMap<String, String> = modules(package.origin.join("\n// ")).collect();
    let checks: Vec<String> = files.keys().cloned().collect();
    for unit in &package.units {
        files.insert(format!("{}.sby", unit.name), task(package, unit, &checks));
    }
    files
}

/// The modules that checks are instances of, by path.
pub(crate) fn modules(origin: String) -> impl Iterator<Item = (String, String)> {
    let header = Header {
        origin,
        command: String::new(),
    };
    let files = check_modules(&header).into_iter();
    files.map(|(file, text)| (format!("{CHECKS}/{file}"), text))
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
    let mut tasks = vec![("cover".to_owned(), &unit.proofs[0])];
    tasks.extend(unit.proofs.iter().enumerate().map(|(at, proof)| {
        let name = if at == 0 { "prove" } else { &proof.top };
        (name.to_owned(), proof)
    }));
    tasks.push(("all_bits".to_owned(), &unit.proofs[0]));
    let names_of_tasks: Vec<&str> = tasks.iter().map(|(name, _)| name.as_str()).collect();
    let options: String = names_of_tasks.iter().map(|task| options(task)).collect();
    let scripts: String = tasks
        .iter()
        .map(|(task, proof)| script(task, proof))
        .collect();
    let verilog = names.join(" ");
    format!(
        "{}#\n# SymbiYosys, with Yices: sby -f {}.sby. Data is left out: modules without checks, and those with\n\
         # a task of their own, give any outputs. Task `all_bits` is `prove` with whole payloads; in the others\n\
         # bit 0 of a payload stands for all, so that they do not see a fault of another bit.\n\n\
         [tasks]\n{}\n\n\
         [options]\n{options}\n\
         [engines]\nsmtbmc yices\n\n\
         [script]\n\
         ~all_bits: read_verilog -formal -DPOTAMOI_CHECKS -DPOTAMOI_ONE_BIT {verilog}\n\
         all_bits: read_verilog -formal -DPOTAMOI_CHECKS {verilog}\n{scripts}\n\
         [files]\n{}\n",
        package.head("#"),
        unit.name,
        names_of_tasks.join("\n"),
        paths.join("\n"),
    )
}

fn options(task: &str) -> String {
    match task {
        "cover" => format!("cover: mode cover\ncover: depth {COVER_DEPTH}\n"),
        _ => format!("{task}: mode prove\n{task}: depth 2\n"),
    }
}

/// Commands of a task, once all Verilog is read.
fn script(task: &str, Proof { top, left_out }: &Proof) -> String {
    let mut lines = vec![format!("hierarchy -top {top}"), "proc".to_owned()];
    if !left_out.is_empty() {
        lines.push(format!("cutpoint {}", left_out.join(" ")));
    }
    lines.extend(["flatten".to_owned(), format!("prep -top {top}")]);
    let lines = lines.iter().map(|line| format!("{task}: {line}\n"));
    lines.collect()
}
