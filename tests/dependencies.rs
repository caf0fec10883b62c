//! Dependencies point one way, and unsafe code stays in one place.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Crates of this workspace that one of them builds on, directly or not, by
/// dependencies of these kinds.
fn below(package: &str, kinds: &str) -> BTreeSet<String> {
    let done = Command::new(env!("CARGO"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args([
            "tree",
            "--locked",
            "--offline",
            "--edges",
            kinds,
            "--prefix",
            "none",
        ])
        .args(["--package", package])
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{error}");
    let text = String::from_utf8(done.stdout).unwrap();
    let names = text.lines().filter_map(|l| l.split(' ').next());
    names
        .filter(|n| n.starts_with("potamoi") && *n != package)
        .map(str::to_owned)
        .collect()
}

fn set(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|n| (*n).to_owned()).collect()
}

#[test]
fn generator_and_oracle_never_meet() {
    let built = |package| below(package, "normal,build");
    assert_eq!(built("potamoi-formats"), set(&[]));
    assert_eq!(built("potamoi-hdl"), set(&["potamoi-formats"]));
    assert_eq!(built("potamoi-golden"), set(&["potamoi-formats"]));
    assert_eq!(built("potamoi-verilated"), set(&[]));
    assert_eq!(
        built("potamoi-rust-hdl"),
        set(&["potamoi-formats", "potamoi-hdl"])
    );
    // Nor do they meet in their own tests.
    let tested = |package| below(package, "normal,build,dev");
    assert_eq!(
        tested("potamoi-hdl"),
        set(&["potamoi-formats", "potamoi-verilated"])
    );
    assert_eq!(tested("potamoi-golden"), set(&["potamoi-formats"]));
}

/// Cycles are counted without the generator and without what runs Verilog; netlists in cells
/// are simulated without the oracle.
#[test]
fn the_crates_of_sim_stand_in_a_row() {
    let built = |package| below(package, "normal,build");
    let oracle = &built("potamoi-golden") | &set(&["potamoi-golden"]);
    assert_eq!(built("potamoi-cycles"), oracle);
    let gates = set(&["potamoi-formats", "potamoi-hdl"]);
    assert_eq!(built("potamoi-gates"), gates);
    let kept = &oracle | &set(&["potamoi-verilated"]);
    assert_eq!(built("potamoi-kept"), kept);
    let units = set(&["potamoi-cycles", "potamoi-gates", "potamoi-verilated"]);
    let rtl = &(&oracle | &gates) | &units;
    assert_eq!(built("potamoi-rtl"), rtl);
    let synth = &rtl | &set(&["potamoi-kept", "potamoi-rtl"]);
    assert_eq!(built("potamoi-synth"), synth);
    let system = &synth | &set(&["potamoi-synth"]);
    assert_eq!(built("potamoi-system"), system);
}

/// Every file below a folder whose name ends so, build output left out.
fn files(folder: &Path, end: &str, found: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && name != "out" && !name.starts_with('.') {
            files(&path, end, found);
        } else if name.ends_with(end) {
            found.push(path);
        }
    }
}

/// The compiler denies it wherever the workspace's lints hold and are not
/// lifted; no file outside the binding lifts them.
#[test]
fn unsafe_code_is_in_the_verilator_binding_alone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let table = |path: &Path| {
        let text = std::fs::read_to_string(path).unwrap();
        text.parse::<toml::Table>().unwrap()
    };
    let workspace = table(&root.join("Cargo.toml"));
    assert_eq!(
        workspace["workspace"]["lints"]["rust"]["unsafe_code"].as_str(),
        Some("deny")
    );
    let mut manifests = vec![];
    files(root, "Cargo.toml", &mut manifests);
    assert!(manifests.len() >= 7, "{manifests:?}");
    for path in manifests {
        let own = table(&path);
        let lints = own.get("lints");
        let has = |field: &str, of: Option<&toml::Value>| of.and_then(|t| t.get(field)).cloned();
        let inherits = has("workspace", lints) == Some(toml::Value::Boolean(true));
        // A package apart from the workspace says it itself.
        let denied = has("unsafe_code", has("rust", lints).as_ref());
        let denies = own.contains_key("workspace") && denied == Some("deny".into());
        assert!(inherits || denies, "{}", path.display());
    }

    let mut sources = vec![];
    files(root, ".rs", &mut sources);
    assert!(sources.len() > 100);
    let lint = concat!("unsafe", "_code,");
    let names = |end: &str| lint.replace(',', end);
    let lifting = sources.iter().filter(|path| {
        let text = std::fs::read_to_string(path).unwrap();
        [",", ")", "\n"]
            .iter()
            .any(|end| text.contains(&names(end)))
    });
    assert_eq!(
        lifting.collect::<Vec<_>>(),
        [&root.join("sim/verilated/src/lib.rs")]
    );
}
