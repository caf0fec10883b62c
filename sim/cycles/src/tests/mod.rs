//! The gathering unit's models against consequences of the rules and against each other.
#![allow(clippy::unwrap_used, clippy::panic)]

mod any;

use potamoi_formats::config::Config;
use potamoi_formats::rit::Vertices;
use rand::{RngCore, SeedableRng};
use rand_pcg::Pcg32;

use super::closed_form::{overlapped_cycles, rit_keeps_up};
use super::gathering_unit::{Cause, Counters, GatherInputs, GatherModel, RitBeat};
use super::*;

fn config(text: &str) -> Config {
    Config::from_toml(text, "test").unwrap()
}

fn unit(banks: u32, ports: u32) -> Config {
    config(&format!("[gu]\nbanks = {banks}\nports = {ports}"))
}

fn ready(config: &Config, run: &GatherRun<'_>) -> CycleLog {
    run_gather(config, run, &Stalls::NONE, 0).unwrap()
}

/// MVoxels of very different sizes, most halves partly filled, each loading no more rows than the
/// pass before it has cycles.
fn hidden_loads(config: &Config, vertices: Vertices, segments: u32, least: u32) -> Vec<Mvoxel> {
    let mut rng = Pcg32::seed_from_u64(u64::from(vertices.log2()) * 100 + u64::from(segments));
    let half = config.rit_entries(vertices);
    let mut list: Vec<Mvoxel> = Vec::new();
    let mut total = 0;
    while total < least || list.len() < 24 {
        let entries = match list.len() % 8 {
            0 | 1 => 1,
            2 => 1 + rng.next_u32() % (2 * config.gu.ports),
            3 => 2 * half,
            4 => half + 1 + rng.next_u32() % half,
            5 => 2 * half + 1 + rng.next_u32() % (2 * half),
            6 => half,
            _ => 1 + rng.next_u32() % half,
        };
        let mut mvoxel = Mvoxel {
            entries,
            rows: config.mvoxel.rows,
        };
        let one = |m: Mvoxel| {
            let run = GatherRun {
                vertices,
                segments: 1,
                mvoxels: &[],
            };
            run.issue_cycles(config, m) as u32
        };
        if let Some(&before) = list.last() {
            mvoxel.rows = mvoxel.rows.min(one(before));
        }
        if segments > 1 {
            mvoxel.rows = mvoxel.rows.min(one(mvoxel));
        }
        total += entries;
        list.push(mvoxel);
    }
    list
}

#[test]
fn no_bubble_between_entries_halves_and_mvoxels() {
    for (banks, ports) in [(32, 2), (16, 1), (8, 4)] {
        let config = unit(banks, ports);
        for vertices in Vertices::ALL {
            for segments in [1, 3] {
                let mvoxels = hidden_loads(&config, vertices, segments, 10_001);
                let run = GatherRun {
                    vertices,
                    segments,
                    mvoxels: &mvoxels,
                };
                let entries: u64 = mvoxels.iter().map(|m| u64::from(m.entries)).sum();
                assert!(entries > 10_000 && mvoxels.len() >= 20);
                let log = ready(&config, &run);
                let expected: u64 = mvoxels
                    .iter()
                    .map(|m| u64::from(m.entries.div_ceil(ports)) * vertices.count() as u64)
                    .sum::<u64>()
                    * u64::from(segments);
                let what = format!("B {banks} M {ports} V {vertices:?} S {segments}");
                assert_eq!(
                    log.counters,
                    Counters {
                        busy: expected,
                        entries: entries * u64::from(segments),
                        ..Counters::default()
                    },
                    "{what}"
                );
                let span = log.last_issue.unwrap() - log.first_issue.unwrap() + 1;
                assert_eq!(span, expected, "{what}");
            }
        }
    }
}

#[test]
fn the_smallest_buffer_has_no_bubble_either() {
    for ports in 1..=8 {
        let config = config(&format!(
            "[gu]\nports = {ports}\nfifo_depth = 4\n[rit]\nentries = {ports}"
        ));
        for vertices in Vertices::ALL {
            let mvoxels = hidden_loads(&config, vertices, 2, 500);
            let run = GatherRun {
                vertices,
                segments: 2,
                mvoxels: &mvoxels,
            };
            let log = ready(&config, &run);
            assert_eq!(
                log.counters.cycles(),
                run.busy(&config),
                "M {ports} {vertices:?}"
            );
        }
    }
}

#[test]
fn first_fill_and_latency_are_three_cycles() {
    let mvoxels = [Mvoxel {
        entries: 1,
        rows: 1,
    }];
    for (ports, vertices, beats) in [
        (2, Vertices::One, 1),
        (8, Vertices::Eight, 1),
        (2, Vertices::Eight, 3),
    ] {
        let run = GatherRun {
            vertices,
            segments: 1,
            mvoxels: &mvoxels,
        };
        let log = ready(&unit(32, ports), &run);
        assert_eq!(log.first_beat, Some(0));
        assert_eq!(log.first_issue, Some(beats + 2));
        assert_eq!(log.groups[0].accepted, log.last_issue.unwrap() + 3);
    }
}

#[test]
fn a_load_longer_than_the_pass_before_stalls_by_the_difference() {
    let config = unit(32, 2);
    for (rows, stall) in [(400, 0), (401, 1), (512, 112)] {
        let mvoxels = [
            Mvoxel {
                entries: 100,
                rows: 27,
            },
            Mvoxel { entries: 7, rows },
        ];
        let run = GatherRun {
            vertices: Vertices::Eight,
            segments: 1,
            mvoxels: &mvoxels,
        };
        let log = ready(&config, &run);
        let c = log.counters;
        let counted = (c.busy, c.stall_mft, c.stall_rit);
        assert_eq!(counted, (432, stall, 0), "stepwise, {rows} rows");
        let cycles = overlapped_cycles(&config, &run);
        assert_eq!(cycles, 432 + stall, "closed form, {rows} rows");
    }
}

#[test]
fn a_narrow_rit_stream_stalls_single_ids_by_its_rate() {
    // 4 bytes a cycle, 8 wanted.
    let config = config("[rit]\nstream_bits = 32");
    let mvoxels = [Mvoxel {
        entries: 1000,
        rows: 2,
    }];
    let run = GatherRun {
        vertices: Vertices::One,
        segments: 1,
        mvoxels: &mvoxels,
    };
    assert!(!rit_keeps_up(&config, &run));
    let c = ready(&config, &run).counters;
    assert_eq!((c.busy, c.stall_rit, c.stall_mft), (500, 499, 0));
}

#[test]
fn a_blocked_sink_stalls_after_the_fifo_is_full_and_says_so() {
    let config = unit(32, 2);
    let mut model = GatherModel::new(&config, Vertices::One, 1).unwrap();
    let mut inputs = GatherInputs {
        rit: Some(RitBeat {
            halfwords: 8,
            last: false,
            again: false,
        }),
        mft: Some(true),
        feat_ready: false,
    };
    let (mut issued, mut fifo) = (0, 0);
    for _ in 0..100 {
        let out = model.step(&inputs);
        issued += u64::from(out.issue.is_some());
        fifo += u64::from(out.stall == Some(Cause::Fifo));
    }
    // Issue starts in cycle 3; the stalls show with the next issue only.
    assert_eq!((issued, fifo), (4, 93));
    assert_eq!(model.counters().stall_fifo, 0);
    inputs.feat_ready = true;
    // Accepted in this cycle, counted from the next.
    assert_eq!(model.step(&inputs).stall, Some(Cause::Fifo));
    assert!(model.step(&inputs).issue.is_some());
    assert_eq!(
        model.counters(),
        Counters {
            busy: 5,
            stall_fifo: 94,
            entries: 10,
            ..Counters::default()
        }
    );
}

#[test]
fn counters_stop_at_their_maximum_and_clear() {
    let config = config("[gu]\ncounter_bits = 16");
    let mvoxels = [Mvoxel {
        entries: 20_000,
        rows: 1,
    }];
    let run = GatherRun {
        vertices: Vertices::Eight,
        segments: 1,
        mvoxels: &mvoxels,
    };
    let c = ready(&config, &run).counters;
    assert_eq!((c.busy, c.entries), (65_535, 20_000));
    let mut model = GatherModel::new(&config, Vertices::Eight, 1).unwrap();
    let mut rit = Source::new(run.rit_beats(&config));
    for _ in 0..100 {
        let inputs = GatherInputs {
            rit: rit.offer(true).map(|p| p.beat),
            mft: Some(true),
            feat_ready: true,
        };
        if model.step(&inputs).rit_ready {
            rit.accepted();
        }
    }
    assert_ne!(model.counters(), Counters::default());
    model.clear();
    assert_eq!(model.counters(), Counters::default());
}

#[test]
fn an_mvoxel_beyond_both_halves_is_streamed_for_every_segment() {
    let config = unit(32, 2);
    let half = config.rit_entries(Vertices::Eight);
    for (entries, times) in [(half, 1), (2 * half, 1), (2 * half + 1, 3)] {
        let mvoxels = [Mvoxel { entries, rows: 8 }];
        let run = GatherRun {
            vertices: Vertices::Eight,
            segments: 3,
            mvoxels: &mvoxels,
        };
        assert_eq!(run.streamed_again(&config, mvoxels[0]), times > 1);
        let log = ready(&config, &run);
        assert_eq!(log.rit_beats, times * u64::from(entries * 48).div_ceil(16));
        assert_eq!(log.counters.entries, 3 * u64::from(entries));
        assert_eq!(log.mft_rows, 24);
    }
}

#[test]
fn work_that_cannot_be_done_is_refused_by_name() {
    let config = unit(32, 2);
    let good = Mvoxel {
        entries: 1,
        rows: 1,
    };
    let bad = |vertices, segments, mvoxel: Mvoxel| {
        let mvoxels = [good, mvoxel];
        let run = GatherRun {
            vertices,
            segments,
            mvoxels: &mvoxels,
        };
        let error = run_gather(&config, &run, &Stalls::NONE, 0).unwrap_err();
        assert_eq!(gather_cycles(&config, &run).unwrap_err(), error);
        error.to_string()
    };
    let v = Vertices::Eight;
    assert!(bad(v, 1, Mvoxel { entries: 0, ..good }).contains("MVoxel 1 has no entries"));
    assert!(bad(v, 1, Mvoxel { rows: 0, ..good }).contains("loads 0 rows"));
    assert!(bad(v, 1, Mvoxel { rows: 513, ..good }).contains("512 of an MFT half (mvoxel.rows)"));
    assert!(bad(v, 0, good).contains("0 segments"));
    assert!(bad(v, 9, good).contains("gu.segments = 8"));
    let mut planes = config.clone();
    planes.gu.vertices = vec![Vertices::Four];
    let error = GatherModel::new(&planes, v, 1).err().unwrap();
    assert!(error.to_string().contains("expected 1, 4"), "{error}");
    planes.gu.ports = 0;
    assert!(matches!(
        GatherModel::new(&planes, v, 1),
        Err(WorkError::Config(_))
    ));
}
