//! `potamoi characterise`: the paper's motivation figures for one or several scenes.

mod paper;
mod tables;

use clap::Args;
use potamoi_explore::characterisation::Characterisation;
use potamoi_scene::scenes_named;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;
use crate::progress;
use crate::published::{Published, either};
use crate::report_files::ReportFiles;
use crate::scene::{SceneArgs, say_all_pairs, say_not_checked};
use crate::stdout::say;

#[derive(Debug, Args)]
pub(crate) struct CharacteriseArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Scenes to compare, separated by commas; `all` is every built-in scene in every
    /// representation, `cairn:all` one scene in every representation, `all:ngp` every scene in one
    /// [default: the one of --scene]
    #[arg(
        long,
        value_name = "SCENE,...",
        value_delimiter = ',',
        conflicts_with = "scene"
    )]
    scenes: Vec<String>,
    /// Count reads of tables in the size that the algorithm's authors use, with the model's samples
    #[arg(long)]
    full_size: bool,
    #[command(flatten)]
    files: ReportFiles,
}

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 3;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "characterise",
    version: FORMAT_VERSION,
    shape: either::<Report, Reports>,
};

#[derive(Serialize, JsonSchema)]
struct Report {
    format_version: u32,
    command: &'static str,
    #[serde(flatten)]
    found: Characterisation,
}

#[derive(Serialize, JsonSchema)]
struct Reports {
    format_version: u32,
    command: &'static str,
    scenes: Vec<Characterisation>,
}

pub(crate) fn run(common: &Common, args: &CharacteriseArgs) -> Result<(), Failure> {
    args.files.prepare([])?;
    let config = common.read_config()?;
    let command = "characterise";
    let format_version = FORMAT_VERSION;
    if args.scenes.is_empty() {
        let spinner = progress::spinner("counting the accesses of a frame");
        let found = Characterisation::of(&args.scene.open(common)?, &config, args.full_size)?;
        spinner.finish_and_clear();
        tables::print(&found);
        if let Some(why) = found.keeps_all_pairs {
            say_all_pairs(why);
        }
        say_not_checked(&found.not_checked);
        let report = Report {
            format_version,
            command,
            found,
        };
        return args.files.write(&report);
    }
    let names = scenes_named(&args.scenes);
    let bar = progress::bar(names.len() as u64, "characterising");
    let mut scenes = vec![];
    for name in names {
        bar.set_message(name.clone());
        scenes.push(Characterisation::of(
            &args.scene.open_named(&name, common)?,
            &config,
            args.full_size,
        )?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    tables::side_by_side(&scenes);
    for found in scenes.iter().filter(|found| !found.not_checked.is_empty()) {
        say!("{}:", found.scene);
        say_not_checked(&found.not_checked);
    }
    let report = Reports {
        format_version,
        command,
        scenes,
    };
    args.files.write(&report)
}
