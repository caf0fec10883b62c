#![allow(clippy::unwrap_used, clippy::panic)]
use potamoi_formats::config::Config;
use potamoi_formats::rit::{RitEntry, Vertices};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;
use crate::bank_rounds::rounds;
use crate::gathering_unit::{GatherInputs, GatherOutputs};
use crate::work::Mvoxel;
use crate::{GatherCycles, GatherModel, Plan, Source, Stalls, StreamStalls, gather_cycles};

fn config(text: &str) -> Config {
    let text = format!("[gu]\norganisation = \"feature-major\"\n{text}");
    Config::from_toml(&text, "test").unwrap_or_else(|e| panic!("{text}: {e}"))
}

#[test]
fn work_of_another_shape_or_organisation_is_refused() {
    let own = config("banks = 4\nlanes = 4\nports = 1");
    let mvoxels = [Mvoxel {
        entries: 6,
        rows: 9,
    }];
    let run = GatherRun {
        vertices: Vertices::Two,
        segments: 1,
        mvoxels: &mvoxels,
    };
    let one = [vec![[1; 8]; 1]];
    let two = [vec![[1; 8]; 2]];
    let of = |channels, rounds| LaneRun {
        run,
        channels,
        rounds,
    };
    assert_eq!(of(4, &two[..]).check(&own), Ok(()));
    assert!(matches!(
        of(4, &one[..]).check(&own),
        Err(WorkError::Rounds { .. })
    ));
    assert!(matches!(
        of(5, &two[..]).check(&own),
        Err(WorkError::Rounds { .. })
    ));
    let paper = Config::paper();
    let refused = |e: Option<WorkError>| matches!(e, Some(WorkError::Organisation { .. }));
    assert!(refused(of(4, &two[..]).check(&paper).err()));
    assert!(refused(gather_cycles(&own, &run).err()));
    assert!(refused(GatherModel::new(&own, Vertices::Two, 1).err()));
}

/// Runs the stepwise model; returns its cycles in the closed form's terms.
fn stepped(config: &Config, work: &LaneRun<'_>, stalls: &Stalls, seed: u64) -> GatherCycles {
    let mut plan = Plan::new(seed, stalls).unwrap();
    let mut model = FeatureMajorModel::new(config, work).unwrap();
    let mut rit = Source::new(work.run.rit_beats(config));
    let mut mft = Source::new(work.mft_pieces(config));
    let mut out = GatherCycles::default();
    let (mut first, mut counters) = (None, Default::default());
    for cycle in 0.. {
        if rit.is_done() && mft.is_done() && model.is_idle() {
            break;
        }
        assert!(cycle < 2_000_000, "a deadlock");
        let willing = plan.step();
        let inputs = GatherInputs {
            rit: rit.offer(willing.rit).map(|piece| piece.beat),
            mft: mft.offer(willing.mft).map(|piece| piece.last),
            feat_ready: willing.sink,
        };
        let shown: GatherOutputs = model.step(&inputs);
        if inputs.rit.is_some() && shown.rit_ready {
            rit.accepted();
        }
        if inputs.mft.is_some() && shown.mft_ready {
            mft.accepted();
        }
        if shown.issue.is_some() {
            first.get_or_insert(cycle);
        }
        if shown.feat.is_some() && inputs.feat_ready {
            out.elapsed = cycle + 1;
        }
        counters = shown.counters;
    }
    out.fill = first.unwrap_or(0);
    out.busy = counters.busy;
    out.stall_mft = counters.stall_mft;
    out.stall_rit = counters.stall_rit;
    out.stall_bank = counters.stall_bank;
    if *stalls == Stalls::NONE {
        assert_eq!(counters.stall_fifo, 0);
    }
    out
}

/// Random sizes: lanes loaded slower and faster than they are gathered, MVoxels of one entry and of
/// many halves, several segments, few and many rows.
#[test]
fn the_closed_form_is_the_stepwise_model() {
    let (mut rit, mut mft, mut bank) = (0, 0, 0);
    for seed in 0..400u64 {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut pick = |from: &[u32]| from[random.random_range(0..from.len())];
        let (banks, ports) = (pick(&[2, 4, 16]), pick(&[1, 2, 4]));
        let config = config(&format!(
            "banks = {banks}\nports = {ports}\nlanes = {}\nfifo_depth = {}\nsegments = 4\n\
             [rit]\nentries = {}\n[mvoxel]\nrows = 64",
            ports * pick(&[1, 2, 4, 16]),
            pick(&[5, 8]),
            ports * pick(&[1, 2, 8]),
        ));
        let vertices = Vertices::ALL[pick(&[0, 1, 2, 3]) as usize];
        let channels = random.random_range(1..=(3 * banks).min(20)) as usize;
        let most = random.random_range(1..200);
        let (mut mvoxels, mut all) = (vec![], vec![]);
        for _ in 0..random.random_range(1..10) {
            let entries: Vec<RitEntry> = (0..random.random_range(1..=most))
                .map(|_| RitEntry {
                    slot: 0,
                    rows: std::array::from_fn(|_| random.random_range(0..64)),
                    weights: [0; 8],
                })
                .collect();
            mvoxels.push(Mvoxel {
                entries: entries.len() as u32,
                rows: random.random_range(1..=64),
            });
            all.push(rounds(&config, vertices, &entries));
        }
        let work = LaneRun {
            run: GatherRun {
                vertices,
                segments: config.segments(channels) as u32,
                mvoxels: &mvoxels,
            },
            channels,
            rounds: &all,
        };
        let closed = feature_major_cycles(&config, &work).unwrap();
        let found = stepped(&config, &work, &Stalls::NONE, seed);
        assert_eq!(found, closed, "seed {seed}: {config:?} {work:?}");
        // Stalls from outside change neither steps nor rounds.
        let held = StreamStalls {
            per_mille: 300,
            burst: 3,
        };
        let stalls = Stalls {
            rit: held,
            mft: held,
            sink: held,
        };
        let late = stepped(&config, &work, &stalls, seed);
        assert_eq!(
            (late.busy, late.stall_bank),
            (closed.busy, closed.stall_bank)
        );
        rit += u64::from(closed.stall_rit > 0);
        mft += u64::from(closed.stall_mft > 0);
        bank += u64::from(closed.stall_bank > 0);
    }
    assert!(rit > 50 && mft > 50 && bank > 100, "{rit} {mft} {bank}");
}

/// With enough channels the cycles are channels times rounds, without a bubble.
#[test]
fn no_bubble_between_steps_channels_lanes_or_mvoxels() {
    for (banks, lanes, ports, vertices) in [
        (16, 16, 2, Vertices::Eight),
        (16, 64, 4, Vertices::Eight),
        (16, 16, 1, Vertices::Eight),
        (8, 8, 1, Vertices::Two),
    ] {
        let config = config(&format!(
            "banks = {banks}\nlanes = {lanes}\nports = {ports}"
        ));
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let (mut mvoxels, mut all) = (vec![], vec![]);
        for n in [lanes, 10 * lanes, 3 * lanes, 1000 / lanes * lanes] {
            let entries: Vec<RitEntry> = (0..n)
                .map(|_| RitEntry {
                    slot: 0,
                    rows: std::array::from_fn(|_| random.random_range(0..512)),
                    weights: [0; 8],
                })
                .collect();
            mvoxels.push(Mvoxel {
                entries: n,
                rows: 2 * banks,
            });
            all.push(rounds(&config, vertices, &entries));
        }
        let work = LaneRun {
            run: GatherRun {
                vertices,
                segments: 1,
                mvoxels: &mvoxels,
            },
            channels: banks as usize,
            rounds: &all,
        };
        let found = feature_major_cycles(&config, &work).unwrap();
        let sum: u64 = all.iter().flatten().flatten().map(|&r| u64::from(r)).sum();
        assert_eq!(found.issue_span(), u64::from(banks) * sum);
        assert_eq!((found.stall_mft, found.stall_rit), (0, 0));
    }
}
