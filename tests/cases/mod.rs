//! Cases in files: `NAME.toml` has files and commands, `NAME.expected` what the commands print, how
//! they end, and which files are there afterwards. The folder `mistakes` has a file for each kind of mistake
//! that a newcomer makes.
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

/// Words of the program's own source, of its libraries and of the operating system, which tell a user
/// nothing.
const FOREIGN: [&str; 22] = [
    "os error",
    "No such file or directory",
    "panicked",
    "unwrap",
    "None",
    "Some(",
    "Err(",
    "Ok(",
    "Option<",
    "u8",
    "u32",
    "u64",
    "usize",
    "i64",
    "f64",
    "invalid digit",
    "invalid float",
    "invalid type",
    "missing field",
    "unknown field",
    "..=",
    "expected 1 to 0",
];

/// A word of [`FOREIGN`] in an error, if there is one.
fn foreign(said: &str) -> Option<&'static str> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    FOREIGN.into_iter().find(|word| {
        said.match_indices(word).any(|(at, _)| {
            let before = said[..at].chars().next_back();
            let after = said[at + word.len()..].chars().next();
            !before.is_some_and(is_part) && !after.is_some_and(is_part)
        })
    })
}

/// What a command prints and how it ends. One that fails says one error, in words of a user.
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
    // How long a command takes is the machine's.
    let is_result = |line: &&str| !line.starts_with("progress: ");
    let err: String = stderr(&done)
        .split_inclusive('\n')
        .filter(is_result)
        .collect();
    let out = stdout(&done);
    let code = done.status.code().unwrap();
    assert!(!err.contains("panicked"), "potamoi {command}: {err}");
    let errors = err.matches("error: ").count();
    assert_eq!(errors, usize::from(code != 0), "potamoi {command}: {err}");
    assert_eq!(foreign(&err), None, "potamoi {command}: {err}");
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
            let path = at.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, content).unwrap();
        }
        for command in &step.run {
            text += &transcript(at, command, case.has_no_tools);
        }
    }
    let _ = writeln!(text, "files: {}", names(at).join(", "));
    text
}

/// Paths of this folder and its groups with an extension, by name without it.
fn with_extension(extension: &str) -> BTreeMap<String, PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    let all = names(&folder).into_iter();
    let own = all.filter_map(|name| {
        let stem = name.strip_suffix(extension)?.strip_suffix('.')?;
        Some((stem.to_owned(), folder.join(&name)))
    });
    own.collect()
}

fn read(name: &str, path: &Path) -> Case {
    let text = fs::read_to_string(path).unwrap();
    toml::from_str(&text).unwrap_or_else(|e| panic!("{name}.toml: {e}"))
}

#[test]
fn commands_print_what_is_expected() {
    let is_refresh = std::env::var_os("POTAMOI_REFRESH").is_some();
    let cases = with_extension("toml");
    let mut wrong = String::new();
    for (name, path) in &cases {
        let found = run(&read(name, path));
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

/// Each kind of mistake has three commands or more that are refused.
#[test]
fn every_kind_of_mistake_has_its_cases() {
    const KINDS: [&str; 11] = [
        "caches",
        "conflicting-flags",
        "missing-cameras",
        "missing-tools",
        "misspelt-names",
        "out-of-range",
        "swapped",
        "unwritable-outputs",
        "wrong-kinds-of-file",
        "wrong-types",
        "wrong-units",
    ];
    let all = with_extension("expected");
    let group = all
        .iter()
        .filter_map(|(name, path)| Some((name.strip_prefix("mistakes/")?, path)));
    let found: BTreeMap<&str, String> = group
        .map(|(name, path)| (name, fs::read_to_string(path).unwrap()))
        .collect();
    let names: Vec<&str> = found.keys().copied().collect();
    assert_eq!(names, KINDS);
    for (name, text) in found {
        let refused = text.split("\n\n").filter(|own| own.contains("\nerror: "));
        assert!(refused.count() >= 3, "{name}: {text}");
    }
    assert!(foreign("cannot read a: x (os error 2)").is_some() && foreign("a u32").is_some());
    assert_eq!(foreign("None-the-less u320 unwrapped"), Some("None"));
    assert_eq!(foreign("nobody unwraps 32 of them"), None);
}
