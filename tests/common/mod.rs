//! Runs the command line.

mod schemas;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub(crate) fn potamoi() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_potamoi"));
    command.env("NO_COLOR", "1");
    command
}

/// Runs with arguments in a folder.
pub(crate) fn run(folder: &Path, arguments: &[&str]) -> Output {
    potamoi()
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

pub(crate) fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// A text with one space between its words: sentences of the output are broken at words.
pub(crate) fn words(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Runs, expects an exit code, and gives what was printed.
pub(crate) fn expect(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let (out, err) = (stdout(&output), stderr(&output));
    assert_eq!(
        output.status.code(),
        Some(code),
        "potamoi {}\n{out}{err}",
        arguments.join(" ")
    );
    assert!(!err.contains("panicked"), "{err}");
    if code != 0 {
        assert_eq!(err.matches("error: ").count(), 1, "one error each: {err}");
    }
    out + &err
}

/// A JSON file. A report must keep to its schema.
pub(crate) fn json(path: &Path) -> serde_json::Value {
    let value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    schemas::check(&value);
    value
}

pub(crate) use schemas::faults_of;

/// The folder of real scenes, if it is here.
pub(crate) fn shared() -> Option<PathBuf> {
    let path = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
        PathBuf::from,
    );
    let data = path.join("data");
    if data.is_dir() {
        return Some(data);
    }
    println!("skipped: no real scenes in {}", data.display());
    None
}
