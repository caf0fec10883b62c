//! The file that holds synthesised parameters.

use potamoi_formats::config::Config;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Library, Tools, UnitReport};

/// Version of the file.
const FORMAT_VERSION: u32 = 1;

/// Parameters of a configuration's units, and where they come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SynthReport {
    format_version: u32,
    command: String,
    /// 12 hexadecimal digits.
    configuration: String,
    library: LibraryOrigin,
    tools: ToolsOrigin,
    /// What the figures leave out.
    without: Vec<String>,
    /// The units.
    pub units: Vec<UnitReport>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct LibraryOrigin {
    name: String,
    sha256: String,
    volts: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct ToolsOrigin {
    yosys: String,
    opensta: String,
}

impl SynthReport {
    /// Of units that were made so.
    #[must_use]
    pub fn new(config: &Config, library: &Library, tools: &Tools, units: Vec<UnitReport>) -> Self {
        let without = [
            "wires and the clock tree: areas are of cells, periods before placement",
            "memories: their areas, and paths that begin or end in one",
        ];
        Self {
            format_version: FORMAT_VERSION,
            command: "synth".to_owned(),
            configuration: config.hash(),
            library: LibraryOrigin {
                name: library.name.clone(),
                sha256: library.sha256.clone(),
                volts: library.volts,
            },
            tools: ToolsOrigin {
                yosys: tools.yosys.clone(),
                opensta: tools.opensta.clone(),
            },
            without: without.map(str::to_owned).to_vec(),
            units,
        }
    }
}

/// Where two reports differ, a line each: the place, what is here, and what was
/// expected.
#[must_use]
pub fn differences(here: &Value, expected: &Value) -> Vec<String> {
    let mut found = vec![];
    compare(String::new(), Some(here), Some(expected), &mut found);
    found
}

fn compare(place: String, here: Option<&Value>, expected: Option<&Value>, found: &mut Vec<String>) {
    let inside = |name: &str| match place.is_empty() {
        true => name.to_owned(),
        false => format!("{place}.{name}"),
    };
    match (here, expected) {
        (Some(Value::Object(a)), Some(Value::Object(b))) => {
            let others = b.keys().filter(|name| !a.contains_key(*name));
            for name in a.keys().chain(others) {
                compare(inside(name), a.get(name), b.get(name), found);
            }
        }
        (Some(Value::Array(a)), Some(Value::Array(b))) => {
            for i in 0..a.len().max(b.len()) {
                compare(format!("{place}[{i}]"), a.get(i), b.get(i), found);
            }
        }
        (here, expected) if here != expected => {
            let said = |v: Option<&Value>| v.map_or_else(|| "nothing".to_owned(), Value::to_string);
            found.push(format!(
                "{place}: {}, expected {}",
                said(here),
                said(expected)
            ));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn differences_are_named_by_place() {
        let a = json!({"tools": {"yosys": "0.23"}, "units": [{"cells": 1}, {"cells": 2}]});
        assert_eq!(differences(&a, &a), Vec::<String>::new());
        let b = json!({"tools": {"yosys": "0.70", "sta": "2"}, "units": [{"cells": 1}]});
        assert_eq!(
            differences(&a, &b),
            [
                "tools.yosys: \"0.23\", expected \"0.70\"",
                "tools.sta: nothing, expected \"2\"",
                "units[1]: {\"cells\":2}, expected nothing",
            ]
        );
    }
}
