//! `potamoi.core`: the package for FuseSoC, in its format CAPI2.

use std::fmt::Write as _;

use super::{Package, Unit};

/// Plusargs of the benches.
const PARAMETERS: &str = "
parameters:
  gaps:
    datatype: int
    default: 0
    description: Percentage of clocks in which sources and sinks pause
    paramtype: plusarg
  seed:
    datatype: int
    default: 1
    description: Seed of the pauses
    paramtype: plusarg
";

pub(super) fn text(package: &Package) -> String {
    let mut text = String::from("CAPI=2:\n");
    text += &package.head("#");
    let _ = write!(
        text,
        "name: potamoi::{}:{}\ndescription: Units of a neural rendering accelerator\n\nfilesets:\n",
        package.name(),
        package.version
    );
    for unit in &package.units {
        filesets(&mut text, unit);
    }
    text += PARAMETERS;
    text += "\ntargets:\n  default:\n    filesets:\n";
    for unit in &package.units {
        let _ = writeln!(text, "      - {}", unit.name);
    }
    for unit in &package.units {
        targets(&mut text, unit);
    }
    text
}

fn filesets(text: &mut String, unit: &Unit) {
    let name = unit.name;
    let _ = writeln!(text, "  {name}:\n    files:");
    for path in unit.own_verilog() {
        let _ = writeln!(text, "      - {path}");
    }
    text.push_str("    file_type: verilogSource-2005\n");
    let _ = writeln!(text, "  {name}_bench:\n    files:");
    for path in &unit.bench {
        // The bench reads its memories in the folder that it runs in.
        match path.rsplit_once('/') {
            Some((_, file)) if file.ends_with(".hex") => {
                let _ = writeln!(text, "      - {path}: {{file_type: user, copyto: {file}}}");
            }
            _ => {
                let _ = writeln!(text, "      - {path}: {{file_type: verilogSource-2005}}");
            }
        }
    }
}

fn targets(text: &mut String, unit: &Unit) {
    let (name, top) = (unit.name, &unit.top);
    let parts = unit.parts.iter().map(|part| format!("      - {part}\n"));
    let parts: String = parts.collect();
    let _ = write!(
        text,
        "  lint_{name}:
    description: Verilator without a waiver
    filesets:
{parts}    toplevel: {top}
    flow: lint
    flow_options:
      tool: verilator
      verilator_options: [-Wall]
  sim_{name}:
    description: Golden vectors; with Verilator by --tool=verilator after the name of the core
    filesets:
{parts}      - {name}_bench
    toplevel: {name}_tb
    parameters:
      - gaps
      - seed
    flow: sim
    flow_options:
      tool: icarus
      iverilog_options: [-g2005, -Wall, -Wno-timescale]
      verilator_options: [--binary, --timing, --trace, -Wno-fatal, -Wno-lint, -Wno-WIDTH]
"
    );
}
