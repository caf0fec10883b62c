//! `potamoi_npu.rdl`: the map as SystemRDL 2.0 (Accellera).

use std::fmt::Write as _;

use super::model::{Access, Field, Register, RegisterMap, WORD_BITS};

/// The map as SystemRDL. `prefix` begins its name, as those of the modules; `command` is the command
/// that writes it again.
#[must_use]
pub fn system_rdl(map: &RegisterMap, prefix: &str, command: &str) -> String {
    let mut text = String::new();
    for line in map.origin(command) {
        let _ = writeln!(text, "// {line}");
    }
    let _ = write!(
        text,
        "
addrmap {prefix}potamoi_npu {{
  name = \"Potamoi NPU\";
  desc = \"Registers of the gathering unit and the vector unit behind AXI4-Lite\";
  default regwidth = {WORD_BITS};
  default accesswidth = {WORD_BITS};
"
    );
    for own in &map.registers {
        register(&mut text, own);
    }
    text + "};\n"
}

fn register(text: &mut String, own: &Register) {
    let _ = write!(text, "\n  reg {{\n    desc = \"{}\";\n", own.description);
    for field in &own.fields {
        let _ = writeln!(
            text,
            "    field {{ {} desc = \"{}\"; }} {}[{}:{}]{};",
            properties(own.access),
            field.description,
            field.name,
            field.low + field.width - 1,
            field.low,
            reset(own.access, field),
        );
    }
    let _ = writeln!(text, "  }} {} @ {:#05x};", own.name, own.offset);
}

const fn properties(access: Access) -> &'static str {
    match access {
        Access::Constant => "sw = r; hw = na;",
        Access::Status => "sw = r; hw = w;",
        Access::ReadWrite => "sw = rw; hw = r;",
        Access::WriteOneToClear => "sw = rw; hw = r; onwrite = woclr; hwset;",
        Access::Pulse => "sw = w; hw = r; singlepulse;",
    }
}

/// A field that follows the hardware has no storage that a reset would set.
fn reset(access: Access, field: &Field) -> String {
    match access {
        Access::Status => String::new(),
        _ => format!(" = {}'h{:x}", field.width, field.reset),
    }
}
