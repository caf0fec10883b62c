//! `potamoi bench`: speed of the renderers, the units and verification, beside limits and peers.

mod table;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use potamoi_scene::Scene;
use potamoi_speed::{Comparison, Options, Section, compare};
use schemars::JsonSchema;
use serde::Serialize;

use crate::failure::Failure;
use crate::progress;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::scene::{left_open_of_files, note, say_not_checked, scene_help};

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "bench",
    version: FORMAT_VERSION,
    shape: shape::<Report>,
};

fn scenes() -> String {
    scene_help("built-in scenes alone")
}

#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    #[arg(long, value_name = "SCENE", help = scenes())]
    scene: Option<String>,
    /// Camera file in the OpenCV convention [default: the scene's own camera]
    #[arg(long, value_name = "FILE", requires = "scene")]
    camera: Option<PathBuf>,
    /// Index of the camera in the file, from 0
    #[arg(long, value_name = "N", default_value_t = 0, requires = "camera")]
    camera_index: usize,
    /// Width of the picture [default: the scene's]
    #[arg(long, value_name = "PIXELS", requires = "scene")]
    width: Option<u32>,
    /// Runs of each work, of which the fastest counts
    #[arg(long, value_name = "N", default_value_t = 5,
        value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// What to measure
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PART,...",
        default_values_t = [Part::Splats, Part::Fields, Part::Units, Part::Verify])]
    only: Vec<Part>,
    #[command(flatten)]
    files: ReportFiles,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// Frames of Gaussians in floating point, beside the peak of the machine's arithmetic
    Splats,
    /// Frames of fields in floating point, beside JAX
    Fields,
    /// Verilated units driven from Rust, beside a C++ testbench of the same stimulus
    Units,
    /// A whole verification, beside the C++ testbench for the clocks that it simulates
    Verify,
}

impl Part {
    const fn section(self) -> Section {
        match self {
            Self::Splats => Section::Splats,
            Self::Fields => Section::Fields,
            Self::Units => Section::Units,
            Self::Verify => Section::Verify,
        }
    }
}

#[derive(Serialize, JsonSchema)]
struct Report {
    format_version: u32,
    command: &'static str,
    #[serde(flatten)]
    found: Comparison,
    /// Items that the scene's file leaves open.
    not_checked: Vec<String>,
}

impl BenchArgs {
    fn open(&self) -> Result<Option<Scene>, Failure> {
        let Some(name) = &self.scene else {
            return Ok(None);
        };
        let mut scene = match &self.camera {
            Some(path) => Scene::open_seen_from(name, None, path, self.camera_index)?,
            None => Scene::open(name)?,
        };
        scene.set_size(self.width, None)?;
        note(&scene);
        Ok(Some(scene))
    }
}

pub(crate) fn run(args: &BenchArgs) -> Result<(), Failure> {
    args.files.prepare([])?;
    let options = Options {
        sections: args.only.iter().map(|part| part.section()).collect(),
        runs: args.runs,
        scene: args.open()?,
    };
    options.check()?;
    let bar = progress::bar(options.steps(), "measuring");
    let mut begun = false;
    let found = compare(&options, &mut |what| {
        // A step ends where the next begins.
        bar.inc(u64::from(begun));
        begun = true;
        bar.set_message(what.to_owned());
    });
    bar.finish_and_clear();
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "bench",
        found: found?,
        not_checked: left_open_of_files(),
    };
    table::print(&report.found);
    say_not_checked(&report.not_checked);
    args.files.write(&report)
}
