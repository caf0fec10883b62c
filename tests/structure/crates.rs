//! Crates along the data flow.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The crates of the workspace in the order of the data flow: each builds on those before it
/// alone, its tests included.
const FLOW: [&str; 32] = [
    "formats",
    // The oracle.
    "base",
    "containers",
    "reference",
    "march",
    "fields",
    "gaussians",
    "splats",
    "warp",
    "analytic",
    "scene",
    "analysis",
    // The generator.
    "verilated",
    "netlist",
    "units",
    "soc",
    "rust-hdl",
    // Both.
    "result-cache",
    "cycles",
    "gates",
    "rtl",
    "prove",
    "mutate",
    "synth",
    "gpu",
    "rivals",
    "system",
    "explore",
    "machines",
    "speed",
    "plots",
    "page",
];
const ORACLE: std::ops::Range<usize> = 1..12;
const GENERATOR: [&str; 5] = ["verilated", "netlist", "units", "soc", "rust-hdl"];

/// Of each crate, those of the workspace that it names: to be built, and to be tested.
fn named() -> BTreeMap<String, [BTreeSet<String>; 2]> {
    let done = Command::new(env!("CARGO"))
        .current_dir(super::root())
        .args([
            "metadata",
            "--locked",
            "--offline",
            "--no-deps",
            "--format-version",
            "1",
        ])
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{error}");
    let data: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    let short = |name: &str| name.strip_prefix("potamoi-").map(str::to_owned);
    let mut all = BTreeMap::new();
    for package in data["packages"].as_array().unwrap() {
        let Some(name) = package["name"].as_str().and_then(short) else {
            continue;
        };
        let mut found = [BTreeSet::new(), BTreeSet::new()];
        for one in package["dependencies"].as_array().unwrap() {
            if let Some(other) = one["name"].as_str().and_then(short) {
                found[usize::from(one["kind"] == "dev")].insert(other);
            }
        }
        all.insert(name, found);
    }
    all
}

#[test]
fn crates_build_on_those_before_them() {
    let named = named();
    let known: BTreeSet<_> = named.keys().map(String::as_str).collect();
    assert_eq!(known, BTreeSet::from(FLOW), "FLOW has every crate once");
    for (place, name) in FLOW.iter().enumerate() {
        for other in named[*name].iter().flatten() {
            assert!(
                FLOW[..place].contains(&other.as_str()),
                "{name} builds on {other}"
            );
        }
    }
}

/// Lines of Rust that a crate may have in its `src`, files of unit tests left out, as
/// `tools/recompiled-lines` counts them.
const MOST_LINES: usize = 20_000;

#[test]
fn no_crate_has_grown_too_large() {
    let root = super::root();
    let mut manifests = Vec::new();
    super::files(root, "Cargo.toml", &mut manifests);
    let is_test = |path: &Path| {
        let stem = path.file_stem().unwrap().to_string_lossy();
        let mut folders = path.parent().unwrap().components();
        stem.ends_with("tests") || folders.any(|own| own.as_os_str() == "tests")
    };
    let lines = |folder: &Path| -> usize {
        let mut found = Vec::new();
        super::files(folder, ".rs", &mut found);
        found.retain(|path| !is_test(path.strip_prefix(folder).unwrap()));
        let count = |path: &PathBuf| fs::read_to_string(path).unwrap().lines().count();
        found.iter().map(count).sum()
    };
    let sources = manifests.iter().map(|own| own.with_file_name("src"));
    let sizes: Vec<_> = sources
        .filter(|own| own.is_dir())
        .map(|own| (lines(&own), own))
        .collect();
    assert!(sizes.len() >= FLOW.len(), "{sizes:?}");
    for (lines, folder) in sizes {
        assert!(
            lines <= MOST_LINES,
            "{} has {lines} lines, more than {MOST_LINES}: part it, so that an edit compiles less",
            folder.display()
        );
    }
}

/// A mistake that both shared would not show when they are compared.
#[test]
fn generator_and_oracle_never_meet() {
    let named = named();
    for oracle in &FLOW[ORACLE] {
        for other in named[*oracle].iter().flatten() {
            assert!(
                !GENERATOR.contains(&other.as_str()),
                "{oracle} names {other}"
            );
        }
    }
    for generator in GENERATOR {
        for other in named[generator].iter().flatten() {
            assert!(
                !FLOW[ORACLE].contains(&other.as_str()),
                "{generator} names {other}"
            );
        }
    }
    // Cycles are counted without what runs Verilog.
    for other in named["cycles"].iter().flatten() {
        assert!(!GENERATOR.contains(&other.as_str()), "cycles names {other}");
    }
}

/// The crates and what they build on, as Mermaid draws it; what follows from another arrow is
/// left out.
fn picture(named: &BTreeMap<String, [BTreeSet<String>; 2]>) -> String {
    let mut below: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let mut text = String::from("```mermaid\nflowchart BT\n");
    for name in FLOW.into_iter().chain(["potamoi"]) {
        let own: BTreeSet<&str> = match named.get(name) {
            Some([built, _]) => built.iter().map(String::as_str).collect(),
            None => command_line(),
        };
        let mut all = own.clone();
        let indirect: BTreeSet<&str> = own.iter().flat_map(|o| below[o].clone()).collect();
        all.extend(&indirect);
        for other in own.difference(&indirect) {
            text += &format!("    {name} --> {other}\n");
        }
        below.insert(name, all);
    }
    text + "```\n"
}

/// What the command line builds on.
fn command_line() -> BTreeSet<&'static str> {
    let manifest = std::fs::read_to_string(super::root().join("Cargo.toml"));
    let manifest: toml::Table = manifest.unwrap().parse().unwrap();
    let own = manifest["dependencies"].as_table().unwrap();
    FLOW.into_iter()
        .filter(|name| own.contains_key(&format!("potamoi-{name}")))
        .collect()
}

/// `POTAMOI_REFRESH=1 cargo test --test structure picture` draws it again.
#[test]
fn the_picture_of_the_crates_is_drawn_from_cargo() {
    let page = super::root().join("docs/ARCHITECTURE.md");
    let text = std::fs::read_to_string(&page).unwrap();
    let (begin, end) = (
        "<!-- crates: drawn by tests/structure -->\n",
        "<!-- end -->",
    );
    let (head, rest) = text.split_once(begin).expect("the begin of the picture");
    let (found, tail) = rest.split_once(end).expect("the end of the picture");
    let expected = picture(&named());
    if std::env::var_os("POTAMOI_REFRESH").is_some() {
        std::fs::write(&page, format!("{head}{begin}{expected}{end}{tail}")).unwrap();
        return;
    }
    assert_eq!(
        found, expected,
        "POTAMOI_REFRESH=1 cargo test --test structure picture"
    );
}
