//! `potamoi characterise`: the paper's motivation figures of a scene.

use std::path::PathBuf;

use clap::Args;
use comfy_table::{CellAlignment, Table, presets};
use indicatif::HumanBytes;
use potamoi_golden::characterise::{Accesses, Banks, Memory, Traffic};
use potamoi_golden::scene::Scene;
use potamoi_golden::voxels::Halo;
use serde::Serialize;

use crate::common::Common;
use crate::failure::Failure;
use crate::files;
use crate::progress;
use crate::say::say;
use crate::scene::SceneArgs;

#[derive(Debug, Args)]
pub(crate) struct CharacteriseArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;
/// The buffer of the paper's figures, in bytes.
const BUFFER: u64 = 2 << 20;
/// Rays side by side, and banks: the paper's pair first.
const LANES: [usize; 3] = [16, 32, 64];
const BANKS: [u32; 4] = [16, 32, 64, 128];

#[derive(Serialize)]
struct Report<'a> {
    format_version: u32,
    command: &'static str,
    scene: &'a str,
    width: u32,
    height: u32,
    /// Feature vectors of the model, and bytes of one.
    vectors: u64,
    vector_bytes: u32,
    model_bytes: u64,
    buffer_bytes: u64,
    memory: Memory,
    miss_rate: f64,
    not_streaming_rate: f64,
    banks: Vec<BankPoint>,
    /// Of splats alone.
    merging: Option<Merging>,
    /// Of splats by ray group, of fields in one volume by halo too.
    traffic: Vec<Traffic>,
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
    let scene = args.scene.open()?;
    let spinner = progress::spinner("counting the accesses of a frame");
    let mut banks = vec![];
    let mut first: Option<(Accesses, Memory)> = None;
    for rays in LANES {
        let accesses = scene.accesses(rays)?;
        for number in BANKS {
            let counts = accesses.banks(number);
            banks.push(BankPoint {
                rays,
                banks: number,
                counts,
                conflict_rate: counts.conflict_rate(),
            });
        }
        if first.is_none() {
            spinner.set_message("replacing by oracle");
            let memory = accesses.memory(BUFFER);
            first = Some((accesses, memory));
        }
    }
    spinner.set_message("counting the streams of the memory-centric order");
    let traffic = scene.traffic(&config, &sides(&scene))?;
    spinner.finish_and_clear();
    let Some((accesses, memory)) = first.filter(|(a, _)| !a.vectors.is_empty()) else {
        return Err(Failure::Inconclusive(format!(
            "{} reads nothing from here; choose a camera with something in view",
            scene.name()
        )));
    };
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "characterise",
        scene: scene.name(),
        width: scene.camera().width,
        height: scene.camera().height,
        vectors: accesses.stored,
        vector_bytes: accesses.bytes,
        model_bytes: accesses.stored_bytes(),
        buffer_bytes: BUFFER,
        memory,
        miss_rate: memory.miss_rate(),
        not_streaming_rate: memory.not_streaming_rate(),
        banks,
        merging: merging(&scene, config.mvoxel.rows),
        traffic,
    };
    print(&report);
    if let Some(path) = &args.json {
        files::write_json(path, &report)?;
    }
    Ok(())
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
        mvoxels_before: tree.cells(),
        mvoxels_after: tree.points().len(),
        points_before: per(tree.cells()),
        points_after: per(tree.points().len()),
        tree_bytes: tree.bytes(),
    })
}

fn print(report: &Report<'_>) {
    say!(
        "{} at {} x {}, pixel by pixel: {} reads of {} B vectors (counted)",
        report.scene,
        report.width,
        report.height,
        report.memory.reads,
        report.vector_bytes
    );
    let percent = |rate: f64| format!("{:.1} %", 100.0 * rate);
    let mut table = Table::new();
    table.load_preset(presets::ASCII_BORDERS_ONLY_CONDENSED);
    table.set_header(["", "this scene", "the paper"]);
    table.add_row([
        "feature vectors of the model",
        &HumanBytes(report.model_bytes).to_string(),
        "10 MB to 1 GB",
    ]);
    table.add_row([
        "misses of a 2 MB buffer with oracle replacement",
        &percent(report.miss_rate),
        "41 % on average, 92 % at most",
    ]);
    table.add_row([
        "accesses to memory that do not stream",
        &percent(report.not_streaming_rate),
        "over 87 %; hash tables and splats over 99 %",
    ]);
    if let Some(m) = report.merging {
        table.add_row([
            &format!("points an MVoxel of {} before merging", m.rows),
            &format!("{:.1}", m.points_before),
            "7.2",
        ]);
        table.add_row([
            "the same merged",
            &format!("{:.1}", m.points_after),
            "172.8",
        ]);
        table.add_row([
            "bytes of the octree",
            &HumanBytes(m.tree_bytes as u64).to_string(),
            "below 200 KB",
        ]);
    }
    for point in &report.banks {
        let paper = match (point.rays, point.banks) {
            (16, 16) => "51 % on average, 83 % at most",
            (64, 16) => "80 % for Instant-NGP",
            _ => "",
        };
        table.add_row([
            &format!(
                "bank conflicts, {} rays (tiles of splats) on {} banks",
                point.rays, point.banks
            ),
            &percent(point.conflict_rate),
            paper,
        ]);
    }
    if let Some(column) = table.column_mut(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    say!("{table}");
    streams(report);
}

fn streams(report: &Report<'_>) {
    if report.traffic.is_empty() {
        return;
    }
    say!("MVoxel by MVoxel, MB of a frame, every stream (counted):");
    let mut table = Table::new();
    table.load_preset(presets::ASCII_BORDERS_ONLY_CONDENSED);
    table.set_header([
        "ray group",
        "halo",
        "MVoxels",
        "entries",
        "records out",
        "MVoxels in",
        "RIT out",
        "RIT in",
        "features",
        "partial sums",
        "spills",
        "total",
    ]);
    let megabytes = |bytes: u64| format!("{:.2}", bytes as f64 / 1e6);
    for t in &report.traffic {
        let s = &t.streams;
        let bytes = [
            s.records_written,
            s.mvoxels_read,
            s.rit_written,
            s.rit_read,
            s.features,
            s.partial_sums,
            s.spills,
            s.total(),
        ];
        let halo = match t.halo {
            None => "",
            Some(Halo::Shared) => "shared",
            Some(Halo::Split) => "split",
        };
        let mut row = vec![
            t.side.to_string(),
            halo.to_owned(),
            t.mvoxels.to_string(),
            t.entries.to_string(),
        ];
        row.extend(bytes.map(megabytes));
        table.add_row(row);
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    say!("{table}");
}
