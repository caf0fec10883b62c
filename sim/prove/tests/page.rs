//! The table of docs/explanation/proofs.md is that of the kept outcomes.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use potamoi_formats::config::PRESETS;

const BEGIN: &str = "<!-- proofs -->\n";
const END: &str = "<!-- end of proofs -->";

/// Units that have a row of their own. All others are modules that are proven alone.
const UNITS: [&str; 4] = [
    "gathering_unit",
    "vector_unit",
    "splat_powers",
    "potamoi_npu_ext",
];

/// Counts of a unit of a preset: proven, bounded and failed properties, invariants, cycles, and
/// seconds by module.
#[derive(Default)]
struct Row {
    proven: u32,
    bounded: u32,
    failed: u32,
    invariants: u32,
    cycles: String,
    seconds: BTreeMap<String, f64>,
}

fn table(outcomes: &str) -> String {
    let mut rows: BTreeMap<(usize, usize), Row> = BTreeMap::new();
    for line in outcomes.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let place = PRESETS.iter().position(|(name, _)| *name == fields[0]);
        let unit = UNITS.iter().position(|unit| *unit == fields[1]);
        let unit = unit.unwrap_or(UNITS.len());
        let row = rows.entry((place.unwrap(), unit)).or_default();
        match (fields[3], fields[5]) {
            ("cover", _) => continue,
            ("invariant", "proven") => row.invariants += 1,
            (_, "proven") => row.proven += 1,
            (_, "failed") => row.failed += 1,
            _ => {
                row.bounded += 1;
                fields[6].clone_into(&mut row.cycles);
            }
        }
        let seconds = fields[7].parse().unwrap();
        row.seconds.insert(fields[1].to_owned(), seconds);
    }
    let mut text = String::from(
        "\n| preset | unit | proven | invariants | bounded | cycles of the bound | failed | seconds |\n\
         |---|---|---:|---:|---:|---:|---:|---:|\n",
    );
    for ((place, unit), row) in rows {
        let (preset, _) = PRESETS[place];
        let unit = match UNITS.get(unit) {
            Some(unit) => format!("`{unit}`"),
            None => "modules of data".to_owned(),
        };
        let seconds: f64 = row.seconds.values().sum();
        let _ = writeln!(
            text,
            "| {preset} | {unit} | {} | {} | {} | {} | {} | {seconds:.0} |",
            row.proven, row.invariants, row.bounded, row.cycles, row.failed
        );
    }
    text + "\n"
}

#[test]
fn the_page_has_the_kept_outcomes() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let outcomes = std::fs::read_to_string(here.join("outcomes.csv")).unwrap();
    let page = here.join("../../docs/explanation/proofs.md");
    let text = std::fs::read_to_string(&page).unwrap();
    let (head, rest) = text.split_once(BEGIN).unwrap();
    let (old, tail) = rest.split_once(END).unwrap();
    let new = table(&outcomes);
    if std::env::var_os("POTAMOI_REFRESH").is_some() {
        std::fs::write(&page, format!("{head}{BEGIN}{new}{END}{tail}")).unwrap();
    } else {
        assert_eq!(old, new, "refresh with POTAMOI_REFRESH=1");
    }
}
