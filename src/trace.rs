//! `potamoi trace`: records the calls of the units for a frame, with the expected results.

use std::path::PathBuf;

use clap::Args;
use indicatif::HumanCount;
use potamoi_base::outputs as files;
use potamoi_reference::trace_recorder::Limits;
use potamoi_rtl::bench::readmemh;
use potamoi_scene::trace::Trace;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;
use crate::progress;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::scene::{SceneArgs, say_not_checked};
use crate::stdout::{prose, say};

#[derive(Debug, Args)]
pub(crate) struct TraceArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// File for the result
    ///
    /// A trace as a NumPy archive (NPZ), which `potamoi verify --trace` reads.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Folder for `$readmemh` files and testbenches that read them
    #[arg(long, value_name = "DIR")]
    readmemh: Option<PathBuf>,
    /// Maximum number of recorded RIT entries; recording ends with the MVoxel that reaches it
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    entries: u64,
    /// Maximum number of recorded elements of vector operations
    #[arg(long, value_name = "N", default_value_t = 200_000)]
    elements: u64,
    /// Record the whole frame
    #[arg(long, conflicts_with_all = ["entries", "elements"])]
    all: bool,
    #[command(flatten)]
    files: ReportFiles,
}

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "trace",
    version: FORMAT_VERSION,
    shape: shape::<Report<'_>>,
};

#[derive(Serialize, JsonSchema)]
struct Report<'a> {
    format_version: u32,
    command: &'static str,
    scene: &'a str,
    /// Hash of the configuration, 12 hexadecimal digits.
    configuration: &'a str,
    mvoxels: usize,
    /// RIT entries, one feature vector each.
    samples: usize,
    operations: usize,
    elements: usize,
    bytes: u64,
    /// Items outside the units, and items that a model's file leaves open.
    not_checked: Vec<String>,
}

pub(crate) fn run(common: &Common, args: &TraceArgs) -> Result<(), Failure> {
    args.files.prepare([Some(&args.out)])?;
    let config = common.read_config()?;
    let scene = args.scene.open(common)?;
    let limits = if args.all {
        Limits::NONE
    } else {
        Limits {
            entries: args.entries,
            elements: args.elements,
        }
    };
    let spinner = progress::spinner("recording");
    let trace = Trace::record(&scene, &config, limits)?;
    trace.write(&args.out)?;
    if let Some(folder) = &args.readmemh {
        spinner.set_message("writing $readmemh files");
        let emit = format!("potamoi emit{}", common.arguments());
        let files = readmemh(&config, &trace.gathered, &trace.computed, &emit)?;
        for (name, text) in &files.texts {
            files::write(&folder.join(name), text)?;
        }
        files::write_json(&folder.join("memories.json"), &files.memories)?;
    }
    spinner.finish_and_clear();
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "trace",
        scene: &trace.scene,
        configuration: &trace.configuration,
        mvoxels: trace.gathered.len(),
        samples: trace.gathered.iter().map(|g| g.task.entries.len()).sum(),
        operations: trace.computed.len(),
        elements: trace.computed.iter().map(|c| c.a.len()).sum(),
        bytes: std::fs::metadata(&args.out).map_or(0, |m| m.len()),
        not_checked: scene.not_checked(&config),
    };
    prose!(
        0,
        "{}: {} feature vectors of {} MVoxels, {} elements of {} vector operations, \
         configuration {}, {} bytes",
        args.out.display(),
        HumanCount(report.samples as u64),
        report.mvoxels,
        HumanCount(report.elements as u64),
        report.operations,
        report.configuration,
        HumanCount(report.bytes)
    );
    if let Some(folder) = &args.readmemh {
        say!(
            "{}: $readmemh files, memories.json with their widths, and testbenches",
            folder.display()
        );
    }
    say_not_checked(&report.not_checked);
    args.files.write(&report)?;
    Ok(())
}
