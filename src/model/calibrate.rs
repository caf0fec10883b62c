//! Calibration of the GPU's efficiencies to the paper's times, and their error on held-out times.

use potamoi_explore::system::{GpuFactors, SIDE, TIMED, Timed, WARPED};
use potamoi_scene::scenes_named;
use potamoi_system::system_model::System;
use serde::Serialize;

use super::ModelArgs;
use super::report::{self, Report};
use crate::args::Common;
use crate::failure::Failure;
use crate::progress;
use crate::stdout::say;
use crate::tables;

/// Frame rate of Instant-NGP, which is held out of the calibration, and gathering's mean share of
/// the time (paper, Sec. "Introduction" and "Performance and Energy").
const HELD_OUT: f64 = 0.20;
const GATHERING: f64 = 64.0;
const DEFAULT: [&str; 3] = ["all:dvgo", "all:splats", "all:ngp"];

/// The efficiencies, the measurements that they are fitted to, and held-out ones.
#[derive(Serialize)]
struct Factors {
    #[serde(flatten)]
    report: Report<Timed>,
    fields_efficiency: Option<f64>,
    splats_efficiency: Option<f64>,
    pictures_efficiency: f64,
}

pub(super) fn run(common: &Common, args: &ModelArgs, system: &System) -> Result<(), Failure> {
    let names = match args.scenes.is_empty() {
        true => scenes_named(&DEFAULT.map(str::to_owned)),
        false => scenes_named(&args.scenes),
    };
    let bar = progress::bar(names.len() as u64, "counting");
    let mut scenes = vec![];
    for name in names {
        bar.set_message(name.clone());
        let mut scene = args.scene.open_named(&name)?;
        if !args.scene.looks_otherwise() {
            scene.set_size(Some(SIDE), Some(SIDE))?;
        }
        scenes.push(Timed::of(&name, &args.setup(common, system, scene)?)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let factors = GpuFactors::find(system, &mut scenes);
    let found = Factors {
        report: Report::new("model --calibrate", system, scenes),
        fields_efficiency: factors.fields,
        splats_efficiency: factors.splats,
        pictures_efficiency: factors.pictures,
    };
    print(&found);
    report::write(&found, args)
}

fn print(found: &Factors) {
    let mut table = tables::plain([
        "scene",
        "algorithm",
        "Gaussians",
        "model, MB",
        "ms at peak",
        "indexing",
        "gathering",
        "computation",
        "gathering's share",
        "frames/s by the factor",
        "gathering's share",
    ]);
    for timed in &found.report.scenes {
        let ms = timed.best.total_ns() * 1e-6;
        let by_factor = &timed.by_factor;
        table.add_row([
            timed.scene.clone(),
            timed.algorithm.to_owned(),
            timed.gaussians.to_string(),
            format!("{:.2}", timed.model_bytes as f64 * 1e-6),
            format!("{ms:.2}"),
            format!("{:.2}", timed.best.indexing_ns * 1e-6),
            format!("{:.2}", timed.best.gathering_ns * 1e-6),
            format!("{:.2}", timed.best.computation_ns * 1e-6),
            format!(
                "{:.0} %",
                100.0 * timed.best.gathering_ns / timed.best.total_ns()
            ),
            format!("{:.2}", 1e9 / by_factor.total_ns()),
            format!(
                "{:.0} %",
                100.0 * by_factor.gathering_ns / by_factor.total_ns()
            ),
        ]);
    }
    say!("{table}");
    let is_other = |t: &&Timed| t.size != [SIDE, SIDE];
    if let Some(other) = found.report.scenes.iter().find(is_other) {
        let [width, height] = other.size;
        say!(
            "these factors do not describe the paper's GPU: {} is {width} x {height}, whereas \
             the paper's times are of {SIDE} x {SIDE}; leave out --width and --height",
            other.scene
        );
    }
    for ((algorithm, target), factor) in TIMED
        .iter()
        .zip([found.fields_efficiency, found.splats_efficiency])
    {
        if let Some(factor) = factor {
            say!("{algorithm} at {target} frames/s on average: {factor:.4} of the GPU's peak");
        }
    }
    let (points, ns) = WARPED;
    say!(
        "{points} points warped in {} ms: {:.4} of the GPU's peak",
        ns * 1e-6,
        found.pictures_efficiency
    );
    let held_out: Vec<&Timed> = (found.report.scenes.iter())
        .filter(|t| t.algorithm.starts_with("Instant-NGP"))
        .collect();
    if !held_out.is_empty() {
        let all = held_out.iter().map(|t| t.by_factor.total_ns());
        let mean = all.sum::<f64>() / held_out.len() as f64;
        say!(
            "held out, Instant-NGP: {:.2} frames/s on average on the GPU alone; the paper: {HELD_OUT} on GPU and NPU \
             (beside it stands the baseline of model --scene cairn:ngp --width 800)",
            1e9 / mean
        );
    }
    let shares = (found.report.scenes.iter())
        .map(|t| 100.0 * t.by_factor.gathering_ns / t.by_factor.total_ns());
    let share = shares.sum::<f64>() / found.report.scenes.len().max(1) as f64;
    say!(
        "held out, gathering: {share:.0} % of the time on average; the paper: above {GATHERING} %"
    );
}
