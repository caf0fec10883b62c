//! `potamoi cache`: lists or clears results cached between runs.

use std::path::PathBuf;

use clap::Args;
use potamoi_synth::SynthError;
use schemars::JsonSchema;
use serde::Serialize;

use crate::failure::Failure;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::stdout::say;
use potamoi_result_cache::listing::{Entry, KINDS, Listing};

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "cache",
    version: FORMAT_VERSION,
    shape: shape::<Report>,
};
#[derive(Debug, Args)]
pub(crate) struct CacheArgs {
    /// List the kept results; the default
    #[arg(long, conflicts_with = "clear")]
    list: bool,
    /// Remove all kept results; they are computed again on demand
    #[arg(long)]
    clear: bool,
    #[command(flatten)]
    files: ReportFiles,
}

#[derive(Debug, Serialize, JsonSchema)]
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
    args.files.prepare([])?;
    let root = potamoi_verilated::cache::root().map_err(SynthError::from)?;
    let mut found = Listing::default();
    if root.is_dir() {
        let root = potamoi_verilated::cache::claim(&root).map_err(SynthError::from)?;
        found = Listing::of(&root)?;
        if args.clear {
            found.remove(&root)?;
        }
    }
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "cache",
        folder: root,
        cleared: args.clear,
        bytes: found.entries.iter().map(|e| e.bytes).sum(),
        entries: found.entries,
        not_kept_by_potamoi: found.foreign,
    };
    print(&report);
    args.files.write(&report)
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
