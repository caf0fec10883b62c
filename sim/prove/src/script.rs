//! The Yosys script that turns the Verilog of a unit into a transition system.

use std::collections::BTreeSet;

use potamoi_netlist::every_index;

/// The cells of checks that a system is to have.
pub(crate) enum Kept<'a> {
    /// All assertions but these.
    AllBut(&'a [String]),
    /// These assertions alone.
    Only(&'a [String]),
    /// The cover points.
    Covers,
}

/// The commands that read all Verilog of a folder. Where nothing is written, `proc` leaves address and
/// data of a memory open, and the last command takes the choice away: a fault there would be one that
/// no hardware has.
pub(crate) fn load(top: &str, all_bits: bool) -> [String; 4] {
    let one_bit = if all_bits { "" } else { " -DPOTAMOI_ONE_BIT" };
    [
        format!("read_verilog -formal -DPOTAMOI_CHECKS{one_bit} *.v"),
        format!("hierarchy -top {top}"),
        "proc".to_owned(),
        "opt_expr -mux_undef".to_owned(),
    ]
}

/// The script: it reads Verilog by `lines`, and writes `to`.
pub(crate) fn script(
    mut lines: Vec<String>,
    cut: &BTreeSet<String>,
    kept: &Kept<'_>,
    to: &str,
) -> String {
    if !cut.is_empty() {
        let names: Vec<&str> = cut.iter().map(String::as_str).collect();
        lines.push(format!("cutpoint {}", names.join(" ")));
    }
    lines.push("flatten".to_owned());
    match kept {
        Kept::AllBut(names) => {
            lines.push("delete t:$cover".to_owned());
            lines.extend(names.iter().map(|name| format!("delete {}", cell(name))));
        }
        Kept::Only(names) => {
            lines.push("delete t:$cover".to_owned());
            let left: Vec<String> = names
                .iter()
                .map(|name| format!("{} %d", cell(name)))
                .collect();
            lines.push(format!("delete t:$assert {}", left.join(" ")));
        }
        Kept::Covers => lines.push("delete t:$assert".to_owned()),
    }
    for pass in [
        "opt -full -nodffe -nosdff",
        "memory_map",
        "opt -full -nodffe -nosdff",
        "async2sync",
        "dffunmap",
        "setundef -anyseq",
    ] {
        lines.push(pass.to_owned());
    }
    lines.push(format!("write_smt2 -wires {to}"));
    lines.push(String::new());
    lines.join("\n")
}

/// Selects the cell of a check; in an array those of all elements.
fn cell(path: &str) -> String {
    format!("c:{}", cell_name(path).replace("[]", "*"))
}

/// Name of the cell of an assertion, from its path.
pub(crate) fn cell_name(path: &str) -> String {
    match path.rsplit_once('.') {
        Some((instances, name)) => format!("{instances}.check_{name}.holds"),
        None => format!("check_{path}.holds"),
    }
}

/// Path of a check, from the name of its cell.
pub(crate) fn path_of(cell: &str) -> String {
    let cell = cell.rsplit_once('.').map_or(cell, |(path, _)| path);
    every_index(&cell.replace("check_", ""))
}
