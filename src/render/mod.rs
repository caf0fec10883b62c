//! `potamoi render`: a picture of a scene.

mod frames;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use potamoi_explore::accuracy::{ImageQuality, Reference, References};
use potamoi_explore::rendering::{Numerics, Shot, not_checked, shoot, whole_float};
use potamoi_formats::config::Config;
use potamoi_formats::units::{GATHERING_UNIT, OpCode, SPLAT_UNIT, VECTOR_UNIT};
use potamoi_rtl::RtlCycles;
use potamoi_scene::{FrameCounts, Scene};
use potamoi_splats::Flips;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;
use crate::progress;
use crate::published::{Published, either};
use crate::report_files::ReportFiles;
use crate::scene::{SceneArgs, say_all_pairs, say_not_checked};
use crate::stdout::{prose, say};

#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Arithmetic that computes the picture
    #[arg(long, value_enum, default_value_t = By::Fixed)]
    numerics: By,
    /// File for the result
    ///
    /// A PNG picture. With --frames, the number of each frame is inserted before the ending:
    /// a.png becomes a.0000.png, a.0001.png and so on.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Number of frames on the camera path [default: one picture, from the scene's camera]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Frame rate of the scene's own camera path, or of a recorded motion
    #[arg(long, value_name = "FPS", default_value_t = 30.0, requires = "frames")]
    fps: f64,
    /// Compare the picture with the references of quality, too: the ground truth where it is known, and
    /// the converged picture
    #[arg(long, conflicts_with = "frames")]
    quality: bool,
    #[command(flatten)]
    files: ReportFiles,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum By {
    /// The analytic field that a built-in model was sampled from
    Truth,
    /// 64-bit floating point
    Float,
    /// The hardware's formats, by the reference units
    Fixed,
    /// The hardware's formats, by the Verilated units
    Rtl,
}

impl From<By> for Numerics {
    fn from(by: By) -> Self {
        match by {
            By::Truth => Self::Truth,
            By::Float => Self::Float,
            By::Fixed => Self::Fixed,
            By::Rtl => Self::Rtl,
        }
    }
}

/// Version of the JSON report.
pub(crate) const FORMAT_VERSION: u32 = 2;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "render",
    version: FORMAT_VERSION,
    shape: either::<Report<'_>, frames::Report<'_>>,
};

#[derive(Serialize, JsonSchema)]
struct Report<'a> {
    format_version: u32,
    command: &'static str,
    scene: &'a str,
    width: u32,
    height: u32,
    numerics: Numerics,
    /// Hash of the configuration, 12 hexadecimal digits.
    configuration: String,
    /// Quality against the same scene and settings in floating point, in unquantised linear RGB, peak
    /// 1: the error of the hardware's formats, and of what `--without` names.
    float: Option<ImageQuality>,
    /// PSNR in dB over pixels that are not empty in floating point.
    float_covered_db: Option<f64>,
    covered_pixels: usize,
    /// What quality is measured against, if that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    reference: Option<Reference>,
    /// Quality against the ground truth, if that was asked for and is known.
    truth: Option<ImageQuality>,
    /// Quality against the converged picture, if that was asked for.
    converged: Option<ImageQuality>,
    /// Skips and early terminations decided otherwise than in floating point; splats only.
    flipped_skips: Option<u64>,
    flipped_stops: Option<u64>,
    /// Why all (tile, Gaussian) pairs are listed although the configuration asks for fewer.
    #[serde(skip_serializing_if = "Option::is_none")]
    keeps_all_pairs: Option<&'static str>,
    /// Work of the frame, counted by the renderer.
    frame: Option<&'a FrameCounts>,
    /// Results of the units, counted by themselves.
    units: Option<Units>,
    /// Clock cycles of the Verilated units with streams always ready.
    cycles: Option<RtlCycles>,
    /// Verilated units that were built: those with work.
    instantiated: Option<Vec<&'static str>>,
    /// Items outside the units, and items that a model's file leaves open.
    not_checked: Vec<String>,
    seconds: f64,
}

#[derive(Serialize, JsonSchema)]
pub(crate) struct Units {
    /// Feature vectors from the gathering unit.
    feature_vectors: u64,
    /// Elements from the vector unit, by operation.
    elements: BTreeMap<OpCode, u64>,
    /// Jobs of the splat unit, one a ray group.
    splat_jobs: u64,
    /// Pixels from the splat unit, 256 a tile.
    splat_pixels: u64,
}

impl Units {
    pub(crate) fn of(shot: &Shot) -> Option<Self> {
        shot.units.as_ref().map(|units| Self {
            feature_vectors: units.feature_vectors,
            elements: units.elements.clone(),
            splat_jobs: units.splat_jobs,
            splat_pixels: units.splat_pixels,
        })
    }
}

pub(crate) fn run(common: &Common, args: &RenderArgs) -> Result<(), Failure> {
    let ending = args.out.extension().map(|e| e.to_ascii_lowercase());
    if ending.is_none_or(|e| e != "png") {
        return Err(Failure::Usage(format!(
            "--out {}: pictures are written as PNG; name a file that ends in .png",
            args.out.display()
        )));
    }
    args.files.prepare([Some(&args.out)])?;
    let config = common.read_config()?;
    let scene = args.scene.open(common)?;
    let numerics = Numerics::from(args.numerics);
    if let Some(frames) = args.frames {
        let wanted = frames::Sequence {
            numerics,
            out: &args.out,
            fps: args.fps,
            frames,
            report_files: &args.files,
        };
        return frames::run(scene, &config, &wanted);
    }
    let start = Instant::now();
    let spinner = progress::spinner("rendering");
    // A picture in floating point with no effect left out is what others are compared with.
    let float = match is_whole_float(&scene, numerics) {
        true => None,
        false => Some(whole_float(&scene)?),
    };
    let references = match args.quality {
        true => Some(References::of(&scene)?),
        false => None,
    };
    if numerics == Numerics::Rtl {
        spinner.set_message("rendering through the Verilated units");
    }
    let shot = taken(&scene, &config, numerics)?;
    let seconds = start.elapsed().as_secs_f64();
    spinner.finish_and_clear();
    let picture = &shot.picture;
    picture.picture.write_png(&args.out)?;

    let covered = (float.as_ref())
        .and_then(|float| (picture.picture).psnr(&float.picture, |i| float.covered[i]));
    let flips: Option<Flips> = float.as_ref().and_then(|float| picture.flips(float));
    let is_covered = &float.as_ref().unwrap_or(picture).covered;
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "render",
        scene: scene.name(),
        width: scene.camera().width,
        height: scene.camera().height,
        numerics,
        configuration: config.hash(),
        float: (float.as_ref()).map(|own| ImageQuality::of(&picture.picture, &own.picture)),
        float_covered_db: covered.filter(|db| db.is_finite()),
        covered_pixels: is_covered.iter().filter(|c| **c).count(),
        reference: references.as_ref().map(References::described),
        truth: (references.as_ref()).and_then(|own| own.truth(&picture.picture)),
        converged: (references.as_ref()).map(|own| own.converged(&picture.picture)),
        flipped_skips: flips.map(|f| f.skip),
        flipped_stops: flips.map(|f| f.stop),
        keeps_all_pairs: keeps_all_pairs(&scene, &config, numerics),
        frame: shot.counts(),
        units: Units::of(&shot),
        cycles: shot.cycles,
        instantiated: shot.instantiated.map(|built| {
            let units = [GATHERING_UNIT, VECTOR_UNIT, SPLAT_UNIT]
                .into_iter()
                .zip(built);
            units
                .filter_map(|(unit, is_built)| is_built.then_some(unit))
                .collect()
        }),
        not_checked: not_checked(&scene, &config, numerics, &[*scene.camera()]),
        seconds,
    };
    print(&report, &scene, args);
    args.files.write(&report)?;
    Ok(())
}

/// Whether a picture is the scene in floating point with no effect left out. Forced effects change no
/// bit of it.
fn is_whole_float(scene: &Scene, numerics: Numerics) -> bool {
    numerics == Numerics::Float && scene.choices().left_out().is_empty()
}

/// A picture of the scene; in floating point without the decisions that nothing is compared with.
pub(crate) fn taken(scene: &Scene, config: &Config, numerics: Numerics) -> Result<Shot, Failure> {
    if is_whole_float(scene, numerics) {
        return Ok(Shot::of(scene.render_float_picture()?));
    }
    Ok(shoot(scene, config, numerics)?)
}

/// Prints PSNR against each picture that the result was compared with.
fn print_quality(report: &Report<'_>) {
    let float = report.float.and_then(|float| float.db);
    if let (Some(frame), Some(covered)) = (float, report.float_covered_db) {
        say!(
            "  PSNR to float (linear RGB, unquantised): {frame:.1} dB over the frame, {covered:.1} dB \
             over {} covered pixels",
            report.covered_pixels
        );
    }
    let Some(reference) = &report.reference else {
        return;
    };
    let db = |own: ImageQuality| {
        own.db
            .map_or("equal".to_owned(), |db| format!("{db:.2} dB"))
    };
    if let Some(truth) = report.truth {
        say!("  PSNR to truth: {}", db(truth));
    }
    if let Some(converged) = report.converged {
        let how = reference.converged.words();
        say!("  PSNR to converged: {} ({how})", db(converged));
    }
}

/// Prints the work of the splat unit, where it composited.
fn print_splats(report: &Report<'_>) {
    let units = report.units.as_ref().filter(|units| units.splat_jobs > 0);
    let splats = report.frame.and_then(|frame| frame.splats);
    if let (Some(units), Some(splats)) = (units, splats) {
        say!(
            "  out of the splat unit: {} pixels of {} ray groups",
            units.splat_pixels,
            units.splat_jobs
        );
        say!(
            "  its pairs of pixel and Gaussian: {} square sums, {} exponentials, {} drawn, {} \
             stopped",
            splats.pairs_evaluated,
            splats.exponentials,
            splats.pairs_drawn,
            splats.pairs_stopped
        );
    }
}

/// Why all (tile, Gaussian) pairs are listed although the configuration asks for fewer; `None` in floating
/// point too, where no table is made.
fn keeps_all_pairs(scene: &Scene, config: &Config, numerics: Numerics) -> Option<&'static str> {
    let lists = matches!(numerics, Numerics::Fixed | Numerics::Rtl);
    scene.keeps_all_pairs(config).filter(|_| lists)
}

fn print(report: &Report<'_>, scene: &Scene, args: &RenderArgs) {
    let by = match report.numerics {
        Numerics::Truth => "its analytic field",
        Numerics::Float => "64-bit floating point",
        Numerics::Fixed => "the units' twins",
        Numerics::Rtl => "the Verilated units",
    };
    say!(
        "{} at {} x {}, by {by}: {}",
        scene.name(),
        report.width,
        report.height,
        args.out.display()
    );
    print_quality(report);
    if let (Some(skips), Some(stops)) = (report.flipped_skips, report.flipped_stops) {
        say!("  decisions that flipped: {skips} skips, {stops} stops");
    }
    if let Some(units) = &report.units {
        let tasks = match report.frame {
            // Tables that do not stream have no MVoxels.
            Some(f) if f.scattered_bytes > 0 => {
                format!("{} MVoxels and sets of rows fetched one by one", f.mvoxels)
            }
            frame => format!("{} MVoxels", frame.map_or(0, |f| f.mvoxels)),
        };
        say!(
            "  out of the gathering unit: {} feature vectors ({tasks})",
            units.feature_vectors
        );
        for (op, count) in &units.elements {
            say!(
                "  out of the vector unit: {count} elements of {}",
                op.name()
            );
        }
    }
    if let Some(outcomes) = report.frame.and_then(|f| f.sample_outcomes) {
        prose!(
            2,
            "gathered samples: {}, of which {} are composited, {} have alpha 0, {} no weight after \
             rounding, {} lie behind the end of their ray",
            outcomes.total(),
            outcomes.composited,
            outcomes.transparent,
            outcomes.without_weight,
            outcomes.behind
        );
    }
    print_splats(report);
    if let Some(streams) = report.frame.map(|f| f.streams) {
        let megabytes = |bytes: u64| bytes as f64 / 1e6;
        say!(
            "  bytes of all streams: {:.2} MB, {:.2} of which are MVoxels and {:.2} the ray index \
             table",
            megabytes(streams.total()),
            megabytes(streams.mvoxels_read),
            megabytes(streams.rit_written + streams.rit_read)
        );
        let scattered = report.frame.map_or(0, |f| f.scattered_bytes);
        if scattered > 0 {
            say!(
                "  of the MVoxels' bytes {:.2} MB are rows fetched one by one",
                megabytes(scattered)
            );
        }
    }
    if let Some([first, tables]) = report.frame.and_then(|f| f.reverts) {
        say!("  rows one by one, not MVoxel by MVoxel: from table {first} of {tables} on");
    }
    if let Some(why) = report.keeps_all_pairs {
        say_all_pairs(why);
    }
    if let Some(splats) = report.frame.and_then(|f| f.splats) {
        say!(
            "  pairs of pixel and Gaussian: {} evaluated, {} drawn, {} that stop a pixel",
            splats.pairs_evaluated,
            splats.pairs_drawn,
            splats.pairs_stopped
        );
        if let Some(test) = splats.pair_test {
            say!(
                "  pairs of tile and Gaussian: {} of {} are left out, since no pixel can count",
                test.left_out,
                test.pairs
            );
        }
        if splats.inversions > 0 {
            say!(
                "  approximate order: {} entries after one that lies behind them",
                splats.inversions
            );
        } else {
            say!(
                "  exact order: at most {} records held back, {} spilled, for {} tiles in all",
                splats.records_held,
                splats.records_spilled,
                splats.entries_spilled
            );
        }
        if splats.saturated > 0 {
            say!(
                "  WARNING: {} values of records exceed their format and were held at its limit",
                splats.saturated
            );
        }
    }
    if let Some(cycles) = &report.cycles {
        say!(
            "  clock cycles (measured RTL, streams always ready): {} gathering, {} vector{}",
            cycles.gather,
            cycles.vector,
            match cycles.splat {
                0 => String::new(),
                cycles => format!(", {cycles} splat unit"),
            }
        );
    }
    say_not_checked(&report.not_checked);
}
