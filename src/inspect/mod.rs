//! `potamoi inspect`: what a model's file says and holds, and what its format costs beside another.

mod tables;

use std::path::{Path, PathBuf};

use clap::Args;
use potamoi_explore::inspection::{Beside, Inspected};
use potamoi_machines::machine::Section;
use potamoi_scene::Scene;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::{Common, quoted};
use crate::failure::Failure;
use crate::progress;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "inspect",
    version: FORMAT_VERSION,
    shape: shape::<Report>,
};
/// Default width of the pictures in pixels.
const WIDTH: u32 = 200;
/// Default number of cameras.
const CAMERAS: u32 = 4;

#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    /// The model: a file or folder that --scene takes, or the name of a built-in scene
    #[arg(value_name = "FILE")]
    model: String,
    /// Another model of the same scene, which pictures and Gaussians are compared with [default: none]
    #[arg(value_name = "OTHER")]
    other: Option<String>,
    /// Camera file in the OpenCV convention [default: cameras around the model]
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Number of cameras: the first of the camera file or of the model's description, else around the model [default: 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    cameras: Option<u32>,
    /// Width of the picture [default: 200]
    #[arg(long, value_name = "PIXELS")]
    width: Option<u32>,
    #[command(flatten)]
    files: ReportFiles,
}

#[derive(Serialize, JsonSchema)]
struct Report {
    format_version: u32,
    command: &'static str,
    #[serde(flatten)]
    model: Inspected,
    /// The other model, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    other: Option<Inspected>,
    /// The model beside the other.
    #[serde(skip_serializing_if = "Option::is_none")]
    beside: Option<Beside>,
    /// Hash of the configuration of the units, 12 hexadecimal digits.
    #[serde(skip_serializing_if = "Option::is_none")]
    configuration: Option<String>,
}

pub(crate) fn run(common: &Common, args: &InspectArgs) -> Result<(), Failure> {
    if args.other.is_none() {
        refuse_pictures(common, args)?;
    }
    args.files.prepare([])?;
    let mut scene = opened(common, &args.model)?;
    // Nothing is printed where one of both cannot be read.
    let other = args.other.as_ref().map(|name| opened(common, name));
    let other = other.transpose()?;
    let mut report = Report {
        format_version: FORMAT_VERSION,
        command: "inspect",
        model: Inspected::of(&scene),
        other: None,
        beside: None,
        configuration: None,
    };
    tables::print(&report.model);
    if let Some(other) = other {
        let found = Inspected::of(&other);
        tables::print(&found);
        report.other = Some(found);
        if let Some(path) = &args.camera {
            scene.set_camera_file(path, 0)?;
        }
        scene.set_size(Some(args.width.unwrap_or(WIDTH)), None)?;
        let config = common.chosen_for(&scene)?.config;
        let cameras = scene.standard_cameras(args.cameras.unwrap_or(CAMERAS))?;
        let spinner = progress::spinner("rendering both");
        let beside = Beside::of(&scene, &other, &cameras, &config)?;
        spinner.finish_and_clear();
        tables::print_beside(&beside);
        report.configuration = Some(config.hash());
        report.beside = Some(beside);
    }
    args.files.write(&report)?;
    Ok(())
}

/// Refuses what pictures of one model alone would take: none are made of it.
fn refuse_pictures(common: &Common, args: &InspectArgs) -> Result<(), Failure> {
    let of_pictures = [
        ("--camera", args.camera.is_some()),
        ("--cameras", args.cameras.is_some()),
        ("--width", args.width.is_some()),
    ];
    let beside = "name another model behind it, beside whose pictures its own are put";
    if let Some((flag, _)) = of_pictures.into_iter().find(|(_, is_given)| *is_given) {
        return Err(Failure::Usage(format!(
            "{flag}: one model alone is inspected without pictures: {beside}, or make one with potamoi \
             render --scene {}",
            quoted(Path::new(&args.model))
        )));
    }
    match &common.config {
        Some(given) if !common.machine()?.sections().contains(&Section::Render) => {
            Err(Failure::Usage(format!(
                "--config {}: one model alone is inspected without hardware, and the file has no [render]: \
                 {beside}, or leave --config out",
                given.display()
            )))
        }
        _ => Ok(()),
    }
}

fn opened(common: &Common, name: &str) -> Result<Scene, Failure> {
    let mut scene = Scene::open(name)?;
    common.machine()?.prepare(&mut scene)?;
    Ok(scene)
}
