//! `potamoi_npu.json`: the map for scripts.

use serde::Serialize;

use super::model::{ADDRESS_BITS, Access, Field, Register, RegisterMap, WORD_BITS};
use super::table::VERSION;

/// Version of the format of the JSON.
const FORMAT_VERSION: u32 = 1;

#[derive(Serialize)]
struct Document<'a> {
    format_version: u32,
    name: &'static str,
    configuration: &'a str,
    /// Version of the map, as in the register `VERSION`.
    version: String,
    address_bits: u32,
    word_bits: u32,
    registers: Vec<Entry<'a>>,
}

#[derive(Serialize)]
struct Entry<'a> {
    name: &'a str,
    offset: u32,
    access: Access,
    /// Whether what is read changes without a write, or is not what was written.
    volatile: bool,
    reset: u32,
    description: &'a str,
    fields: &'a [Field],
}

/// The map as JSON.
#[must_use]
pub fn json(map: &RegisterMap) -> String {
    let document = Document {
        format_version: FORMAT_VERSION,
        name: "potamoi_npu",
        configuration: &map.configuration,
        version: VERSION
            .iter()
            .map(u32::to_string)
            .collect::<Vec<_>>()
            .join("."),
        address_bits: ADDRESS_BITS,
        word_bits: WORD_BITS,
        registers: map.registers.iter().map(entry).collect(),
    };
    // Numbers, texts and lists of them.
    serde_json::to_string_pretty(&document).unwrap_or_default() + "\n"
}

fn entry(own: &Register) -> Entry<'_> {
    Entry {
        name: &own.name,
        offset: own.offset,
        access: own.access,
        volatile: own.access.is_volatile(),
        reset: own.reset(),
        description: &own.description,
        fields: &own.fields,
    }
}
