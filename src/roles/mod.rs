//! Roles of file arguments: no file may be both input and output, or an output twice, and no output
//! ends as another kind of file.
//!
//! Checked before any work, for all commands at once: an output that is also an input would destroy
//! it, and one file for two outputs would keep one of them.

mod endings;

use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use clap::ArgMatches;
use potamoi_scene::files_read::{files_of, regular};

use crate::failure::Failure;
use crate::renamed;

/// Role of an argument.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// A file or folder that is read, or a name that is neither.
    Input,
    /// A file to write.
    Output,
    /// A folder to write files into.
    Folder,
}

/// Role of an argument; `None` for those without files.
fn role(argument: &str) -> Option<Role> {
    Some(match argument {
        "out_dir" | "csv_dir" | "work_dir" | "dir" | "readmemh" | "netlists" => Role::Folder,
        "model" | "other" | "machine" | "machines" | "plan" | "beside" | "config" | "rtl"
        | "scene" | "scenes" | "for_scene" | "camera" | "mesh" | "trace" | "system" | "synth"
        | "liberty" | "compare" | "activity" | "fit_to" => Role::Input,
        "out" | "picture" | "json" | "vcd" | "csv" | "prices" | "plot" | "plot_energy"
        | "plot_roofline" | "found" | "chrome_trace" | "report" | "grid" | "forms" | "memories" => {
            Role::Output
        }
        _ => return None,
    })
}

/// Whether an argument names an output file or folder.
#[cfg(test)]
pub(crate) fn is_output(argument: &str) -> bool {
    matches!(role(argument), Some(Role::Output | Role::Folder))
}

/// Refuses arguments that would destroy a file. Flags are named as `arguments` name them.
///
/// # Errors
/// One file is named for two outputs, an output is also an input, or ends as another kind of file.
pub(crate) fn check(matches: &ArgMatches, arguments: &[OsString]) -> Result<(), Failure> {
    let Some((command, own)) = matches.subcommand() else {
        return Ok(());
    };
    let (mut inputs, mut outputs, mut folders, mut kinds) = (vec![], vec![], vec![], vec![]);
    for id in own.ids() {
        let Some(role) = role(id.as_str()) else {
            continue;
        };
        // What `cost` finds is written where there is a goal alone, though its file has a name by
        // default. An optimised clap does not tell an argument that a command lacks from an absent one.
        let has_goal = command != "cost" || own.contains_id("goal");
        if id == "found" && !has_goal {
            continue;
        }
        for value in own.get_raw(id.as_str()).into_iter().flatten() {
            let name = id.as_str().replace('_', "-");
            let flag = renamed::as_given(command, &name, arguments);
            let flag = match is_flag(&flag, arguments) {
                true => flag,
                false => POSITIONAL.to_owned(),
            };
            if role == Role::Output {
                kinds.push((id.as_str(), flag.clone(), Path::new(value)));
            }
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
                "{flag} {} is also written by {other} {}: name another output",
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
    // Which files an input reads takes time to find.
    let inputs = if lost.is_empty() { &[] } else { &inputs[..] };
    for (input, from) in inputs {
        let read = files_of(from);
        for (flag, path, file) in &lost {
            if read.contains(file) {
                return Err(Failure::Usage(format!(
                    "{flag} {} would overwrite a file that {input} {} reads: name another output",
                    path.display(),
                    from.display()
                )));
            }
        }
    }
    for (argument, flag, path) in &kinds {
        endings::check(command, argument, flag, path)?;
    }
    Ok(())
}

/// How an argument without a flag is named.
const POSITIONAL: &str = "the argument";

/// Whether a flag stands on the command line, or is one that has a default; an argument that has no flag is
/// named by its place.
fn is_flag(flag: &str, arguments: &[OsString]) -> bool {
    let words = || arguments.iter().map(|own| own.to_string_lossy());
    let is_given = words().any(|own| own == flag || own.starts_with(&format!("{flag}=")));
    is_given || ["--found", "--out"].contains(&flag)
}

/// Whether a file of this name may be written into an output folder: frames, streams, Verilog, tables,
/// and lists.
fn is_written(name: &str) -> bool {
    let is_frame = |start: &str| name.starts_with(start) && name.ends_with(".png");
    is_frame("frame.")
        || is_frame("origin.")
        || [".hex", ".v", ".sv", ".csv"]
            .iter()
            .any(|ending| name.ends_with(ending))
        || [
            "memories.json",
            "manifest.json",
            "Makefile",
            "journal.jsonl",
        ]
        .contains(&name)
}

/// Whether a frame of a path with the output `a.png` may have this name: `a.0007.png`.
fn is_numbered(out: &Path, name: &str) -> bool {
    let stem = out.file_stem().unwrap_or_default().to_string_lossy();
    let rest = name.strip_prefix(&*stem).and_then(|r| r.strip_prefix('.'));
    let number = rest.and_then(|rest| rest.strip_suffix(".png"));
    number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
}

/// Folder of a file.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Whether an output is a file that is also written into a folder, or below it.
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

/// Regular files of a folder with such names.
fn written_in(
    folder: &Path,
    is_such: impl Fn(&str) -> bool,
) -> impl Iterator<Item = (PathBuf, (u64, u64))> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .filter(move |entry| is_such(&entry.file_name().to_string_lossy()))
        .filter_map(|entry| Some((entry.path(), regular(&entry.path())?)))
}

/// Refuses an output folder that contains inputs with names of written files.
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
        let read = files_of(from);
        if let Some((path, _)) = written.iter().find(|(_, file)| read.contains(file)) {
            return Err(Failure::Usage(format!(
                "{flag} would overwrite {}, which {input} {} reads: name another output",
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
                    "{before} {} and {flag} {} are the same file: name two files",
                    other.display(),
                    path.display()
                )));
            }
        }
    }
    Ok(())
}

/// Whether two outputs are the same file. Streams may be written to twice.
fn is_same(a: &Path, b: &Path) -> bool {
    match (fs::metadata(a).ok(), fs::metadata(b).ok()) {
        (Some(x), Some(y)) => x.is_file() && (x.dev(), x.ino()) == (y.dev(), y.ino()),
        (None, None) => absolute(a) == absolute(b),
        _ => false,
    }
}

/// Absolute form of a path that does not exist, by its nearest existing parent folder.
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

#[cfg(test)]
mod tests;
