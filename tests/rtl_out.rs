//! The checked-in Verilog is what the generator makes, and tools accept it
//! without a waiver.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Presets by name: what lies in `configs`.
fn presets() -> Vec<String> {
    let files = std::fs::read_dir(root().join("configs")).unwrap();
    let mut names: Vec<String> = files
        .map(|f| f.unwrap().path().file_stem().unwrap().display().to_string())
        .collect();
    names.sort();
    assert!(names.len() >= 2);
    names
}

fn emit(preset: &str, out: &Path) {
    let done = Command::new(env!("CARGO_BIN_EXE_potamoi"))
        .args(["--config", preset, "emit", "--out-dir"])
        .arg(out)
        .output()
        .unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
}

fn read(folder: &Path) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    for unit in std::fs::read_dir(folder).unwrap() {
        let unit = unit.unwrap().path();
        // The manifest lies beside the units' folders.
        if !unit.is_dir() {
            continue;
        }
        for file in std::fs::read_dir(&unit).unwrap() {
            let path = file.unwrap().path();
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            files.insert(name, std::fs::read_to_string(&path).unwrap());
        }
    }
    files
}

#[test]
fn the_checked_in_verilog_is_current() {
    for preset in presets() {
        let made = tempfile::tempdir().unwrap();
        emit(&preset, made.path());
        let kept = root().join("rtl_out").join(&preset);
        let (made, kept) = (read(made.path()), read(&kept));
        for (name, text) in &made {
            assert!(
                kept.get(name) == Some(text),
                "rtl_out/{preset}/{name} is not what the generator makes; refresh with `make refresh` and review the change"
            );
        }
        assert_eq!(
            made.len(),
            kept.len(),
            "rtl_out/{preset} holds files that are no longer made; run `make refresh`"
        );
    }
    let folders = std::fs::read_dir(root().join("rtl_out")).unwrap().count();
    assert_eq!(
        folders,
        presets().len(),
        "rtl_out holds a folder of no preset"
    );
}

#[test]
fn what_was_emitted_is_listed() {
    let made = tempfile::tempdir().unwrap();
    let report = made.path().join("r.json");
    let done = Command::new(env!("CARGO_BIN_EXE_potamoi"))
        .args(["emit", "--out-dir"])
        .arg(made.path().join("rtl"))
        .arg("--json")
        .arg(&report)
        .output()
        .unwrap();
    assert!(done.status.success());
    let text = std::fs::read_to_string(&report).unwrap();
    let r: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(r["format_version"], 1);
    let files = read(&made.path().join("rtl"));
    let listed = r["files"].as_object().unwrap();
    assert_eq!(listed.len(), files.len());
    for (name, text) in &files {
        assert_eq!(listed[name], text.lines().count(), "{name}");
    }
}

fn accepts(tool: &str, args: &[&str], files: &[PathBuf]) {
    let done = Command::new(tool).args(args).args(files).output();
    let done = done.unwrap_or_else(|e| panic!("{tool}: {e}; tools/setup installs it"));
    let text = format!(
        "{}{}",
        String::from_utf8_lossy(&done.stdout),
        String::from_utf8_lossy(&done.stderr)
    );
    assert!(
        done.status.success() && text.trim().is_empty(),
        "{tool} {args:?} says:\n{text}"
    );
}

#[test]
fn verilator_icarus_and_yosys_accept_it_without_a_waiver() {
    let units = presets().into_iter().flat_map(|p| {
        ["gathering_unit", "vector_unit"]
            .map(|unit| (root().join("rtl_out").join(&p).join(unit), unit))
    });
    for (folder, unit) in units {
        let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)
            .unwrap()
            .map(|f| f.unwrap().path())
            .collect();
        files.sort();
        for file in &files {
            let text = std::fs::read_to_string(file).unwrap();
            assert!(
                !text.contains("lint_off"),
                "{} has a waiver",
                file.display()
            );
        }
        accepts(
            "verilator",
            &[
                "--lint-only",
                "-Wall",
                "--language",
                "1364-2005",
                "--top-module",
                unit,
            ],
            &files,
        );
        accepts(
            "iverilog",
            &["-g2005", "-Wall", "-tnull", "-s", unit],
            &files,
        );
        let list: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
        let script = format!(
            "read_verilog {}; hierarchy -check -top {unit}; proc; check -assert",
            list.join(" ")
        );
        accepts("yosys", &["-q", "-e", ".*", "-p", &script], &[]);
    }
}
