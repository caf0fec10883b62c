//! Jobs of the gathering unit as beats.

use potamoi_cycles::work::RitPiece;
use potamoi_cycles::{BeatWords, GatherInputs, GatherWork, Source, UnitModel};
use potamoi_formats::config::{Config, Organisation};
use potamoi_reference::GatherTask;

use super::beat::Beat;
use super::garbage::Garbage;
use super::gather_edges::Edge;
use super::job::Job;
use crate::RtlError;
use crate::beats::{FeatureBeat, feature_beats};

/// Cycles without a handshake after which a model counts as hanging.
const PATIENCE: u32 = 10_000;

/// The job of tasks that can follow one another. `features` (or sums) are in task and entry order,
/// `flags` those that the tasks raise.
///
/// # Errors
/// Tasks that the unit cannot take.
pub(super) fn job(
    config: &Config,
    tasks: &[GatherTask],
    features: &[i32],
    flags: u64,
    garbage: &mut Garbage,
) -> Result<Job, RtlError> {
    GatherWork::new(config, tasks)?.run().check(config)?;
    edge(
        config,
        &Edge::plain(tasks.to_vec()),
        features,
        flags,
        garbage,
    )
}

/// As [`job`], of tasks that need not keep all promises.
///
/// # Errors
/// Tasks that cannot follow one another.
pub(super) fn edge(
    config: &Config,
    edge: &Edge,
    features: &[i32],
    flags: u64,
    garbage: &mut Garbage,
) -> Result<Job, RtlError> {
    let work = GatherWork::new(config, &edge.tasks)?;
    let table = table(config, &work, edge.null);
    let output = outputs(config, &work, features, &table)?;
    let (cycles, stats) = run(config, &work, &table, output.len(), edge.closed)?;
    let mut job = Job {
        title: title(edge, &work),
        settings: settings(&work),
        inputs: inputs(config, &work, &table, garbage)?,
        output,
        closed: edge.closed,
        cycles,
        stats,
    };
    job.stats.insert("stat_errors", flags);
    Ok(job)
}

fn title(edge: &Edge, work: &GatherWork<'_>) -> String {
    let tasks = match edge.tasks.len() {
        1 => "1 MVoxel".to_owned(),
        tasks => format!("{tasks} MVoxels"),
    };
    let mut title = format!(
        "{tasks} of {} entries, {} vertices, {} channels in {} segments",
        work.entries(),
        work.vertices().count(),
        work.channels(),
        work.segments()
    );
    if !edge.what.is_empty() {
        title += ": ";
        title += edge.what;
    }
    title
}

/// Beats without bytes before every second beat of the RIT stream: more than the entries before keep the
/// unit busy.
const IGNORED: usize = 5;

/// Beats of the RIT stream. If `null`, beats without bytes delay every second beat, and one ends the
/// MVoxels that fill their last beat.
fn table(config: &Config, work: &GatherWork<'_>, null: bool) -> Vec<RitPiece> {
    let full = config.rit_stream_bits() / 16;
    let mut pieces = vec![];
    for mut piece in work.run().rit_beats(config) {
        let ends = null && piece.beat.last && piece.beat.halfwords == full;
        piece.beat.last &= !ends;
        if null && (piece.byte / (2 * u64::from(full))) % 2 == 1 {
            let mut ignored = piece;
            (ignored.beat.halfwords, ignored.beat.last) = (0, false);
            pieces.extend([ignored; IGNORED]);
        }
        pieces.push(piece);
        if ends {
            piece.byte += 2 * u64::from(full);
            piece.beat.halfwords = 0;
            piece.beat.last = true;
            pieces.push(piece);
        }
    }
    pieces
}

/// Counters that gaps do not change. Of lanes that wait for banks, gaps change who waits.
pub(super) fn steady(config: &Config) -> Vec<&'static str> {
    let all = ["stat_entries", "stat_errors", "stat_busy"];
    let lanes = config.organisation().0 == Organisation::FeatureMajor;
    all[..if lanes { 2 } else { 3 }].to_vec()
}

fn settings(work: &GatherWork<'_>) -> Vec<(&'static str, u64)> {
    vec![
        ("cfg_vertices", u64::from(work.vertices().log2())),
        ("cfg_segments", work.segments() as u64),
        ("cfg_two_records", u64::from(work.shares_rows())),
        ("cfg_channels", work.last_channels() as u64),
    ]
}

fn inputs(
    config: &Config,
    work: &GatherWork<'_>,
    table: &[RitPiece],
    garbage: &mut Garbage,
) -> Result<Vec<Vec<Beat>>, RtlError> {
    let mut layout = BeatWords::new(work);
    let (mut rit, mut mft) = (vec![], vec![]);
    for piece in table {
        layout.rit(piece)?;
        let mut data = layout.data.clone();
        garbage.fill(&mut data, &layout.keep, 8);
        rit.push(Beat::from([
            ("tuser", vec![u32::from(piece.beat.again)]),
            ("tlast", vec![u32::from(piece.beat.last)]),
            ("tkeep", layout.keep.clone()),
            ("tdata", data),
        ]));
    }
    for piece in work.mft_pieces(config) {
        layout.mft(&piece);
        mft.push(Beat::from([
            ("tlast", vec![u32::from(piece.last)]),
            ("tkeep", layout.row_keep.clone()),
            ("tdata", layout.row.clone()),
        ]));
    }
    Ok(vec![rit, mft])
}

fn outputs(
    config: &Config,
    work: &GatherWork<'_>,
    features: &[i32],
    table: &[RitPiece],
) -> Result<Vec<Beat>, RtlError> {
    let slot_bits = work.slot_bits();
    let null = |piece: &&RitPiece| piece.beat.last && piece.beat.halfwords == 0;
    let null: Vec<_> = table.iter().filter(null).map(|p| p.mvoxel).collect();
    let beats = feature_beats(config, work.tasks(), features, |task, _| {
        null.contains(&task)
    })?;
    let beat = |beat: FeatureBeat| {
        let mut user = vec![0u32; (slot_bits as usize * work.side()).div_ceil(32)];
        for (port, slot) in beat.slots.into_iter().enumerate() {
            match slot_bits {
                32 => user[port] = slot,
                _ => user[port / 2] |= (slot & 0xffff) << (16 * (port % 2)),
            }
        }
        Beat::from([
            ("tlast", vec![u32::from(beat.last)]),
            ("tkeep", beat.keep),
            ("tuser", user),
            ("tdata", beat.data),
        ])
    };
    Ok(beats.into_iter().map(beat).collect())
}

type Stats = std::collections::BTreeMap<&'static str, u64>;

/// Cycles and counters by the stepwise model, with sources always ready, and a sink that is so after some
/// cycles.
fn run(
    config: &Config,
    work: &GatherWork<'_>,
    table: &[RitPiece],
    beats: usize,
    closed: u32,
) -> Result<(u64, Stats), RtlError> {
    let mut model = UnitModel::new(config, work)?;
    let mut rit = Source::new(table.iter().copied());
    let mut mft = Source::new(work.mft_pieces(config));
    let (mut left, mut cycles, mut quiet) = (beats, 0, 0);
    while left > 0 {
        let inputs = GatherInputs {
            rit: rit.offer(true).map(|piece| piece.beat),
            mft: mft.offer(true).map(|piece| piece.last),
            feat_ready: cycles >= u64::from(closed),
        };
        let outputs = model.step(&inputs);
        let moves = [
            inputs.rit.is_some() && outputs.rit_ready,
            inputs.mft.is_some() && outputs.mft_ready,
            outputs.feat.is_some() && inputs.feat_ready,
        ];
        if moves[0] {
            rit.accepted();
        }
        if moves[1] {
            mft.accepted();
        }
        left -= usize::from(moves[2]);
        cycles += 1;
        quiet = if moves.contains(&true) { 0 } else { quiet + 1 };
        if quiet > PATIENCE {
            return Err(potamoi_cycles::WorkError::Deadlock { cycle: cycles }.into());
        }
    }
    let counters = model.step(&GatherInputs::default()).counters;
    let stats = Stats::from([
        ("stat_busy", counters.busy),
        ("stat_stall_fifo", counters.stall_fifo),
        ("stat_stall_mft", counters.stall_mft),
        ("stat_stall_rit", counters.stall_rit),
        ("stat_stall_bank", counters.stall_bank),
        ("stat_entries", counters.entries),
    ]);
    Ok((cycles, stats))
}
