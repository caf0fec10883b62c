//! `potamoi cache`: lists or clears results cached between runs.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::Args;
use potamoi_synth::SynthError;
use serde::Serialize;

use crate::failure::Failure;
use crate::files::{self, FileError};
use crate::stdout::say;

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;
/// Folders of what is kept, and what it is.
const KINDS: [(&str, &str); 3] = [
    ("models", "Verilog models, built for simulation"),
    ("work", "work counted on rendered frames"),
    ("synth", "results of synthesis"),
];

#[derive(Debug, Args)]
pub(crate) struct CacheArgs {
    /// List what is kept (unless --clear is given)
    #[arg(long, conflicts_with = "clear")]
    list: bool,
    /// Remove all that is kept: it is made again when it is asked for
    #[arg(long)]
    clear: bool,
    /// Write the report as JSON; of several scenes or frames, one report of all
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Debug, Serialize)]
struct Entry {
    kind: &'static str,
    name: String,
    bytes: u64,
    /// Age in seconds.
    age_seconds: u64,
}

#[derive(Debug, Serialize)]
struct Report {
    format_version: u32,
    command: &'static str,
    folder: PathBuf,
    /// Whether the entries were removed.
    cleared: bool,
    bytes: u64,
    entries: Vec<Entry>,
    /// Other entries in those folders, which are never removed.
    not_kept_by_potamoi: Vec<PathBuf>,
}

pub(crate) fn run(args: &CacheArgs) -> Result<(), Failure> {
    files::prepare([args.json.as_ref()])?;
    let root = potamoi_verilated::cache::root().map_err(SynthError::from)?;
    let mut entries = vec![];
    let mut foreign = vec![];
    if root.is_dir() {
        let root = potamoi_verilated::cache::claim(&root).map_err(SynthError::from)?;
        for (kind, _) in KINDS {
            found(&root, kind, &mut entries, &mut foreign)?;
        }
        if args.clear {
            for entry in &entries {
                remove(&root.join(entry.kind).join(&entry.name))?;
            }
        }
    }
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "cache",
        folder: root,
        cleared: args.clear,
        bytes: entries.iter().map(|e| e.bytes).sum(),
        entries,
        not_kept_by_potamoi: foreign,
    };
    print(&report);
    match &args.json {
        Some(path) => Ok(files::write_json(path, &report)?),
        None => Ok(()),
    }
}

fn print(report: &Report) {
    for (kind, words) in KINDS {
        let own: Vec<&Entry> = report.entries.iter().filter(|e| e.kind == kind).collect();
        if own.is_empty() {
            continue;
        }
        say!("{kind}: {words}");
        for entry in own {
            say!(
                "  {:>9}  {:>8}  {}",
                size(entry.bytes),
                age(entry.age_seconds),
                entry.name
            );
        }
    }
    let removed = if report.cleared { "removed" } else { "kept" };
    say!(
        "{} entries, {}, {removed} in {}",
        report.entries.len(),
        size(report.bytes),
        report.folder.display()
    );
    for path in &report.not_kept_by_potamoi {
        say!("not kept by potamoi, and left alone: {}", path.display());
    }
}

fn size(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} B"),
        10_000..10_000_000 => format!("{} kB", bytes / 1000),
        _ => format!("{} MB", bytes / 1_000_000),
    }
}

fn age(seconds: u64) -> String {
    match seconds {
        0..120 => format!("{seconds} s"),
        120..7200 => format!("{} min", seconds / 60),
        7200..172_800 => format!("{} h", seconds / 3600),
        _ => format!("{} d", seconds / 86_400),
    }
}

/// Entries of a kind and other files, told apart by name. An entry under construction has a name
/// that begins with a dot.
fn found(
    root: &Path,
    kind: &'static str,
    entries: &mut Vec<Entry>,
    foreign: &mut Vec<PathBuf>,
) -> Result<(), FileError> {
    let folder = root.join(kind);
    if !folder.is_dir() {
        return Ok(());
    }
    let fail = |e| FileError::new(&folder, e);
    let mut own = vec![];
    for entry in fs::read_dir(&folder).map_err(fail)? {
        let entry = entry.map_err(fail)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let Ok(metadata) = entry.metadata() else {
            continue;
        };
        if name.starts_with('.') {
            continue;
        }
        if !potamoi_result_cache::ends_with_key(&name) {
            foreign.push(entry.path());
            continue;
        }
        let made = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
        let age = SystemTime::now().duration_since(made).unwrap_or_default();
        own.push(Entry {
            kind,
            name,
            bytes: bytes(&entry.path()),
            age_seconds: age.as_secs(),
        });
    }
    own.sort_by(|a, b| a.name.cmp(&b.name));
    foreign.sort();
    entries.append(&mut own);
    Ok(())
}

/// Size of a file, or of all files in a folder; links are not followed.
fn bytes(path: &Path) -> u64 {
    match fs::symlink_metadata(path) {
        Ok(found) if found.is_dir() => {
            let inside = fs::read_dir(path).into_iter().flatten().flatten();
            inside.map(|entry| bytes(&entry.path())).sum()
        }
        Ok(found) => found.len(),
        Err(_) => 0,
    }
}

fn remove(path: &Path) -> Result<(), FileError> {
    let is_folder = fs::symlink_metadata(path).is_ok_and(|found| found.is_dir());
    let removed = if is_folder {
        fs::remove_dir_all(path)
    } else {
        fs::remove_file(path)
    };
    removed.map_err(|e| FileError::new(path, e))
}
