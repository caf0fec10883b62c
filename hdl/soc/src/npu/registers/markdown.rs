//! `potamoi_npu.md`: the map as tables.

use std::fmt::Write as _;

use super::model::{Register, RegisterMap};

/// The map as a page. `command` is the command that writes it again.
#[must_use]
pub fn markdown(map: &RegisterMap, command: &str) -> String {
    let mut text = "# Registers of potamoi_npu_ext\n\n".to_owned();
    for line in map.origin(command) {
        text += &line;
        text.push('\n');
    }
    text + "\n" + &tables(map)
}

/// The tables alone: all registers, then the fields of each.
#[must_use]
pub fn tables(map: &RegisterMap) -> String {
    let mut text =
        "| offset | register | access | after reset | |\n|---|---|---|---|---|\n".to_owned();
    for own in &map.registers {
        let _ = writeln!(
            text,
            "| `{:#05x}` | `{}` | {} | `{:#x}` | {} |",
            own.offset,
            own.name,
            own.access.short(),
            own.reset(),
            own.description
        );
    }
    text += "\nFields. Bits that no field has are read as 0, and writes to them have no effect.\n\n\
             | register | bits | field | after reset | |\n|---|---|---|---|---|\n";
    for own in &map.registers {
        fields(&mut text, own);
    }
    text
}

fn fields(text: &mut String, own: &Register) {
    for field in &own.fields {
        let bits = match field.width {
            1 => field.low.to_string(),
            width => format!("{}:{}", field.low + width - 1, field.low),
        };
        let _ = writeln!(
            text,
            "| `{}` | {bits} | `{}` | `{:#x}` | {} |",
            own.name, field.name, field.reset, field.description
        );
    }
}
