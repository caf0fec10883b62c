//! What was found, as tables with the paper's figures.

use comfy_table::{CellAlignment, Table, presets};
use indicatif::HumanBytes;
use potamoi_golden::characterise::Stages;
use potamoi_golden::voxels::Halo;

use super::Found;
use crate::say::say;

fn megabytes(bytes: u64) -> String {
    format!("{:.2}", bytes as f64 / 1e6)
}

pub(super) fn print(found: &Found) {
    say!(
        "{} at {} x {}, pixel by pixel: {} reads of {} B vectors (counted)",
        found.scene,
        found.width,
        found.height,
        found.memory.reads,
        found.vector_bytes
    );
    let percent = |rate: f64| format!("{:.1} %", 100.0 * rate);
    let mut table = Table::new();
    table.load_preset(presets::ASCII_BORDERS_ONLY_CONDENSED);
    table.set_header(["", "this scene", "the paper"]);
    table.add_row([
        "feature vectors of the model",
        &HumanBytes(found.model_bytes).to_string(),
        "10 MB to 1 GB",
    ]);
    table.add_row([
        "misses of a 2 MB buffer with oracle replacement",
        &percent(found.miss_rate),
        "41 % on average, 92 % at most",
    ]);
    table.add_row([
        "accesses to memory that do not stream",
        &percent(found.not_streaming_rate),
        "over 87 %; hash tables and splats over 99 %",
    ]);
    let [indexing, gathering, computation] = found.stages.shares();
    for (stage, share) in [
        ("indexing", indexing),
        ("gathering", gathering),
        ("feature computation", computation),
    ] {
        let row = format!("{stage}, of the float renderer's time here (measured)");
        let share = share.map_or_else(|| "with the next".to_owned(), percent);
        table.add_row([&row, &share, ""]);
    }
    if let Some(m) = found.merging {
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
    for point in &found.banks {
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
    streams(found);
}

fn streams(found: &Found) {
    if found.traffic.is_empty() {
        return;
    }
    say!("MVoxel by MVoxel, MB of a frame, every stream (counted); scattered, of MVoxels in:");
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
        "scattered",
    ]);
    for t in &found.traffic {
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
        row.push(megabytes(t.scattered));
        table.add_row(row);
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    say!("{table}");
}

/// Shares in per cent; gathering and computation of splats are one.
fn stages(stages: &Stages) -> String {
    let percent = |share: f64| format!("{:.0}", 100.0 * share);
    let shares = stages.shares().map(|s| s.map_or("-".to_owned(), percent));
    format!("{} %", shares.join(", "))
}

/// A row a scene.
pub(super) fn side_by_side(scenes: &[Found]) {
    let mut table = Table::new();
    table.load_preset(presets::ASCII_BORDERS_ONLY_CONDENSED);
    table.set_header([
        "scene",
        "algorithm",
        "vectors of the model",
        "misses",
        "not streaming",
        "conflicts 16 on 16",
        "64 on 16",
        "points an MVoxel, merged",
        "indexing, gathering, computation",
        "pixel-centric, MB",
        "MVoxel by MVoxel, MB",
    ]);
    let percent = |rate: f64| format!("{:.1} %", 100.0 * rate);
    let conflicts = |found: &Found, rays: usize| {
        let point = found.banks.iter().find(|p| p.rays == rays && p.banks == 16);
        point.map_or_else(String::new, |p| percent(p.conflict_rate))
    };
    for found in scenes {
        let fetched = found.memory.misses * u64::from(found.vector_bytes);
        let frame = found.traffic.iter().rfind(|t| t.halo != Some(Halo::Split));
        table.add_row([
            found.scene.clone(),
            format!(
                "{}{}",
                found.algorithm,
                if found.full_size { ", full size" } else { "" }
            ),
            HumanBytes(found.model_bytes).to_string(),
            percent(found.miss_rate),
            percent(found.not_streaming_rate),
            conflicts(found, 16),
            conflicts(found, 64),
            found.merging.map_or_else(String::new, |m| {
                format!("{:.1}, {:.1}", m.points_before, m.points_after)
            }),
            stages(&found.stages),
            megabytes(fetched),
            frame.map_or_else(String::new, |t| megabytes(t.streams.total())),
        ]);
    }
    table.add_row([
        "the paper",
        "",
        "10 MB to 1 GB",
        "41 %, at most 92 %",
        "over 87 %; hash, splats over 99 %",
        "51 %, at most 83 %",
        "80 % (Instant-NGP)",
        "7.2, 172.8",
        "",
        "",
        "",
    ]);
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    say!("{table}");
    say!(
        "stages are measured in the float renderer here, all else is counted; misses of a 2 MB buffer with oracle replacement, and their bytes; MVoxel by MVoxel \
         with the frame as one ray group"
    );
}
