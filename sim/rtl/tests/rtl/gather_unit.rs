//! The Verilated gathering unit against plain arithmetic, bit by bit, and
//! against the cycles that its documentation promises.
use potamoi_cycles::Stalls;
use potamoi_formats::config::Config;
use potamoi_formats::rit::Vertices;
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::{FLAG_ROW, FLAG_SUM, FLAG_WEIGHT, ReferenceGatheringUnit};
use potamoi_rtl::{Check, EngineKind, GatherTotals, GatherUnit};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::gather_common::{expected, held_up, task};

/// The command that runs these tests again.
const AGAIN: &str = "cargo test -p potamoi-rtl --test rtl gather_unit";

/// Every bit against plain arithmetic, every cycle against the cycle model.
fn check(
    config: &Config,
    unit: &GatherUnit,
    tasks: &[GatherTask],
    stalls: Stalls,
    seed: u64,
) -> GatherTotals {
    let wanted: Vec<i16> = tasks.iter().flat_map(|t| expected(config, t)).collect();
    let conditions = Check {
        stalls,
        seed,
        flags: 0,
        progress: &mut |_| {},
    };
    let totals = unit
        .check(config, tasks, &wanted, conditions)
        .unwrap_or_else(|e| panic!("seed {seed}, {stalls:?}: {e}\nagain: {AGAIN}"));
    let groups = |t: &GatherTask| t.entries.len().div_ceil(config.gu.ports as usize);
    let segments = config.segments(tasks[0].channels).max(1);
    let issues: usize = tasks.iter().map(|t| groups(t) * t.vertices.count()).sum();
    let entries: usize = tasks.iter().map(|t| t.entries.len()).sum();
    assert_eq!(totals.busy, (issues * segments) as u64, "issuing cycles");
    assert_eq!(totals.entries, (entries * segments) as u64);
    totals
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
                while sizes.iter().sum::<usize>() < 10_000 {
                    sizes.push(random.random_range(half / 4..2 * half));
                }
                let channels = banks * segments - usize::from(segments > 1);
                let tasks = hidden_loads(&config, &mut random, vertices, channels, &sizes);
                let partly = sizes.iter().filter(|n| **n % half != 0).count();
                assert!(tasks.len() >= 20 && partly >= 20);
                let run = check(&config, &unit, &tasks, Stalls::NONE, seed);
                let label = format!(
                    "B {banks} M {ports} V {} segments {segments} seed {seed}",
                    vertices.count()
                );
                assert_eq!(run.stalls, [0, 0, 0], "{label}");
                assert_eq!(run.issue_span(), run.busy, "{label}");
            }
        }
    }
}

/// MVoxels whose rows take longer to load than their predecessor takes: the
/// stall is what double buffering says, and no more.
#[test]
fn larger_mvoxels_stall_exactly_as_predicted() {
    for (banks, ports) in [(32, 2), (16, 1), (8, 4)] {
        let config =
            Config::from_toml(&format!("[gu]\nbanks = {banks}\nports = {ports}"), "test").unwrap();
        let unit = GatherUnit::build(&config).unwrap();
        for (vertices, segments) in [
            (Vertices::Eight, 1),
            (Vertices::Four, 2),
            (Vertices::One, 1),
            (Vertices::One, 3),
        ] {
            let seed = 5 + vertices.count() as u64 + segments as u64;
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            let tasks: Vec<_> = (0..25)
                .map(|_| {
                    let rows = random.random_range(100..=512);
                    let entries = random.random_range(1..200);
                    task(
                        &mut random,
                        &config,
                        vertices,
                        banks * segments,
                        rows,
                        entries,
                    )
                })
                .collect();
            let run = check(&config, &unit, &tasks, Stalls::NONE, seed);
            // A pass takes the longer of its own issue and the next pass's load.
            let passes: Vec<(u64, u64)> = tasks
                .iter()
                .flat_map(|t| {
                    let groups = t.entries.len().div_ceil(ports);
                    let issue = (groups * vertices.count()) as u64;
                    let rows = (t.rows.len() / t.channels) as u64;
                    std::iter::repeat_n((issue, rows), segments)
                })
                .collect();
            let overlapped: u64 = passes.windows(2).map(|w| w[0].0.max(w[1].1)).sum();
            let span = overlapped + passes.last().unwrap().0;
            assert_eq!(
                run.issue_span(),
                span,
                "B {banks} M {ports} {vertices:?} {segments}"
            );
            assert_eq!(run.stalls, [0, span - run.busy, 0]);
            assert!(run.stalls[1] > 100, "{run:?}");
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
        let run = check(&config, &unit, &tasks, held_up(&mut random), seed);
        // Latency and first fill lie outside what is counted.
        let counted = run.issue_span();
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
            let stalls = held_up(&mut random);
            check(&config, &unit, &tasks, stalls, 1);
        }
    }
}

/// Rows that were not loaded, weights above bit W, weights that sum to anything:
/// the features that the documentation promises, and the flags.
#[test]
fn broken_promises_of_entries_are_flagged_and_the_rest_stays_right() {
    for (trust, weight_bits) in [("trusted", 9), ("trusted", 15), ("any", 9), ("any", 15)] {
        let text = format!(
            "[gu]\nbanks = 2\nports = 2\nfeature_bits = 10\nweights = \"{trust}\"\n\
             weight_bits = {weight_bits}\n[mvoxel]\nrows = 16"
        );
        let config = Config::from_toml(&text, "test").unwrap();
        let unit = GatherUnit::build(&config).unwrap();
        let twin = ReferenceGatheringUnit::new(&config);
        let mut seen = 0;
        for seed in 0..12 {
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            let mut task = task(&mut random, &config, Vertices::Eight, 2, 16, 40);
            for entry in &mut task.entries {
                for v in 0..8 {
                    match random.random_range(0..20) {
                        0 => entry.rows[v] = random.random(),
                        1 if seed % 3 == 1 => entry.weights[v] = random.random(),
                        // The largest sums of either sign.
                        2 if trust == "any" => entry.weights[v] = 1 << weight_bits,
                        _ => {}
                    }
                }
            }
            let mut wanted = vec![];
            let flags = twin.gather(&task, &mut wanted).unwrap();
            seen |= flags;
            let conditions = Check {
                stalls: held_up(&mut random),
                seed,
                flags: flags.into(),
                progress: &mut |_| {},
            };
            unit.check(&config, &[task], &wanted, conditions)
                .unwrap_or_else(|e| {
                    panic!("{trust} {weight_bits}, seed {seed}: {e}\nagain: {AGAIN}")
                });
        }
        let sum = if trust == "trusted" { FLAG_SUM } else { 0 };
        let high = if weight_bits < 15 { FLAG_WEIGHT } else { 0 };
        assert_eq!(seen, FLAG_ROW | high | sum, "{trust} {weight_bits}");
    }
}

/// Units of any size that the rules allow, on the interpreter: every bit and
/// every cycle under random stalls.
#[test]
fn units_of_any_size_keep_to_their_cycles() {
    for seed in 0..40u64 {
        let mut random = Pcg64Mcg::seed_from_u64(900 + seed);
        let mut pick = |from: &[u32]| from[random.random_range(0..from.len())];
        let modes = ["both", "structured", "unstructured"][pick(&[0, 0, 1, 2]) as usize];
        let ports = pick(&[1, 2, 3, 5, 8]);
        let text = format!(
            "[gu]\nbanks = {}\nports = {ports}\nfeature_bits = {}\nweight_bits = {}\n\
             fifo_depth = {}\nsegments = 4\nweights = \"{}\"\nmodes = \"{}\"\ncounter_bits = {}\n\
             [rit]\nentries = {}\nslot_bits = {}\n[mvoxel]\nrows = {}",
            pick(&[1, 2, 3, 5, 17, 64]),
            pick(&[8, 9, 12, 16]),
            pick(&[4, 7, 12, 15]),
            pick(&[4, 5, 8, 13]),
            ["trusted", "any"][pick(&[0, 1]) as usize],
            modes,
            pick(&[24, 32]),
            ports * pick(&[2, 4, 8]),
            if modes == "structured" {
                pick(&[16, 32])
            } else {
                16
            },
            pick(&[8, 21, 64]),
        );
        let config = Config::from_toml(&text, "test").unwrap_or_else(|e| panic!("{seed}: {e}"));
        let unit = GatherUnit::on(EngineKind::Interpreter, &config).unwrap();
        let built = config.supported_vertices();
        let vertices = built[random.random_range(0..built.len())];
        let channels = random.random_range(1..=(4 * config.gu.banks).min(20)) as usize;
        let tasks: Vec<_> = (0..6)
            .map(|_| {
                let rows = random.random_range(1..=config.mvoxel.rows as usize);
                let entries = random.random_range(1..30);
                task(&mut random, &config, vertices, channels, rows, entries)
            })
            .collect();
        let stalls = held_up(&mut random);
        check(&config, &unit, &tasks, stalls, seed);
    }
}
