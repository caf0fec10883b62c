//! `Bender.yml`: the package for Bender (<https://github.com/pulp-platform/bender>).

use std::fmt::Write as _;

use super::Package;

pub(super) fn text(package: &Package) -> String {
    let mut text = package.head("#");
    let _ = write!(
        text,
        "package:\n  name: potamoi_{}\n\nsources:\n",
        package.name()
    );
    for unit in &package.units {
        text += "  - files:\n";
        for path in unit.own_verilog() {
            let _ = writeln!(text, "      - {path}");
        }
    }
    text += "  - target: test\n    files:\n";
    for unit in &package.units {
        for path in unit.bench.iter().filter(|path| path.ends_with(".v")) {
            let _ = writeln!(text, "      - {path}");
        }
    }
    text
}
