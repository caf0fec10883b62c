//! `potamoi render --frames`: the frames of a camera path.

use std::path::{Path, PathBuf};
use std::time::Instant;

use potamoi_base::outputs as files;
use potamoi_explore::rendering::{Numerics, not_checked};
use potamoi_formats::config::Config;
use potamoi_rtl::RtlCycles;
use potamoi_scene::{FrameCounts, Scene};
use schemars::JsonSchema;
use serde::Serialize;

use super::{FORMAT_VERSION, Units, keeps_all_pairs, taken};
use crate::failure::Failure;
use crate::progress;
use crate::report_files::ReportFiles;
use crate::scene::{say_all_pairs, say_not_checked};
use crate::stdout::say;

/// Frames to render, and their files.
pub(crate) struct Sequence<'a> {
    pub(crate) numerics: Numerics,
    /// File name to which frame numbers are added.
    pub(crate) out: &'a Path,
    /// Frames a second of an analytic scene's path.
    pub(crate) fps: f64,
    pub(crate) frames: u32,
    pub(crate) report_files: &'a ReportFiles,
}

#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    format_version: u32,
    command: &'static str,
    scene: &'a str,
    numerics: Numerics,
    /// Hash of the configuration, 12 hexadecimal digits.
    configuration: String,
    /// Why all (tile, Gaussian) pairs are listed although the configuration asks for fewer.
    #[serde(skip_serializing_if = "Option::is_none")]
    keeps_all_pairs: Option<&'static str>,
    frames: Vec<Frame>,
    /// Items outside the units, and items that a model's file leaves open.
    not_checked: Vec<String>,
    seconds: f64,
}

/// One frame, as in the report of a single picture.
#[derive(Serialize, JsonSchema)]
struct Frame {
    file: PathBuf,
    width: u32,
    height: u32,
    frame: Option<FrameCounts>,
    units: Option<Units>,
    cycles: Option<RtlCycles>,
}

/// Renders the frames beside `out`, numbered from 0. Each file is written atomically, so that an
/// interrupted run leaves complete frames.
pub(crate) fn run(mut scene: Scene, config: &Config, wanted: &Sequence<'_>) -> Result<(), Failure> {
    let cameras = scene.path(wanted.fps, wanted.frames)?;
    let names: Vec<PathBuf> = (0..cameras.len())
        .map(|n| numbered(wanted.out, n, cameras.len()))
        .collect();
    files::prepare(names.iter().map(Some))?;
    let start = Instant::now();
    let bar = progress::bar(cameras.len() as u64, "rendering");
    let mut frames = vec![];
    for (camera, name) in cameras.iter().zip(&names) {
        scene.set_camera(*camera);
        let shot = taken(&scene, config, wanted.numerics)?;
        shot.picture.picture.write_png(name)?;
        frames.push(Frame {
            file: name.clone(),
            width: camera.width,
            height: camera.height,
            frame: shot.counts().cloned(),
            units: Units::of(&shot),
            cycles: shot.cycles,
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "render",
        scene: scene.name(),
        numerics: wanted.numerics,
        configuration: config.hash(),
        keeps_all_pairs: keeps_all_pairs(&scene, config, wanted.numerics),
        frames,
        not_checked: not_checked(&scene, config, wanted.numerics, &cameras),
        seconds: start.elapsed().as_secs_f64(),
    };
    if let (Some(first), Some(last)) = (names.first(), names.last()) {
        say!(
            "{}: {} pictures, {} to {}, in {:.1} s",
            report.scene,
            names.len(),
            first.display(),
            last.display(),
            report.seconds
        );
    }
    if let Some(why) = report.keeps_all_pairs {
        say_all_pairs(why);
    }
    say_not_checked(&report.not_checked);
    wanted.report_files.write(&report)?;
    Ok(())
}

/// `a/b.png` as `a/b.0007.png`: at least four digits, and as many as the last frame has.
fn numbered(out: &Path, n: usize, count: usize) -> PathBuf {
    let digits = count.saturating_sub(1).to_string().len().max(4);
    out.with_extension(format!("{n:0digits$}.png"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_sort_as_names() {
        let out = Path::new("a/way.PNG");
        assert_eq!(numbered(out, 7, 10), Path::new("a/way.0007.png"));
        assert_eq!(numbered(out, 7, 10_001), Path::new("a/way.00007.png"));
    }
}
