//! Cases in files: `NAME.toml` has files and commands, `NAME.expected` what the commands print, how
//! they end, and which files are there afterwards.
//!
//! `POTAMOI_REFRESH=1 cargo test --test end_to_end commands_print` writes what is expected.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::common::{potamoi, stderr, stdout};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    /// No program is found, and no variable of the environment is set.
    #[serde(default)]
    has_no_tools: bool,
    step: Vec<Step>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Step {
    /// Text by name, written before the commands run.
    #[serde(default)]
    files: BTreeMap<String, String>,
    run: Vec<String>,
}

/// What a command prints and how it ends. One that fails says one error.
fn transcript(folder: &Path, command: &str, has_no_tools: bool) -> String {
    let arguments = shell_words::split(command).unwrap();
    let mut program = potamoi();
    if has_no_tools {
        program.env_clear().env("PATH", folder).env("HOME", folder);
    }
    let done = program
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap();
    let (out, err) = (stdout(&done), stderr(&done));
    let code = done.status.code().unwrap();
    assert!(!err.contains("panicked"), "potamoi {command}: {err}");
    let errors = err.matches("error: ").count();
    assert_eq!(errors, usize::from(code != 0), "potamoi {command}: {err}");
    let said = (out + &err).replace(&folder.display().to_string(), "[folder]");
    let end = if said.is_empty() || said.ends_with('\n') {
        ""
    } else {
        "\n"
    };
    format!("$ potamoi {command}\n{said}{end}exit status {code}\n\n")
}

/// Names of the files in a folder and below it.
fn names(folder: &Path) -> Vec<String> {
    let mut found = vec![];
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            if path.is_dir() {
                folders.push(path);
                found.push(name + "/");
            } else {
                found.push(name);
            }
        }
    }
    found.sort();
    found
}

fn run(case: &Case) -> String {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut text = String::new();
    for step in &case.step {
        for (name, content) in &step.files {
            fs::write(at.join(name), content).unwrap();
        }
        for command in &step.run {
            text += &transcript(at, command, case.has_no_tools);
        }
    }
    let _ = writeln!(text, "files: {}", names(at).join(", "));
    text
}

/// Paths of this folder with an extension, by name without it.
fn with_extension(extension: &str) -> BTreeMap<String, PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    let paths = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let own = paths.filter(|path| path.extension().is_some_and(|e| e == extension));
    own.map(|path| (path.file_stem().unwrap().display().to_string(), path))
        .collect()
}

#[test]
fn commands_print_what_is_expected() {
    let is_refresh = std::env::var_os("POTAMOI_REFRESH").is_some();
    let cases = with_extension("toml");
    let mut wrong = String::new();
    for (name, path) in &cases {
        let text = fs::read_to_string(path).unwrap();
        let case: Case = toml::from_str(&text).unwrap_or_else(|e| panic!("{name}.toml: {e}"));
        let found = run(&case);
        let kept = path.with_extension("expected");
        if is_refresh {
            fs::write(&kept, &found).unwrap();
            continue;
        }
        let expected = fs::read_to_string(&kept).unwrap_or_default();
        let mut entries = expected.split("\n\n").zip(found.split("\n\n"));
        if let Some((old, new)) = entries.find(|(old, new)| old != new) {
            let _ = writeln!(wrong, "{name}\n---- expected\n{old}\n---- found\n{new}\n");
        } else if expected != found {
            let _ = writeln!(wrong, "{name}: expected\n{expected}\n---- found\n{found}");
        }
    }
    const AGAIN: &str = "POTAMOI_REFRESH=1 cargo test --test end_to_end commands_print";
    assert!(wrong.is_empty(), "{wrong}{AGAIN} writes what is found");
    let expected: BTreeSet<_> = with_extension("expected").into_keys().collect();
    assert_eq!(
        expected,
        cases.into_keys().collect(),
        "a case has both files"
    );
}
