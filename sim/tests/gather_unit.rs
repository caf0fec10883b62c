//! The Verilated gathering unit against plain arithmetic, bit by bit, and
//! against the cycles that its documentation promises.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use potamoi_formats::config::Config;
use potamoi_formats::fixed::{Rounding, round_shift};
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_golden::units::GatherTask;
use potamoi_sim::rtl::{GatherRun, GatherUnit, Stalls};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Weights of `vertices` that sum to exactly 1: cuts of the unit interval.
fn weights(random: &mut Pcg64Mcg, bits: u32, vertices: Vertices) -> [u16; 8] {
    let one = 1u32 << bits;
    let mut cuts: Vec<u32> = (1..vertices.count())
        .map(|_| random.random_range(0..=one))
        .collect();
    cuts.push(one);
    cuts.sort_unstable();
    let mut out = [0; 8];
    let mut low = 0;
    for (w, cut) in out.iter_mut().zip(cuts) {
        *w = (cut - low) as u16;
        low = cut;
    }
    out
}

fn task(
    random: &mut Pcg64Mcg,
    config: &Config,
    vertices: Vertices,
    channels: usize,
    rows: usize,
    entries: usize,
) -> GatherTask {
    let top = 1i32 << (config.gu.feature_bits - 1);
    let rows_data = (0..rows * channels)
        .map(|_| match random.random_range(0..10) {
            0 => (top - 1) as i16,
            1 => (-top) as i16,
            _ => random.random_range(-top..top) as i16,
        })
        .collect();
    let entries = (0..entries)
        .map(|_| {
            let mut entry = RitEntry {
                slot: random.random_range(0..=0xffff),
                rows: [0; 8],
                weights: [0; 8],
            };
            for row in entry.rows.iter_mut().take(vertices.count()) {
                *row = random.random_range(0..rows) as u16;
            }
            if vertices.is_structured() {
                entry.weights = weights(random, config.gu.weight_bits, vertices);
            }
            entry
        })
        .collect();
    GatherTask {
        vertices,
        channels,
        rows: rows_data,
        entries,
    }
}

/// What the unit must give, in i128 arithmetic.
fn expected(config: &Config, task: &GatherTask) -> Vec<i16> {
    let top = 1i128 << (config.gu.feature_bits - 1);
    let mut out = vec![];
    for entry in &task.entries {
        for c in 0..task.channels {
            let feature =
                |v: usize| i128::from(task.rows[entry.rows[v] as usize * task.channels + c]);
            let value = if task.vertices.is_structured() {
                let sum: i128 = (0..task.vertices.count())
                    .map(|v| feature(v) * i128::from(entry.weights[v]))
                    .sum();
                round_shift(sum, config.gu.weight_bits, Rounding::HalfEven).clamp(-top, top - 1)
            } else {
                feature(0)
            };
            out.push(value as i16);
        }
    }
    out
}

fn check(config: &Config, unit: &GatherUnit, tasks: &[GatherTask], stalls: Stalls) -> GatherRun {
    let run = unit
        .run(tasks, stalls)
        .unwrap_or_else(|e| panic!("{stalls:?}: {e}"));
    let features = run.features(config, tasks).unwrap();
    let wanted: Vec<i16> = tasks.iter().flat_map(|t| expected(config, t)).collect();
    if let Some(at) = features.iter().zip(&wanted).position(|(a, b)| a != b) {
        panic!(
            "{stalls:?}: feature {at} is {}, expected {}",
            features[at], wanted[at]
        );
    }
    assert_eq!(features.len(), wanted.len());
    let mut slots = vec![];
    let segments = config.segments(tasks[0].channels).max(1);
    for t in tasks {
        for _ in 0..segments {
            slots.extend(t.entries.iter().map(|e| e.slot & 0xffff));
        }
    }
    let found: Vec<u32> = run
        .beats
        .iter()
        .flat_map(|b| b.entries.iter().map(|e| e.0))
        .collect();
    assert_eq!(found, slots, "{stalls:?}");
    assert_eq!(run.busy, run.issues, "{stalls:?}: issuing cycles");
    assert_eq!(run.entries, slots.len() as u64);
    assert_eq!(run.errors, 0, "{stalls:?}: flags");
    run
}

/// MVoxels of which each loads no more rows than its predecessor has cycles.
fn hidden_loads(
    config: &Config,
    random: &mut Pcg64Mcg,
    vertices: Vertices,
    channels: usize,
    sizes: &[usize],
) -> Vec<GatherTask> {
    let mut cycles = usize::MAX;
    sizes
        .iter()
        .map(|entries| {
            let own = entries.div_ceil(config.gu.ports as usize) * vertices.count();
            // With segments an MVoxel is its own predecessor too.
            let several = channels > config.gu.banks as usize;
            let most = (config.mvoxel.rows as usize).min(cycles).min(40);
            let most = if several { most.min(own) } else { most };
            let rows = random.random_range(1..=most);
            cycles = own;
            task(random, config, vertices, channels, rows, *entries)
        })
        .collect()
}

/// Not one cycle more than sum ceil(entries / M) V, for the paper's shapes and
/// beyond: halves of every fill, MVoxels of a single entry, several segments.
#[test]
fn no_bubble_between_entries_halves_or_mvoxels() {
    for (banks, ports) in [(32, 2), (16, 1), (8, 4)] {
        let config =
            Config::from_toml(&format!("[gu]\nbanks = {banks}\nports = {ports}"), "test").unwrap();
        let unit = GatherUnit::build(&config).unwrap();
        for vertices in [
            Vertices::Eight,
            Vertices::Four,
            Vertices::Two,
            Vertices::One,
        ] {
            for segments in [1, 3] {
                let seed = 77 + vertices.count() as u64 + 10 * segments as u64;
                let mut random = Pcg64Mcg::seed_from_u64(seed);
                let half = config.rit_entries(vertices) as usize;
                let mut sizes = vec![
                    half,
                    half + 1,
                    2 * half,
                    2 * half - 1,
                    3 * half + 5,
                    1,
                    1,
                    1,
                    2,
                    3,
                    half - 1,
                ];
                sizes.extend((0..20).map(|_| random.random_range(1..half / 2)));
                sizes.extend([1; 9]);
                let channels = banks * segments - usize::from(segments > 1);
                let tasks = hidden_loads(&config, &mut random, vertices, channels, &sizes);
                let run = check(&config, &unit, &tasks, Stalls::none());
                let label = format!(
                    "B {banks} M {ports} V {} segments {segments} seed {seed}",
                    vertices.count()
                );
                assert_eq!(run.stalls, [0, 0, 0], "{label}");
            }
        }
    }
}

#[test]
fn random_stalls_change_no_bit_and_every_cycle_has_one_cause() {
    let config = Config::from_toml(
        "[gu]\nbanks = 4\nports = 3\n[rit]\nentries = 6\n[mvoxel]\nrows = 21",
        "test",
    )
    .unwrap();
    let unit = GatherUnit::build(&config).unwrap();
    for seed in 0..40u64 {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let vertices = Vertices::ALL[seed as usize % 4];
        let channels = random.random_range(1..=12);
        let tasks: Vec<_> = (0..12)
            .map(|_| {
                let (rows, entries) = (random.random_range(1..=21), random.random_range(1..=50));
                task(&mut random, &config, vertices, channels, rows, entries)
            })
            .collect();
        let stalls = Stalls {
            sources: [random.random_range(0..95), random.random_range(0..95)],
            sink: random.random_range(0..95),
            seed,
        };
        let run = check(&config, &unit, &tasks, stalls);
        // Latency and first fill lie outside what is counted.
        let counted = run.busy + run.stalls.iter().sum::<u64>();
        assert!(
            counted < run.cycles,
            "seed {seed}: {counted} of {}",
            run.cycles
        );
    }
}

#[test]
fn narrow_and_untrusted_formats_agree() {
    for text in [
        "[gu]\nbanks = 3\nports = 1\nfeature_bits = 8\nweight_bits = 4",
        "[gu]\nbanks = 2\nports = 2\nfeature_bits = 12\nweight_bits = 9\nweights = \"any\"",
        "[gu]\nbanks = 1\nports = 8\nmodes = \"structured\"\nvertices = [4]\n[mvoxel]\nrows = 2",
        "[gu]\nbanks = 5\nports = 2\nmodes = \"unstructured\"",
    ] {
        let config = Config::from_toml(text, "test").unwrap();
        let unit = GatherUnit::build(&config).unwrap();
        for vertices in config.supported_vertices() {
            let mut random = Pcg64Mcg::seed_from_u64(5);
            let rows = config.mvoxel.rows.min(30) as usize;
            let tasks: Vec<_> = (1..9)
                .map(|n| {
                    task(
                        &mut random,
                        &config,
                        vertices,
                        config.gu.banks as usize,
                        rows,
                        7 * n,
                    )
                })
                .collect();
            check(
                &config,
                &unit,
                &tasks,
                Stalls {
                    sources: [30, 30],
                    sink: 30,
                    seed: 1,
                },
            );
        }
    }
}
