//! `potamoi inspect`: what a model's file says and holds, and what its format costs beside another.

mod tables;

use std::path::PathBuf;

use clap::Args;
use potamoi_base::outputs as files;
use potamoi_explore::inspection::{Beside, Inspected};
use potamoi_scene::Scene;
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;
use crate::progress;

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;
/// Default width of the pictures in pixels.
const WIDTH: u32 = 200;

#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    /// The model: a file or folder that --scene takes, or the name of a built-in scene
    #[arg(value_name = "FILE")]
    model: String,
    /// Another model of the same scene, which pictures and Gaussians are compared with [default: none]
    #[arg(value_name = "OTHER")]
    other: Option<String>,
    /// Camera file in the OpenCV convention [default: cameras around the model]
    #[arg(long, value_name = "FILE", requires = "other")]
    camera: Option<PathBuf>,
    /// Number of cameras: the first of the camera file or of the model's description, else around the model
    #[arg(long, value_name = "N", default_value_t = 4, requires = "other",
          value_parser = clap::value_parser!(u32).range(1..))]
    cameras: u32,
    /// Width of the picture [default: 200]
    #[arg(long, value_name = "PIXELS", requires = "other")]
    width: Option<u32>,
    /// Write the report as JSON; several scenes or frames share one report
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Serialize)]
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
    files::prepare([args.json.as_ref()])?;
    let mut scene = opened(common, &args.model)?;
    let mut report = Report {
        format_version: FORMAT_VERSION,
        command: "inspect",
        model: Inspected::of(&scene),
        other: None,
        beside: None,
        configuration: None,
    };
    tables::print(&report.model);
    if let Some(name) = &args.other {
        let other = opened(common, name)?;
        let found = Inspected::of(&other);
        tables::print(&found);
        report.other = Some(found);
        if let Some(path) = &args.camera {
            scene.set_camera_file(path, 0)?;
        }
        scene.set_size(Some(args.width.unwrap_or(WIDTH)), None)?;
        let config = common.chosen_for(&scene)?.config;
        let cameras = scene.standard_cameras(args.cameras)?;
        let spinner = progress::spinner("rendering both");
        let beside = Beside::of(&scene, &other, &cameras, &config)?;
        spinner.finish_and_clear();
        tables::print_beside(&beside);
        report.configuration = Some(config.hash());
        report.beside = Some(beside);
    }
    if let Some(path) = &args.json {
        files::write_json(path, &report)?;
    }
    Ok(())
}

fn opened(common: &Common, name: &str) -> Result<Scene, Failure> {
    let mut scene = Scene::open(name)?;
    common.machine()?.prepare(&mut scene)?;
    Ok(scene)
}
