//! `potamoi report`: one page about scenes on machines.

mod asked;
mod collect;
mod document;
mod paper;
mod pictures;
mod plots;
mod provenance;

use std::path::PathBuf;

use clap::{ArgAction, Args};
use potamoi_base::outputs as files;
use potamoi_machines::Machine;
use potamoi_scene::{Scene, scenes_named};

use crate::failure::Failure;
use crate::progress::{self, Shown};
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::scene::note;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "report",
    version: document::FORMAT_VERSION,
    shape: shape::<document::Document>,
};

#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// Scenes: built-in ones, model files, descriptions
    #[arg(value_name = "SCENE", required = true)]
    scenes: Vec<String>,
    // In place of the one of all commands: several may be given.
    #[arg(long, value_name = "FILE", action = ArgAction::Append, help = crate::args::config_help())]
    config: Vec<PathBuf>,
    /// File for the result
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Width of the picture [default: the scene's]
    #[arg(long, value_name = "PIXELS")]
    width: Option<u32>,
    /// Height of the picture [default: in proportion to the width]
    #[arg(long, value_name = "PIXELS")]
    height: Option<u32>,
    /// Number of frames on the camera path
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,
    /// Knobs to vary [default: all knobs of the scene]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    knobs: Vec<String>,
    #[command(flatten)]
    files: ReportFiles,
}

pub(crate) fn run(args: &ReportArgs) -> Result<(), Failure> {
    let ending = args.out.extension().map(|own| own.to_ascii_lowercase());
    if ending.is_none_or(|own| own != "html" && own != "htm") {
        return Err(Failure::Usage(format!(
            "--out {}: the report is a page; name a file that ends in .html",
            args.out.display()
        )));
    }
    args.files.prepare([Some(&args.out)])?;
    let machines = machines(&args.config)?;
    let scenes = scenes(args)?;
    let bar = progress::bar(0, "reporting");
    let asked = asked::Asked {
        machines: &machines,
        scenes: &scenes,
        frames: args.frames,
        knobs: &args.knobs,
    };
    let found = collect::collect(&asked, &Shown(&bar));
    bar.finish_and_clear();
    let found = found?;
    let text = potamoi_page::page(&found.document, &found.images)
        .map_err(|error| Failure::Usage(format!("{}: {error}", args.out.display())))?;
    files::write(&args.out, &text)?;
    args.files.write(&found.document)?;
    crate::stdout::say!("written to {}", args.out.display());
    for own in &found.unverified {
        crate::stdout::remark(format_args!("{own}"));
    }
    match found.differs {
        None => Ok(()),
        Some(what) => Err(Failure::check(what)),
    }
}

/// The machines, each once.
fn machines(given: &[PathBuf]) -> Result<Vec<Machine>, Failure> {
    let mut all: Vec<Machine> = vec![];
    for name in given {
        let machine = Machine::named(&name.to_string_lossy())?;
        if let Some(note) = machine.note() {
            crate::stdout::remark(format_args!("{note}"));
        }
        if all.iter().any(|own| own.name == machine.name) {
            return Err(Failure::Usage(format!(
                "--config {}: named twice: leave one of both out",
                name.display()
            )));
        }
        all.push(machine);
    }
    if all.is_empty() {
        all.push(Machine::for_any_scene()?);
    }
    Ok(all)
}

fn scenes(args: &ReportArgs) -> Result<Vec<Scene>, Failure> {
    let mut all = vec![];
    for name in scenes_named(&args.scenes) {
        if all.iter().any(|own: &Scene| own.name() == name) {
            return Err(Failure::Usage(format!(
                "scene {name}: named twice: leave one of both out"
            )));
        }
        let mut scene = Scene::open(&name)?;
        scene.set_size(args.width, args.height)?;
        note(&scene);
        all.push(scene);
    }
    Ok(all)
}
