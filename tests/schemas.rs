//! Reports of real runs against the published schemas. Whatever report another test reads is checked too
//! (`common::json`).

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::json;

use crate::common::{expect, faults_of, json};

const PLAN: &str = "scenes = [\"garden\"]\nwidth = 16\n[workload]\nframes = 2\nfidelity = \"demand\"\n\
                    [vary]\n\"vu.lanes\" = [6, 12]\n";

/// Commands that take a fraction of a second.
const QUICK: &[&str] = &[
    "cache",
    "doctor",
    "estimate",
    "inspect garden",
    "layouts --scene lantern --width 16",
    "sweep plan.toml --work-dir w",
    "sweep plan.toml --work-dir w --front fps,mm2",
];
/// All others: minutes, and tools.
const SLOW: &[&str] = &[
    "bench --only splats --runs 1",
    "characterise --scene lantern --width 16",
    "characterise --scenes lantern,garden --width 16",
    "compare --rivals paper",
    "compare paper lean-splats --scene garden --width 32 --frames 2",
    "cost --scene garden --width 16 --frames 2 --knobs iterations",
    "cost --study exp",
    "cost --study methods",
    "effects --scene garden --width 16 --frames 1",
    "emit --out-dir rtl",
    "emit --unit exp --out-dir exp",
    "explain gu.banks",
    "explore paper --scene garden --width 16 --frames 2 --vary vu.lanes=6,12 --fidelity demand",
    "hard-cases --scene garden --width 16",
    "hard-cases",
    "model --ladder --scene lantern --width 16",
    "model --octree --scene garden --width 32",
    "model --rivals --scene cairn:ngp --width 16 --frames 2",
    "model --scene garden --width 32 --frames 4",
    "model --sensitivity --scene garden --width 32 --frames 4",
    "mutate --unit gu --config small --mutants 1 --judges bench --scene lantern --width 8",
    "prove --config small --cycles 4",
    "render --scene lantern --width 16 --frames 2 --out b.png",
    "render --scene lantern --width 16 --out a.png",
    "report lantern --width 32 --frames 2 --knobs iterations --out page.html",
    "synth --config small --unit gu --activity none",
    "synth --config small --unit vu --fpga ecp5",
    "trace --scene lantern --width 16 --out t.npz",
    "verify --engine interpreter --scene lantern --width 8",
    "warp --scene cairn:voxels --width 16 --frames 4 --fps 30,60",
    "warp --scene cairn:voxels --width 16 --frames 4",
    "warp --scenes cairn:voxels,vase:voxels --width 16 --frames 4",
];

/// Runs commands, and gives the names of their schemas.
fn checked(commands: &[&str]) -> BTreeSet<String> {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("plan.toml"), PLAN).unwrap();
    let mut names = BTreeSet::new();
    for (i, command) in commands.iter().enumerate() {
        let file = format!("report{i}.json");
        let arguments = shell_words::split(command).unwrap();
        let arguments: Vec<&str> = arguments.iter().map(|own| &**own).collect();
        expect(at, 0, &[&arguments[..], &["--json", &file]].concat());
        let report = json(&at.join(&file));
        names.insert(report["command"].as_str().unwrap().replace(" --", "-"));
    }
    names
}

/// Names of the published schemas, as the program lists them.
fn published() -> BTreeSet<String> {
    let said = expect(Path::new("."), 0, &["schema"]);
    let lines = said.lines().skip(1);
    lines
        .map(|line| line.split_whitespace().next().unwrap().to_owned())
        .collect()
}

#[test]
fn quick_reports_keep_to_their_schemas() {
    let names = checked(QUICK);
    assert!(names.is_subset(&published()), "{names:?}");
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn reports_of_all_commands_keep_to_their_schemas() {
    let mut names = checked(QUICK);
    names.extend(checked(SLOW));
    assert_eq!(names, published());
}

#[test]
fn a_key_that_a_schema_lacks_is_found() {
    let mut report = json!({
        "format_version": 1, "command": "trace", "scene": "a", "configuration": "b", "mvoxels": 1,
        "samples": 1, "operations": 1, "elements": 1, "bytes": 1, "not_checked": [],
    });
    assert_eq!(faults_of(&report), Vec::<String>::new());
    report["seconds"] = 1.0.into();
    let faults = faults_of(&report);
    assert!(
        faults.len() == 1 && faults[0].contains("seconds"),
        "{faults:?}"
    );
    report.as_object_mut().unwrap().remove("seconds");
    report["bytes"] = "1".into();
    report["format_version"] = 2.into();
    assert_eq!(faults_of(&report).len(), 2);
    report["command"] = "cost".into();
    assert!(!faults_of(&report).is_empty());
}

#[test]
fn schemas_are_printed_and_misspelt_names_are_answered() {
    let at = Path::new(".");
    let printed = expect(at, 0, &["schema", "model-ladder"]);
    let kept =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/schemas/model-ladder.json");
    assert_eq!(printed, std::fs::read_to_string(kept).unwrap());
    let said = expect(at, 2, &["schema", "modle"]);
    assert!(said.contains("did you mean `model`?"), "{said}");
}

#[test]
fn tables_of_a_report_are_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("plan.toml"), PLAN).unwrap();
    let arguments = ["sweep", "plan.toml", "--work-dir", "w", "--json", "r.json"];
    expect(at, 0, &[&arguments[..], &["--csv-dir", "tables"]].concat());
    let report = json(&at.join("r.json"));
    let mut rows = csv::Reader::from_path(at.join("tables/rows.csv")).unwrap();
    let names = rows.headers().unwrap().clone();
    let mut count = 0;
    for (row, own) in rows.records().zip(report["rows"].as_array().unwrap()) {
        for (name, cell) in names.iter().zip(&row.unwrap()) {
            let value = match &own[name] {
                serde_json::Value::Null => String::new(),
                serde_json::Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            assert_eq!(cell, value, "{name}");
        }
        count += 1;
    }
    assert_eq!((count, report["rows"].as_array().unwrap().len()), (2, 2));
    let one = std::fs::read_to_string(at.join("tables/report.csv")).unwrap();
    assert!(one.starts_with("format_version,command,"), "{one}");
    // No input is overwritten by a table.
    std::fs::rename(at.join("plan.toml"), at.join("tables/rows.csv")).unwrap();
    let arguments = [
        "sweep",
        "tables/rows.csv",
        "--work-dir",
        "w",
        "--csv-dir",
        "tables",
    ];
    let said = expect(at, 2, &arguments);
    assert!(said.contains("--csv-dir would overwrite"), "{said}");
}
