//! `UNIT.f`: the files of a unit, for `-f` of simulators and synthesis tools.

use super::{Package, Unit};

pub(super) fn text(package: &Package, unit: &Unit) -> String {
    let mut text = package.head("//");
    text += "// Paths are from the folder of this file.\n";
    for path in &unit.verilog {
        text += path;
        text.push('\n');
    }
    text
}
