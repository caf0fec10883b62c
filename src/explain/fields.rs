//! Fields of configurations, systems, scenes, paths and machines, each from the text that defines it:
//! the documentation of the structure that a file is read into, or the page's own table of keys.

use std::collections::BTreeMap;

use potamoi_formats::config::{Config, ConfigError, PRESETS};
use potamoi_system::system_model::{System, SystemError};
use schemars::JsonSchema;
use serde::Serialize;

use super::rustdoc::{Definitions, Field};

/// Sources of a configuration's structures.
const CONFIGURATION: [&str; 7] = [
    include_str!("../../formats/src/config/mod.rs"),
    include_str!("../../formats/src/config/gu.rs"),
    include_str!("../../formats/src/config/vu.rs"),
    include_str!("../../formats/src/config/su.rs"),
    include_str!("../../formats/src/config/exponential/knobs.rs"),
    include_str!("../../formats/src/units.rs"),
    include_str!("../../formats/src/rit.rs"),
];
/// Sources of a system's structures.
const SYSTEM: [&str; 2] = [
    include_str!("../../sim/system/src/system_model/system.rs"),
    include_str!("../../sim/system/src/system_model/gpu.rs"),
];
/// Pages with tables of keys.
const FILES: &str = include_str!("../../docs/reference/files.md");
const MACHINES: &str = include_str!("../../docs/reference/machines.md");
/// A number that no field allows.
const TOO_LARGE: u32 = 4_000_000_000;

/// A field of a file.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Explained {
    /// Path of the field, as in plans of sweeps.
    pub(crate) field: String,
    /// File that it belongs to.
    pub(crate) file: &'static str,
    pub(crate) meaning: String,
    /// Values of an enumeration with their meanings.
    pub(crate) values: Vec<(String, String)>,
    /// Kind of the value.
    pub(crate) kind: Option<String>,
    pub(crate) range: Option<String>,
    pub(crate) default: Option<String>,
    /// Presets that set it otherwise, with their values.
    pub(crate) presets: Vec<(&'static str, String)>,
    pub(crate) page: &'static str,
}

/// The type between the brackets of `Option<...>`.
fn optional(kind: &str) -> Option<&str> {
    kind.strip_prefix("Option<")?.strip_suffix('>')
}

/// A type in words.
fn words(kind: &str) -> Option<String> {
    let own = optional(kind).unwrap_or(kind);
    if let Some(each) = own
        .strip_prefix("Vec<")
        .and_then(|own| own.strip_suffix('>'))
    {
        return Some(match words(each) {
            Some(each) => format!("list of: {each}"),
            None => "list of names".to_owned(),
        });
    }
    Some(match own {
        "u32" | "u64" | "i32" => "whole number".to_owned(),
        "f64" => "number".to_owned(),
        "bool" => "true or false".to_owned(),
        "Format" => "number format, such as \"U3.13\" or \"S3.12\"".to_owned(),
        "Vertices" => "1, 2, 4 or 8".to_owned(),
        "MemoryDevice" | "Device" => "name, or file".to_owned(),
        "[u32; 2]" => "two whole numbers".to_owned(),
        _ => return None,
    })
}

/// Page of a configuration's or a system's field.
fn page(field: &str) -> &'static str {
    match field.split('.').next().unwrap_or_default() {
        "vu" => "docs/reference/vector-unit.md",
        "su" => "docs/reference/splat-unit.md",
        "system" => "docs/explanation/system.md",
        _ => "docs/reference/gathering-unit.md",
    }
}

/// Name of a field in files.
fn name_in_files(name: &str) -> &str {
    match name {
        "clock_mhz" => "clock_ghz",
        name => name,
    }
}

/// Fields of a structure and of those in it, with their paths.
fn walk(all: &Definitions, of: &str, prefix: &str, into: &mut Vec<(String, Field)>) {
    for field in all.structs.get(of).into_iter().flatten() {
        let path = format!("{prefix}{}", name_in_files(&field.name));
        let kind = optional(&field.kind).unwrap_or(&field.kind);
        match all.structs.contains_key(kind) {
            true => walk(all, kind, &format!("{path}."), into),
            false => into.push((path, field.clone())),
        }
    }
}

/// Value of a path in a table.
fn value_at<'a>(table: &'a toml::Table, path: &str) -> Option<&'a toml::Value> {
    let (first, rest) = match path.split_once('.') {
        Some((first, rest)) => (first, Some(rest)),
        None => (path, None),
    };
    let own = table.get(first)?;
    match rest {
        None => Some(own),
        Some(rest) => value_at(own.as_table()?, rest),
    }
}

/// A line of TOML that sets a path.
fn line(path: &str, value: &str) -> String {
    match path.rsplit_once('.') {
        Some((table, key)) => format!("[{table}]\n{key} = {value}\n"),
        None => format!("{path} = {value}\n"),
    }
}

/// What is allowed of a configuration's field, as the refusal of another value says.
fn allowed(path: &str, kind: &str) -> Option<String> {
    let odd = match words(kind).as_deref() {
        Some("whole number" | "number") => TOO_LARGE.to_string(),
        None => "\"?\"".to_owned(),
        Some(_) => return None,
    };
    match Config::from_toml(&line(path, &odd), "") {
        Err(ConfigError::Rules { breaches, .. }) => {
            let mut own = breaches.0.into_iter().filter(|own| own.field == path);
            own.next().map(|own| own.expected)
        }
        Err(ConfigError::Parse { message, .. }) => message
            .split_once("expected ")
            .map(|(_, rest)| rest.to_owned()),
        _ => None,
    }
}

/// Sets a path of a table.
fn set(table: &mut toml::Table, path: &str, value: toml::Value) {
    match path.split_once('.') {
        None => {
            table.insert(path.to_owned(), value);
        }
        Some((first, rest)) => {
            if let Some(own) = table.get_mut(first).and_then(toml::Value::as_table_mut) {
                set(own, rest, value);
            }
        }
    }
}

/// The same of a system's.
fn allowed_of_system(path: &str, kind: &str) -> Option<String> {
    let odd = match kind {
        "u32" => toml::Value::Integer(TOO_LARGE.into()),
        "u64" => toml::Value::Integer(i64::MAX),
        "f64" => toml::Value::Float(1e30),
        _ => return None,
    };
    let mut table = toml::Table::try_from(System::default()).ok()?;
    set(&mut table, path, odd);
    match System::from_toml(&toml::to_string(&table).ok()?, "") {
        Err(SystemError::Value { expected, .. }) => Some(expected.to_owned()),
        _ => None,
    }
}

fn documented(sources: &[&str]) -> Definitions {
    let mut all = Definitions::default();
    sources.iter().for_each(|source| all.read(source));
    all
}

/// Values of an enumeration of the program, with their meanings.
fn values(all: &Definitions, kind: &str) -> Vec<(String, String)> {
    let own = optional(kind).unwrap_or(kind);
    let own = own
        .strip_prefix("Vec<")
        .and_then(|own| own.strip_suffix('>'))
        .unwrap_or(own);
    if words(own).is_some() {
        return vec![];
    }
    let own = all.enums.get(own).into_iter().flatten();
    own.map(|value| (value.name.clone(), value.meaning.clone()))
        .collect()
}

fn of_configuration() -> Vec<Explained> {
    let all = documented(&CONFIGURATION);
    let mut found = vec![];
    walk(&all, "Config", "", &mut found);
    let table = |config: &Config| -> toml::Table {
        let text = config.to_toml().unwrap_or_default();
        text.parse().unwrap_or_default()
    };
    let own = table(&Config::paper());
    let presets: BTreeMap<&str, toml::Table> = (PRESETS.into_iter())
        .filter_map(|(name, _)| Some((name, table(&Config::preset(name)?))))
        .collect();
    let explained = |(path, field): (String, Field)| {
        let default = value_at(&own, &path);
        let others = PRESETS.into_iter().filter_map(|(name, _)| {
            let value = value_at(presets.get(name)?, &path)?;
            (Some(value) != default).then(|| (name, value.to_string()))
        });
        Explained {
            file: "configuration",
            values: values(&all, &field.kind),
            range: allowed(&path, &field.kind),
            default: default.map(ToString::to_string),
            presets: others.collect(),
            page: page(&path),
            kind: words(&field.kind),
            meaning: field.meaning,
            field: path,
        }
    };
    found.into_iter().map(explained).collect()
}

fn of_system() -> Vec<Explained> {
    let all = documented(&SYSTEM);
    let mut found = vec![];
    walk(&all, "System", "", &mut found);
    let own = toml::Table::try_from(System::default()).unwrap_or_default();
    let explained = |(path, field): (String, Field)| Explained {
        file: "system",
        values: vec![],
        range: allowed_of_system(&path, &field.kind),
        default: value_at(&own, &path).map(ToString::to_string),
        presets: vec![],
        kind: words(&field.kind),
        meaning: field.meaning,
        field: format!("system.{path}"),
        page: page("system"),
    };
    found.into_iter().map(explained).collect()
}

/// Rows of the tables of a part of a page: cells without their marks.
fn rows<'a>(page: &'a str, from: &str) -> impl Iterator<Item = Vec<&'a str>> {
    let part = page.split_once(from).map_or("", |(_, rest)| rest);
    let part = part.split("\n#").next().unwrap_or_default();
    part.lines().filter_map(|line| {
        let cells = line.strip_prefix("| ")?.strip_suffix(" |")?;
        Some(cells.split(" | ").collect())
    })
}

/// Keys of a cell, each in back quotes: none where the cell is a sentence.
fn keys(cell: &str) -> Vec<&str> {
    let all: Vec<&str> = cell.split(", ").collect();
    let own = all
        .iter()
        .map(|key| key.strip_prefix('`').and_then(|key| key.strip_suffix('`')));
    own.collect::<Option<Vec<_>>>().unwrap_or_default()
}

fn of_scenes() -> Vec<Explained> {
    let all = rows(FILES, "### Scene descriptions\n");
    let found = all.filter_map(|cells| match cells[..] {
        [key, "honoured", meaning] => Some((keys(key).first().copied()?, meaning)),
        _ => None,
    });
    let explained = |(field, meaning): (&str, &str)| Explained {
        field: field.to_owned(),
        file: "scene description, and [render] of a machine",
        meaning: sentence(meaning),
        values: vec![],
        kind: None,
        range: None,
        default: None,
        presets: vec![],
        page: "docs/reference/scenes.md",
    };
    found.map(explained).collect()
}

/// Cells of a page end without a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string());
    let text = first.unwrap_or_default() + letters.as_str();
    match text.ends_with('.') {
        true => text,
        false => text + ".",
    }
}

fn of_machines() -> Vec<Explained> {
    let mut found = vec![];
    for (file, from) in [("machine", "## A machine\n"), ("plan", "## A plan\n")] {
        for cells in rows(MACHINES, from) {
            let [own, meaning, default] = cells[..] else {
                continue;
            };
            for key in keys(own) {
                if key.starts_with('[') {
                    continue;
                }
                found.push(Explained {
                    field: key.to_owned(),
                    file,
                    meaning: sentence(meaning),
                    values: vec![],
                    kind: None,
                    range: None,
                    default: Some(default.to_owned()),
                    presets: vec![],
                    page: "docs/reference/machines.md",
                });
            }
        }
    }
    found
}

/// All fields.
pub(crate) fn all() -> Vec<Explained> {
    [of_configuration(), of_system(), of_scenes(), of_machines()].concat()
}

/// Words of the program's source text, which say nothing to the user of a file, in a text.
#[cfg(test)]
pub(crate) fn word_of_source(text: &str) -> Option<&str> {
    const WORDS: [&str; 20] = [
        "None", "Some", "Option", "Vec", "Self", "self", "enum", "struct", "bool", "u8", "u16",
        "u32", "u64", "usize", "i32", "i64", "f32", "f64", "MHz", "mhz",
    ];
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let own = text.split(|c| !is_part(c)).find(|own| WORDS.contains(own));
    let marks = ["::", "[`", "`]", "]("];
    own.or_else(|| marks.into_iter().find(|own| text.contains(own)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn paths(table: &toml::Table, prefix: &str, into: &mut Vec<String>) {
        for (key, value) in table {
            match value {
                toml::Value::Table(own) => paths(own, &format!("{prefix}{key}."), into),
                _ => into.push(format!("{prefix}{key}")),
            }
        }
    }

    /// Every key that a file of each kind can have is explained.
    #[test]
    fn every_field_has_a_meaning() {
        let all = all();
        for own in &all {
            assert!(own.meaning.len() > 4, "{own:?}");
        }
        let known: Vec<&str> = all.iter().map(|own| &*own.field).collect();
        let mut wanted = vec![];
        for (name, _) in PRESETS {
            let text = Config::preset(name).unwrap().to_toml().unwrap();
            paths(&text.parse().unwrap(), "", &mut wanted);
        }
        let system = toml::Table::try_from(System::default()).unwrap();
        paths(&system, "system.", &mut wanted);
        for path in &wanted {
            assert!(known.contains(&&**path), "{path}");
        }
        // Keys that no default writes, of each file.
        for path in [
            "clock_ghz",
            "vu.exp.offset",
            "vu.operands.multiply",
            "su.opacity",
            "system.remote.idle_watts",
            "render.step",
            "camera.fov",
            "path.window",
            "render.without",
            "workload.frames",
        ] {
            assert!(known.contains(&path), "{path}");
        }
    }

    /// Meanings come from comments of the source text, and ranges from errors: both are for users of files.
    #[test]
    fn no_field_is_told_in_words_of_the_source() {
        for own in all() {
            let values = own
                .values
                .iter()
                .flat_map(|(value, meaning)| [value, meaning]);
            let more = [&own.kind, &own.range, &own.default].into_iter().flatten();
            let texts = values.chain(more).chain([&own.meaning]);
            for text in texts {
                assert_eq!(word_of_source(text), None, "{}: {text}", own.field);
            }
        }
        for wrong in ["`None`: all", "see [`Gu::lag`]", "a u32", "500 MHz"] {
            assert!(word_of_source(wrong).is_some(), "{wrong}");
        }
        for right in ["nonessential [0, 1)", "no source: `u` is the operand"] {
            assert_eq!(word_of_source(right), None);
        }
    }

    /// A field without documentation, or one that is missing, would be found.
    #[test]
    fn refusals_give_ranges_and_enumerations_their_values() {
        let all = all();
        let of = |field: &str| all.iter().find(|own| own.field == field).unwrap();
        let banks = of("gu.banks");
        assert!(banks.range.as_ref().unwrap().contains("64"), "{banks:?}");
        assert_eq!(banks.default.as_deref(), Some("32"));
        assert!(
            banks.presets.contains(&("small", "8".to_owned())),
            "{banks:?}"
        );
        let path = of("rit.path");
        assert!(path.values.len() > 1, "{path:?}");
        assert!(of("system.array_rows").range.is_some());
        let form = of("vu.exp.form");
        assert!(
            form.range.as_ref().unwrap().contains("piecewise"),
            "{form:?}"
        );
    }
}
