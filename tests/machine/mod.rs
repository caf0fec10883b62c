//! What the machine around a run does: outputs that are links and devices, full disks, tools that
//! do not work, memory limits, kept files, and runs that are killed.

mod cache;
mod kills;
mod notes;
mod outputs;
mod tools;

use std::path::Path;
use std::process::{Command, Output};

use crate::common;

/// Runs a script of the shell in a folder, with the program in `$P` and kept files of its own.
fn shell(folder: &Path, script: &str) -> Output {
    Command::new("/bin/sh")
        .args(["-c", script])
        .current_dir(folder)
        .env("P", env!("CARGO_BIN_EXE_potamoi"))
        .env("NO_COLOR", "1")
        .env("POTAMOI_CACHE", folder.join("cache"))
        .output()
        .unwrap()
}

/// Runs a script and expects an exit status; gives what was printed.
fn expect(folder: &Path, code: i32, script: &str) -> String {
    let output = shell(folder, script);
    let text = common::stdout(&output) + &common::stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{script}\n{text}");
    assert!(!text.contains("panicked"), "{text}");
    text
}

/// Names of all that is in a folder, itself and its folders left out.
fn files(folder: &Path) -> Vec<String> {
    let mut found = vec![];
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap();
                found.push(name.display().to_string());
            }
        }
    }
    found.sort();
    found
}
