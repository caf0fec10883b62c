//! Which arguments name inputs and which outputs, and that no file is both or twice.
//!
//! Looked at before any work, for all commands at once: an output that is a file of the inputs
//! would be lost, and one file for two outputs holds one of them.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use clap::ArgMatches;

use crate::failure::Failure;

/// Files that a description names are followed so far.
const DEPTH: u32 = 5;
/// Larger descriptions are not searched for files that they name.
const LARGEST: u64 = 64 << 20;
/// Files of an input folder that are looked at.
const MOST: usize = 100_000;

/// What an argument names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// A file or folder that is read, or a name that is none.
    Input,
    /// A file that is written.
    Output,
    /// A folder that files are written into.
    Folder,
}

/// The role of an argument; none of those that name no file.
fn role(argument: &str) -> Option<Role> {
    Some(match argument {
        "out_dir" | "readmemh" | "netlists" => Role::Folder,
        "config" | "scene" | "scenes" | "for_scene" | "camera" | "mesh" | "trace" | "system"
        | "synth" | "liberty" | "compare" | "activity" | "fit_to" => Role::Input,
        "out" | "json" | "vcd" | "csv" | "plot" | "plot_energy" | "plot_roofline" | "found"
        | "table" | "chrome_trace" | "report" | "grid" | "forms" => Role::Output,
        _ => return None,
    })
}

/// Whether an argument names a file or folder that is written.
#[cfg(test)]
pub(crate) fn is_output(argument: &str) -> bool {
    matches!(role(argument), Some(Role::Output | Role::Folder))
}

/// Refuses arguments by which a file would be lost.
///
/// # Errors
/// One file is named for two outputs, or an output is a file that is read.
pub(crate) fn check(matches: &ArgMatches) -> Result<(), Failure> {
    let Some((command, own)) = matches.subcommand() else {
        return Ok(());
    };
    let (mut inputs, mut outputs, mut folders) = (vec![], vec![], vec![]);
    for id in own.ids() {
        let Some(role) = role(id.as_str()) else {
            continue;
        };
        // What a search finds is written where there is a goal alone, though its file has a name
        // by default.
        if id == "found" && !own.contains_id("goal") {
            continue;
        }
        for value in own.get_raw(id.as_str()).into_iter().flatten() {
            let flag = format!("--{}", id.as_str().replace('_', "-"));
            let list = match role {
                Role::Input => &mut inputs,
                Role::Output => &mut outputs,
                Role::Folder => &mut folders,
            };
            list.push((flag, PathBuf::from(value)));
        }
    }
    twice(&outputs)?;
    for (flag, path) in &outputs {
        if let Some((other, folder)) = folders
            .iter()
            .find(|(_, folder)| is_written_in(path, folder))
        {
            return Err(Failure::Usage(format!(
                "{flag} {} is a file that {other} {} writes as well: name another output",
                path.display(),
                folder.display()
            )));
        }
    }
    for (flag, folder) in &folders {
        keep_inputs(&inputs, flag, folder, is_written)?;
    }
    if command == "render" && own.contains_id("frames") {
        for (flag, path) in outputs.iter().filter(|(flag, _)| flag == "--out") {
            let folder = folder_of(path);
            keep_inputs(&inputs, flag, folder, |name| is_numbered(path, name))?;
        }
    }
    let lost: Vec<_> = outputs
        .iter()
        .filter_map(|(flag, path)| Some((flag, path, regular(path)?)))
        .collect();
    if lost.is_empty() {
        return Ok(());
    }
    for (input, from) in &inputs {
        let mut read = BTreeSet::new();
        files_of(from, DEPTH, &mut read);
        for (flag, path, file) in &lost {
            if read.contains(file) {
                return Err(Failure::Usage(format!(
                    "{flag} {} is a file that {input} {} reads, which would be lost: name another \
                     output",
                    path.display(),
                    from.display()
                )));
            }
        }
    }
    Ok(())
}

/// Whether a file of this name is written into folders: frames, streams, Verilog, and lists.
fn is_written(name: &str) -> bool {
    let is_frame = |start: &str| name.starts_with(start) && name.ends_with(".png");
    is_frame("frame.")
        || is_frame("origin.")
        || [".hex", ".v", ".sv"]
            .iter()
            .any(|ending| name.ends_with(ending))
        || ["memories.json", "manifest.json"].contains(&name)
}

/// Whether a picture of a path that is written to `a.png` may have this name: `a.0007.png`.
fn is_numbered(out: &Path, name: &str) -> bool {
    let stem = out.file_stem().unwrap_or_default().to_string_lossy();
    let rest = name.strip_prefix(&*stem).and_then(|r| r.strip_prefix('.'));
    let number = rest.and_then(|rest| rest.strip_suffix(".png"));
    number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
}

/// The folder that a file is in.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Whether an output is a file that is written into a folder as well, or below it.
fn is_written_in(path: &Path, folder: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let within = absolute(folder_of(path));
    let is_inside = || {
        within
            .zip(absolute(folder))
            .is_some_and(|(w, f)| w.starts_with(f))
    };
    let is_named = is_written(&name) && is_inside();
    // By another name, as through a link.
    let is_linked = || {
        let file = regular(path);
        file.is_some() && written_in(folder, is_written).any(|(_, other)| Some(other) == file)
    };
    is_named || is_linked()
}

/// Regular files of a folder whose names are such.
fn written_in(
    folder: &Path,
    is_such: impl Fn(&str) -> bool,
) -> impl Iterator<Item = (PathBuf, (u64, u64))> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .filter(move |entry| is_such(&entry.file_name().to_string_lossy()))
        .filter_map(|entry| Some((entry.path(), regular(&entry.path())?)))
}

/// Refuses a folder for outputs that holds inputs of the names that are written there.
fn keep_inputs(
    inputs: &[(String, PathBuf)],
    flag: &str,
    folder: &Path,
    is_such: impl Fn(&str) -> bool,
) -> Result<(), Failure> {
    let written: Vec<_> = written_in(folder, is_such).collect();
    if written.is_empty() {
        return Ok(());
    }
    for (input, from) in inputs {
        let mut read = BTreeSet::new();
        files_of(from, DEPTH, &mut read);
        if let Some((path, _)) = written.iter().find(|(_, file)| read.contains(file)) {
            return Err(Failure::Usage(format!(
                "{flag}: {} is a file that {input} {} reads, which would be lost: name another \
                 output",
                path.display(),
                from.display()
            )));
        }
    }
    Ok(())
}

/// Refuses one file for two outputs.
fn twice(outputs: &[(String, PathBuf)]) -> Result<(), Failure> {
    for (i, (flag, path)) in outputs.iter().enumerate() {
        for (before, other) in &outputs[..i] {
            if is_same(path, other) {
                return Err(Failure::Usage(format!(
                    "{before} {} and {flag} {} are one file, which would hold one of the two: name \
                     two",
                    other.display(),
                    path.display()
                )));
            }
        }
    }
    Ok(())
}

/// Whether two outputs would be one file. Streams may be written to twice.
fn is_same(a: &Path, b: &Path) -> bool {
    match (fs::metadata(a).ok(), fs::metadata(b).ok()) {
        (Some(x), Some(y)) => x.is_file() && (x.dev(), x.ino()) == (y.dev(), y.ino()),
        (None, None) => absolute(a) == absolute(b),
        _ => false,
    }
}

/// A path that does not exist, by the nearest folder above it that does.
fn absolute(path: &Path) -> Option<PathBuf> {
    let whole = std::path::absolute(path).ok()?;
    let mut plain = PathBuf::new();
    for part in whole.components() {
        match part {
            std::path::Component::ParentDir => {
                plain.pop();
            }
            part => plain.push(part),
        }
        if let Ok(found) = fs::canonicalize(&plain) {
            plain = found;
        }
    }
    Some(plain)
}

/// Device and number of a regular file that is there.
fn regular(path: &Path) -> Option<(u64, u64)> {
    let found = fs::metadata(path).ok()?;
    found.is_file().then(|| (found.dev(), found.ino()))
}

/// All files that reading a path reads, as far as it says: itself, those in it where it is a
/// folder, and those that a description names.
fn files_of(path: &Path, depth: u32, found: &mut BTreeSet<(u64, u64)>) {
    if path.is_dir() {
        let entries = fs::read_dir(path).into_iter().flatten().flatten();
        for entry in entries {
            if depth == 0 || found.len() > MOST {
                return;
            }
            files_of(&entry.path(), depth - 1, found);
        }
        return;
    }
    let Some(file) = regular(path) else {
        return;
    };
    if !found.insert(file) || depth == 0 {
        return;
    }
    let is_text = |ending: &str| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case(ending))
    };
    if !is_text("toml") && !is_text("json") {
        return;
    }
    let Ok(text) = potamoi_base::files::read_text(path, LARGEST) else {
        return;
    };
    let text = text.trim_start_matches('\u{feff}');
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut names = vec![];
    if is_text("toml") {
        let value: Option<toml::Value> = toml::from_str(text).ok();
        let value = value.and_then(|value| serde_json::to_value(value).ok());
        value.iter().for_each(|value| texts(value, &mut names));
    } else {
        let value: Option<serde_json::Value> = serde_json::from_str(text).ok();
        value.iter().for_each(|value| texts(value, &mut names));
    }
    for name in names {
        let named = folder.join(&name);
        files_of(&named, depth - 1, found);
        // Frames of a path are named without their ending.
        files_of(&folder.join(name + ".png"), 0, found);
    }
}

/// All texts in a value.
fn texts(value: &serde_json::Value, found: &mut Vec<String>) {
    match value {
        serde_json::Value::String(text) if text.len() < 4096 => found.push(text.clone()),
        serde_json::Value::Array(items) => items.iter().for_each(|item| texts(item, found)),
        serde_json::Value::Object(fields) => fields.values().for_each(|v| texts(v, found)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use clap::CommandFactory as _;

    use super::*;

    /// Whoever adds an argument that names a file says here what it is.
    #[test]
    fn every_argument_that_names_a_file_has_a_role() {
        let root = crate::cli::Cli::command();
        let mut lacking = vec![];
        for command in root.get_subcommands() {
            let own = command.get_arguments().chain(root.get_arguments());
            for argument in own {
                let names = argument.get_value_names().unwrap_or_default();
                let is_path = names
                    .iter()
                    .any(|name| ["FILE", "DIR", "SCENE", "SCENE,..."].contains(&name.as_str()));
                let id = argument.get_id().as_str();
                if is_path && role(id).is_none() {
                    lacking.push(format!("{} --{id}", command.get_name()));
                }
            }
        }
        assert!(lacking.is_empty(), "{lacking:?}");
    }

    fn said(arguments: &[&str]) -> Option<String> {
        let matches = crate::cli::Cli::command().try_get_matches_from(arguments);
        check(&matches.unwrap()).err().map(|e| e.to_string())
    }

    #[test]
    fn one_file_has_one_part() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        let render = |out: &str, json: &str, scene: &str| {
            said(&[
                "potamoi", "render", "--scene", scene, "--out", out, "--json", json,
            ])
        };
        let (a, b) = (at("a.png"), at("b.json"));
        assert_eq!(render(&a, &b, "garden"), None);
        let twice = render(&a, &at("x/../a.png"), "garden").unwrap();
        assert!(twice.contains("are one file"), "{twice}");
        fs::write(&a, "a").unwrap();
        std::os::unix::fs::symlink(&a, &b).unwrap();
        assert!(render(&a, &b, "garden").is_some(), "a link to the other");
        assert_eq!(render("/dev/null", "/dev/null", "garden"), None);

        // Files that are read, directly or because a description says so.
        fs::remove_file(&b).unwrap();
        fs::write(at("m.ply"), "ply").unwrap();
        fs::write(
            at("s.toml"),
            "[model]\nkind = \"splats\"\npath = \"m.ply\"\n",
        )
        .unwrap();
        let lost = render(&a, &at("m.ply"), &at("m.ply")).unwrap();
        assert!(
            lost.contains("--json") && lost.contains("would be lost"),
            "{lost}"
        );
        assert!(render(&a, &at("m.ply"), &at("s.toml")).is_some());
        assert!(render(&a, &at("s.toml"), &at("s.toml")).is_some());
        assert_eq!(render(&a, &b, &at("s.toml")), None);
        let marked = format!("\u{feff}{}", fs::read_to_string(at("s.toml")).unwrap());
        fs::write(at("marked.toml"), marked).unwrap();
        assert!(render(&a, &at("m.ply"), &at("marked.toml")).is_some());
        fs::copy(at("s.toml"), at("S.TOML")).unwrap();
        assert!(render(&a, &at("m.ply"), &at("S.TOML")).is_some());

        // Folders that hold inputs, and files that are written into them.
        fs::create_dir(at("seq")).unwrap();
        fs::write(at("seq/frame.0000.png"), "png").unwrap();
        let images = "[model]\nkind = \"images\"\npath = \"seq\"\n";
        fs::write(at("images.toml"), images).unwrap();
        let warp = |out: &str| {
            said(&[
                "potamoi",
                "warp",
                "--scene",
                &at("images.toml"),
                "--out-dir",
                out,
            ])
        };
        assert!(warp(&at("seq")).unwrap().contains("frame.0000.png"));
        assert_eq!(warp(&at("other")), None);
        let path = |out: &str| {
            let (scene, out) = (at("images.toml"), at(out));
            said(&[
                "potamoi", "render", "--scene", &scene, "--out", &out, "--frames", "2",
            ])
        };
        assert!(path("seq/frame.png").unwrap().contains("frame.0000.png"));
        assert_eq!(path("seq/fram.png"), None);
        // A path of cameras names its pictures, with their ending or without.
        fs::create_dir(at("taken")).unwrap();
        fs::write(at("taken/frame.0000.png"), "png").unwrap();
        let way = at("way.json");
        for name in ["taken/frame.0000", "taken/frame.0000.png"] {
            fs::write(
                &way,
                format!("{{\"frames\": [{{\"file_path\": \"{name}\"}}]}}"),
            )
            .unwrap();
            let scene = ["potamoi", "render", "--scene", "garden", "--camera", &way];
            let out = at("taken/frame.0000.png");
            assert!(said(&[&scene[..], &["--out", &out]].concat()).is_some());
        }
        let trace = |json: &str| {
            let (out, mem) = (at("t.npz"), at("mem"));
            said(&[
                "potamoi",
                "trace",
                "--scene",
                "garden",
                "--out",
                &out,
                "--readmemh",
                &mem,
                "--json",
                json,
            ])
        };
        assert!(trace(&at("mem/memories.json")).is_some());
        assert!(trace(&at("mem/gathering_unit_tb.v")).is_some());
        assert_eq!(trace(&at("mem/report.json")), None);
        let emit = |json: &str| said(&["potamoi", "emit", "--out-dir", &at("mem"), "--json", json]);
        assert!(emit(&at("mem/vector_unit/vector_unit.v")).is_some());
        assert!(emit(&at("mem/manifest.json")).is_some());
        assert_eq!(emit(&at("mem/report.json")), None);
        assert_eq!(emit(&at("vector_unit.v")), None);
        fs::create_dir(at("mem")).unwrap();
        fs::write(at("mem/memories.json"), "{}").unwrap();
        std::os::unix::fs::symlink(at("mem/memories.json"), at("link.json")).unwrap();
        assert!(trace(&at("link.json")).is_some());
        let here = [
            "potamoi",
            "trace",
            "--scene",
            "garden",
            "--readmemh",
            ".",
            "--out",
            "memories.json",
        ];
        assert!(said(&here).unwrap().contains("writes as well"));
        fs::create_dir(at("f")).unwrap();
        fs::write(at("f/meta.json"), "{}").unwrap();
        assert!(render(&a, &at("f/meta.json"), &at("f")).is_some());
    }
}
