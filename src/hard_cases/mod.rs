//! `potamoi hard-cases`: inputs on which the obvious form of a computation fails, by both forms, with the
//! formats of a configuration and on the data of a scene.

mod report;
mod sheet;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use potamoi_analysis::hard_cases::pictures::Shown;
use potamoi_analysis::hard_cases::{CheckState, HardCase, SceneCases, measure, of_scene};
use potamoi_base::outputs as files;
use potamoi_formats::config::Config;
use potamoi_scene::Scene;

use crate::args::Common;
use crate::failure::Failure;
use crate::progress;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::scene::{SceneArgs, scene_help};

use report::{Pictures, Report};

/// Default width of pictures in pixels.
const WIDTH: u32 = 128;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "hard-cases",
    version: report::FORMAT_VERSION,
    shape: shape::<Report<'_>>,
};

#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| scene.help(scene_help("no scene"))))]
#[command(mut_arg("width", |width| width.help("Width of the picture [default: 128]")))]
pub(crate) struct HardCasesArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Write a labelled contact sheet of the pictures as PNG
    #[arg(long, value_name = "FILE", value_parser = png)]
    picture: Option<PathBuf>,
    /// Write the results as CSV: a line of names, and one for each machine, case, setting, form or input
    /// that the command measures
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    files: ReportFiles,
}

/// Parses the file name of a picture.
fn png(given: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(given);
    match path.extension().is_some_and(|kind| kind == "png") {
        true => Ok(path),
        false => Err("the contact sheet is a PNG: expected a name that ends in .png".to_owned()),
    }
}

pub(crate) fn run(common: &Common, args: &HardCasesArgs) -> Result<(), Failure> {
    args.files
        .prepare([&args.picture, &args.csv].map(Option::as_ref))?;
    if let (None, Some(flag)) = (&args.scene.scene, args.scene.looks_otherwise_by()) {
        return Err(Failure::Usage(format!(
            "{flag}: expected with --scene: without one the cases have pictures of their own, 33 x 25"
        )));
    }
    let begun = Instant::now();
    let scene = match args.scene.scene {
        Some(_) => Some(opened(common, args)?),
        None => None,
    };
    let (config, preset) = match &scene {
        Some(scene) => {
            let chosen = common.chosen_for(scene)?;
            (chosen.config, chosen.preset)
        }
        None => (common.read_config()?, common.preset()),
    };
    let spinner = progress::spinner("rendering the hard scenes");
    let pictures = Pictures::of(&config);
    if let (Some(file), Some(reason), None) = (&args.picture, &pictures.none, &scene) {
        return Err(Failure::Usage(format!(
            "--picture {}: there is nothing to draw, as {reason}: leave it out, or add --scene",
            file.display()
        )));
    }
    let named = named(common, preset, &config, scene.as_ref());
    spinner.set_message("measuring both forms");
    let cases = measure(&config);
    let found = match &scene {
        Some(scene) => {
            spinner.set_message("looking at the scene");
            Some(of_scene(scene, &config)?)
        }
        None => None,
    };
    spinner.finish_and_clear();
    let failed = failed(&cases, &pictures, found.as_ref());
    let report = Report::new(
        (&config, preset, &named),
        &cases,
        &pictures,
        scene.as_ref().zip(found.as_ref()),
        failed.clone(),
        begun.elapsed(),
    );
    report.print();
    if let Some(file) = &args.csv {
        files::write(file, &report.csv()?)?;
    }
    args.files.write(&report)?;
    if let Some(file) = &args.picture {
        draw(file, &named, &pictures, scene.as_ref().zip(found.as_ref()))?;
    }
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Failure::check(format!(
            "hard cases: {} fail: {}",
            failed.len(),
            failed.join("; ")
        ))),
    }
}

fn opened(common: &Common, args: &HardCasesArgs) -> Result<Scene, Failure> {
    let mut scene = args.scene.open(common)?;
    if !args.scene.looks_otherwise() {
        scene.set_size(Some(WIDTH), None)?;
    }
    Ok(scene)
}

/// How the configuration is named: as it was given, otherwise as the scene needs it.
fn named(common: &Common, preset: Option<&str>, config: &Config, scene: Option<&Scene>) -> String {
    match (&common.config, preset, scene) {
        (Some(given), Some(preset), _) if given.as_os_str() == preset => preset.to_owned(),
        (Some(given), ..) => format!("{} ({})", given.display(), config.hash()),
        (None, Some(preset), Some(scene)) if common.preset() != Some(preset) => {
            format!("{preset}, which scene {} needs", scene.name())
        }
        (None, Some(preset), _) => preset.to_owned(),
        (None, None, _) => config.hash(),
    }
}

/// Names of what fails.
fn failed(cases: &[HardCase], pictures: &Pictures, scene: Option<&SceneCases>) -> Vec<String> {
    let cases = cases.iter().filter(|own| own.fails()).map(|own| own.name);
    let shown = pictures.shown.iter().map(|own: &Shown| &own.check);
    let checks = shown.chain(scene.iter().flat_map(|own| &own.checks));
    let checks = checks.filter(|own| own.state == CheckState::Fails);
    cases
        .chain(checks.map(|own| own.name))
        .map(str::to_owned)
        .collect()
}

fn draw(
    file: &Path,
    named: &str,
    pictures: &Pictures,
    scene: Option<(&Scene, &SceneCases)>,
) -> Result<(), Failure> {
    let mut rows: Vec<sheet::Row> = pictures.shown.iter().map(sheet::Row::of_case).collect();
    rows.extend(scene.map(|(scene, found)| sheet::Row::of_scene(scene.name(), found)));
    let title = format!("hard cases, configuration {named}");
    sheet::sheet(&title, &rows).write_png(file)?;
    Ok(())
}
