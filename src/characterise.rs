//! `potamoi characterise`: the paper's motivation figures of a scene, or of
//! many side by side.

mod paper;
mod tables;

use std::path::PathBuf;

use clap::Args;
use potamoi_formats::config::Config;
use potamoi_scene::Scene;
use potamoi_scene::characterise::{BANKS, Banks, LANES, Memory, Stages, Traffic, Vectors};
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;
use crate::files;
use crate::progress;
use crate::scene::{SceneArgs, named, say_not_checked};
use crate::stdout::say;
use paper::Paper;

#[derive(Debug, Args)]
pub(crate) struct CharacteriseArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Scenes side by side, with commas between them; `all` is every built-in scene in every
    /// representation, `cairn:all` every one of a scene, `all:ngp` every scene in one [default: the
    /// one of --scene]
    #[arg(
        long,
        value_name = "SCENE,...",
        value_delimiter = ',',
        conflicts_with = "scene"
    )]
    scenes: Vec<String>,
    /// Count reads of tables as large as the algorithm's authors use, with the model's samples
    #[arg(long)]
    full_size: bool,
    /// Write the report as JSON; of several scenes or frames, one report of all
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 3;
/// The buffer of the paper's figures, in bytes.
const BUFFER: u32 = 2 << 20;

#[derive(Serialize)]
struct Report {
    format_version: u32,
    command: &'static str,
    #[serde(flatten)]
    found: Found,
}

#[derive(Serialize)]
struct Reports {
    format_version: u32,
    command: &'static str,
    scenes: Vec<Found>,
}

/// What was found of one scene.
#[derive(Serialize)]
struct Found {
    scene: String,
    algorithm: &'static str,
    width: u32,
    height: u32,
    /// Whether reads are of tables as large as the algorithm's authors use.
    full_size: bool,
    /// Feature vectors of the model, table after table.
    tables: Vec<Vectors>,
    model_bytes: u64,
    buffer_bytes: u32,
    memory: Memory,
    miss_rate: f64,
    not_streaming_rate: f64,
    banks: Vec<BankPoint>,
    /// Seconds, measured.
    stages: Stages,
    /// What the paper states.
    paper: Paper,
    /// Of splats alone.
    merging: Option<Merging>,
    /// By ray group, and by halo where MVoxels share vertices.
    traffic: Vec<Traffic>,
    /// What a model's file leaves open.
    not_checked: Vec<String>,
}

#[derive(Clone, Copy, Serialize)]
struct Merging {
    /// Gaussians that an MVoxel holds.
    rows: u32,
    mvoxels_before: usize,
    mvoxels_after: usize,
    points_before: f64,
    points_after: f64,
    tree_bytes: usize,
}

#[derive(Serialize)]
struct BankPoint {
    rays: usize,
    banks: u32,
    counts: Banks,
    conflict_rate: f64,
}

pub(crate) fn run(common: &Common, args: &CharacteriseArgs) -> Result<(), Failure> {
    files::prepare([args.json.as_ref()])?;
    let config = common.read_config()?;
    let command = "characterise";
    let format_version = FORMAT_VERSION;
    if args.scenes.is_empty() {
        let spinner = progress::spinner("counting the accesses of a frame");
        let found = characterise(&args.scene.open()?, &config, args.full_size)?;
        spinner.finish_and_clear();
        tables::print(&found);
        say_not_checked(&found.not_checked);
        let report = Report {
            format_version,
            command,
            found,
        };
        return args
            .json
            .as_ref()
            .map_or(Ok(()), |path| Ok(files::write_json(path, &report)?));
    }
    let names = named(&args.scenes);
    let bar = progress::bar(names.len() as u64, "characterising");
    let mut scenes = vec![];
    for name in names {
        bar.set_message(name.clone());
        scenes.push(characterise(
            &args.scene.open_named(&name)?,
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
    args.json
        .as_ref()
        .map_or(Ok(()), |path| Ok(files::write_json(path, &report)?))
}

fn characterise(scene: &Scene, config: &Config, full: bool) -> Result<Found, Failure> {
    let counted = scene.characterise(config, BUFFER, &sides(scene), full)?;
    let (accesses, memory) = (&counted.accesses, counted.accesses.memory);
    if memory.reads == 0 {
        return Err(Failure::Inconclusive(format!(
            "{} reads nothing from here; choose a camera with something in view",
            scene.name()
        )));
    }
    let points = LANES.iter().zip(&accesses.banks);
    let banks = points.flat_map(|(rays, own)| {
        let own = BANKS.into_iter().zip(own);
        own.map(|(banks, counts)| BankPoint {
            rays: *rays,
            banks,
            counts: *counts,
            conflict_rate: counts.conflict_rate(),
        })
    });
    let algorithm = scene.model().algorithm();
    Ok(Found {
        scene: scene.name().to_owned(),
        algorithm,
        width: scene.camera().width,
        height: scene.camera().height,
        full_size: full && scene.model().full_size().is_some(),
        model_bytes: accesses.stored_bytes(),
        buffer_bytes: BUFFER,
        memory,
        miss_rate: memory.miss_rate(),
        not_streaming_rate: memory.not_streaming_rate(),
        banks: banks.collect(),
        stages: counted.stages,
        paper: Paper::of(algorithm),
        merging: merging(scene, config.mvoxel.rows),
        traffic: counted.traffic,
        not_checked: scene.left_open(),
        tables: counted.accesses.tables,
    })
}

/// Ray groups from 16 pixels a side to the frame.
fn sides(scene: &Scene) -> Vec<u32> {
    let frame = scene.camera().width.max(scene.camera().height);
    let smaller = [16, 32, 64, 128, 256, 512];
    let smaller = smaller.into_iter().filter(|side| *side < frame);
    smaller.chain([frame]).collect()
}

fn merging(scene: &Scene, rows: u32) -> Option<Merging> {
    let tree = scene.octree(rows as usize)?;
    let points: usize = tree.points().iter().sum();
    let per = |mvoxels: usize| points as f64 / mvoxels.max(1) as f64;
    Some(Merging {
        rows,
        mvoxels_before: tree.cells().len(),
        mvoxels_after: tree.points().len(),
        points_before: per(tree.cells().len()),
        points_after: per(tree.points().len()),
        tree_bytes: tree.bytes(),
    })
}
