//! Tables of results with the paper's figures.

use comfy_table::{CellAlignment, Table, presets};
use indicatif::HumanBytes;
use potamoi_explore::characterisation::{Characterisation, PaperMotivation};
use potamoi_explore::splat_unit_run::{SplatPart, SplatUnitRun};
use potamoi_march::tiling::Halo;
use potamoi_scene::characterise::{SplatPairs, Stages, Traffic};

use super::paper::{conflicts_16, percent};
use crate::stdout::{prose, say};
use crate::tables;

fn megabytes(bytes: u64) -> String {
    format!("{:.2}", bytes as f64 / 1e6)
}

/// A share in per cent.
fn tenths(rate: f64) -> String {
    format!("{:.1} %", 100.0 * rate)
}

/// Sizes of the model's vectors, without duplicates.
fn sizes(found: &Characterisation) -> String {
    let mut sizes: Vec<u32> = found.tables.iter().map(|table| table.bytes).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let sizes: Vec<String> = sizes.iter().map(u32::to_string).collect();
    sizes.join(", ")
}

pub(super) fn print(found: &Characterisation) {
    say!(
        "{} at {} x {}, pixel order: {} reads of vectors of {} B (counted)",
        found.scene,
        found.width,
        found.height,
        found.memory.reads,
        sizes(found)
    );
    let paper = &found.paper;
    let mut table = Table::new();
    table.load_preset(presets::ASCII_BORDERS_ONLY_CONDENSED);
    let algorithm = format!("this scene, {}", found.algorithm);
    table.set_header(["", &algorithm, "the paper"]);
    table.add_row([
        "feature vectors of the model",
        &HumanBytes(found.model_bytes).to_string(),
        &stored(paper),
    ]);
    table.add_row([
        "miss rate of a 2 MB buffer with oracle replacement",
        &tenths(found.miss_rate),
        &misses(paper),
    ]);
    table.add_row([
        "non-streaming memory accesses",
        &tenths(found.not_streaming_rate),
        &format!("over {}", percent(paper.not_streaming_above)),
    ]);
    let [indexing, gathering, computation] = found.stages.shares();
    let most = format!(
        "over {} on average, on a mobile GPU",
        percent(paper.gathering_above)
    );
    for (stage, share, paper) in [
        ("indexing", indexing, ""),
        ("gathering", gathering, &most),
        ("feature computation", computation, ""),
    ] {
        let row = format!("{stage}, share of the float renderer's time (measured)");
        let share = share.map_or_else(|| "in the next row".to_owned(), tenths);
        table.add_row([&row, &share, paper]);
    }
    if let Some(m) = found.merging {
        let [before, after] = paper.points.map_or_else(Default::default, |points| {
            points.map(|points| format!("{points:.1}"))
        });
        table.add_row([
            &format!("points per MVoxel (capacity {}), before merging", m.rows),
            &format!("{:.1}", m.points_before),
            &before,
        ]);
        table.add_row([
            "points per MVoxel, after merging",
            &format!("{:.1}", m.points_after),
            &after,
        ]);
        let most = paper
            .tree_bytes
            .map(|bytes| format!("below {} KB", bytes / 1000));
        table.add_row([
            "bytes of the octree",
            &HumanBytes(m.tree_bytes as u64).to_string(),
            &most.unwrap_or_default(),
        ]);
    }
    for point in &found.banks {
        let paper = match (point.rays, point.banks) {
            (16, 16) => conflicts_16(paper),
            (64, 16) => paper.conflicts_64_on_16.map(percent).unwrap_or_default(),
            _ => String::new(),
        };
        table.add_row([
            &format!(
                "bank conflicts, {} rays (tiles of splats) on {} banks",
                point.rays, point.banks
            ),
            &tenths(point.conflict_rate),
            &paper,
        ]);
    }
    if let Some(frame) = frame(found)
        && frame.scattered > 0
    {
        let share = frame.scattered as f64 / frame.streams.total().max(1) as f64;
        table.add_row([
            "non-streaming bytes in MVoxel order, share of the frame",
            &tenths(share),
            &paper
                .scattered
                .map(|share| format!("about {}", percent(share)))
                .unwrap_or_default(),
        ]);
    }
    if let Some(column) = table.column_mut(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    say!("{}", tables::fitted(&table, &[]));
    if let Some(pairs) = &found.pairs {
        pixel_pairs(pairs);
    }
    if let Some(run) = &found.splat_unit {
        splat_unit(run);
    }
    streams(found);
}

/// Pairs of pixel and Gaussian, each kind a part of the one before.
fn pixel_pairs(pairs: &SplatPairs) {
    prose!(
        0,
        "pairs of pixel and Gaussian in depth order, counted; pairs that neither draw nor stop a \
         pixel change no bit of the picture"
    );
    let mut table = tables::lined(1, ["pairs", "count", "share of the row above"]);
    for (what, count, of) in [
        ("tile and Gaussian", pairs.tile_pairs, None),
        (
            "in whose tile a pixel may count",
            pairs.tile_pairs_that_may_count,
            Some(pairs.tile_pairs),
        ),
        (
            "with a pixel that counts",
            pairs.tile_pairs_that_count,
            Some(pairs.tile_pairs_that_may_count),
        ),
        (
            "pixel that has not stopped and Gaussian",
            pairs.evaluated,
            None,
        ),
        (
            "within the Gaussian's span of the row",
            pairs.in_spans,
            Some(pairs.evaluated),
        ),
        (
            "with a power below the limit of the opacity",
            pairs.kept,
            Some(pairs.in_spans),
        ),
        (
            "drawn, or stopping the pixel",
            pairs.drawn + pairs.stopped,
            Some(pairs.kept),
        ),
    ] {
        let share = of.map(|of| tenths(count as f64 / of.max(1) as f64));
        table.add_row([what, &count.to_string(), &share.unwrap_or_default()]);
    }
    say!("{}", tables::fitted(&table, &[]));
}

/// The frame on the splat unit.
fn splat_unit(run: &SplatUnitRun) {
    let own = &run.counters;
    let counted = (own.drawn + own.stopped).max(1) as f64;
    say!(
        "splat unit, {}, {} tiles in flight, streams without pauses (cycle model): {} cycles, {:.2} lane clocks \
         for each pair that draws or stops a pixel, {:.3} square sums and {:.3} exponentials; {:.3} lanes \
         of vectors, those without a pair among them",
        match run.lanes {
            1 => "one lane".to_owned(),
            lanes => format!("{lanes} lanes"),
        },
        run.tiles,
        run.cycles,
        run.lane_clocks_a_counted_pair,
        own.square_sums as f64 / counted,
        own.exponentials as f64 / counted,
        run.lane_slots_a_counted_pair
    );
    for without in &run.without {
        let part = match without.part {
            SplatPart::Spans => "spans",
            SplatPart::Cut => "the cut",
        };
        say!(
            "  without {part} (cycle model, the same pixels): {} cycles, {:.3} square sums and {:.3} exponentials",
            without.cycles,
            without.square_sums_a_counted_pair,
            without.exponentials_a_counted_pair
        );
    }
}

fn stored(paper: &PaperMotivation) -> String {
    let [least, most] = paper.model_bytes;
    format!("{} MB to {} GB", least / 1_000_000, most / 1_000_000_000)
}

fn misses(paper: &PaperMotivation) -> String {
    let [average, most] = [paper.miss_rate_average, paper.miss_rate_most].map(percent);
    format!("{average} on average, {most} at most")
}

/// Traffic with the whole frame as one ray group.
fn frame(found: &Characterisation) -> Option<&Traffic> {
    found.traffic.iter().rfind(|t| t.halo != Some(Halo::Split))
}

fn streams(found: &Characterisation) {
    if found.traffic.is_empty() {
        return;
    }
    say!(
        "MVoxel order, MB per frame of each stream (counted); scattered: non-streaming part of \
         the MVoxels in"
    );
    let mut table = tables::lined(
        2,
        [
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
        ],
    );
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
    say!("{}", tables::fitted(&table, &[]));
    if found.traffic.iter().all(|t| t.halo.is_none()) {
        say!("no halo: MVoxels here share no vertices");
    } else {
        say!("both kinds of halo are counted, whichever the description names");
    }
}

/// Shares of the stages in per cent; gathering and computation of splats are one stage.
fn stages(stages: &Stages) -> String {
    let percent = |share: f64| format!("{:.0}", 100.0 * share);
    let shares = stages.shares().map(|s| s.map_or("-".to_owned(), percent));
    format!("{} %", shares.join(", "))
}

/// Our figure, followed by the paper's.
fn beside(ours: String, paper: &str) -> String {
    match paper {
        "" => ours,
        paper => format!("{ours} ({paper})"),
    }
}

/// One row a scene, with the paper's figures in brackets.
pub(super) fn side_by_side(scenes: &[Characterisation]) {
    let mut table = tables::lined(
        2,
        [
            "scene",
            "algorithm",
            "vectors of the model",
            "miss rate",
            "non-streaming",
            "conflict rate, 16 rays, 16 banks",
            "64 rays, 16 banks",
            "points per MVoxel, before and after merging",
            "indexing, gathering, computation",
            "pixel order, MB",
            "MVoxel order, MB",
            "non-streaming share",
        ],
    );
    for found in scenes {
        let paper = &found.paper;
        let conflicts = |rays: usize| {
            let point = found.banks.iter().find(|p| p.rays == rays && p.banks == 16);
            point.map_or_else(String::new, |p| tenths(p.conflict_rate))
        };
        let wide = paper.conflicts_64_on_16.map(percent).unwrap_or_default();
        let merged = found.merging.map(|m| {
            let ours = format!("{:.1}, {:.1}", m.points_before, m.points_after);
            let points = paper.points.map(|[a, b]| format!("{a:.1}, {b:.1}"));
            beside(ours, &points.unwrap_or_default())
        });
        let frame = frame(found);
        let scattered = frame.filter(|t| t.scattered > 0).map(|t| {
            let share = tenths(t.scattered as f64 / t.streams.total().max(1) as f64);
            let paper = paper.scattered.map(percent);
            beside(share, &paper.unwrap_or_default())
        });
        table.add_row([
            found.scene.clone(),
            format!(
                "{}{}",
                found.algorithm,
                if found.full_size { ", full size" } else { "" }
            ),
            beside(HumanBytes(found.model_bytes).to_string(), &stored(paper)),
            beside(
                tenths(found.miss_rate),
                &format!("{} on average", percent(paper.miss_rate_average)),
            ),
            beside(
                tenths(found.not_streaming_rate),
                &format!("over {}", percent(paper.not_streaming_above)),
            ),
            beside(conflicts(16), &conflicts_16(paper)),
            beside(conflicts(64), &wide),
            merged.unwrap_or_default(),
            stages(&found.stages),
            megabytes(found.memory.bytes),
            frame.map_or_else(String::new, |t| megabytes(t.streams.total())),
            scattered.unwrap_or_default(),
        ]);
    }
    say!("{}", tables::fitted(&table, &[]));
    say!(
        "the paper's figures are in brackets; over its algorithms, the miss rate is 92 % at most, and gathering takes over 64 % of a mobile GPU's time on average\n\
         stages are measured in the float renderer, all other figures are counted; misses are those of a 2 MB buffer with oracle replacement; MVoxel order has the frame as one ray group, and shared halos"
    );
}
