//! The feature-major unit against plain arithmetic, bit by bit, and against its
//! cycle model, cycle by cycle.
use potamoi_cycles::{GatherWork, Stalls};
use potamoi_formats::config::Config;
use potamoi_formats::rit::Vertices;
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::{FLAG_ROW, FLAG_SUM, FLAG_WEIGHT, ReferenceGatheringUnit};
use potamoi_rtl::{Check, EngineKind, GatherTotals, GatherUnit};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::gather_common::{expected, held_up, task};

const AGAIN: &str = "cargo test -p potamoi-rtl --test rtl feature_major";

fn config(text: &str) -> Config {
    let text = format!("[gu]\norganisation = \"feature-major\"\n{text}");
    Config::from_toml(&text, "test").unwrap_or_else(|e| panic!("{text}: {e}"))
}

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
    let entries: usize = tasks.iter().map(|t| t.entries.len()).sum();
    let segments = config.segments(tasks[0].channels);
    assert_eq!(totals.entries, (entries * segments) as u64);
    totals
}

/// The closed form, stall by stall, of a run whose streams are ready.
fn predicted(config: &Config, tasks: &[GatherTask], found: &GatherTotals) {
    let work = GatherWork::new(config, tasks).unwrap();
    let closed = work.predicted(config).unwrap();
    assert_eq!(found.busy, closed.busy);
    assert_eq!(found.stalls, [0, closed.stall_mft, closed.stall_rit]);
    assert_eq!(found.stall_bank, closed.stall_bank);
    assert_eq!(found.first_issue - found.first_beat, closed.fill);
    assert_eq!(found.cycles - found.first_beat, closed.elapsed);
}

fn tasks(
    random: &mut Pcg64Mcg,
    config: &Config,
    vertices: Vertices,
    channels: usize,
    sizes: &[usize],
) -> Vec<GatherTask> {
    sizes
        .iter()
        .map(|&entries| {
            let rows = random.random_range(1..=config.mvoxel.rows as usize);
            task(random, config, vertices, channels, rows, entries)
        })
        .collect()
}

/// The paper's points, Verilated: 16 rays and 64.
#[test]
fn sixteen_lanes_keep_to_their_cycles() {
    lanes_keep_to_their_cycles(16, 2);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn sixty_four_lanes_keep_to_their_cycles() {
    lanes_keep_to_their_cycles(64, 4);
}

fn lanes_keep_to_their_cycles(lanes: usize, ports: u32) {
    let config = config(&format!("banks = 16\nlanes = {lanes}\nports = {ports}"));
    let unit = GatherUnit::build(&config).unwrap();
    for vertices in Vertices::ALL {
        for channels in [12, 37] {
            let mut random = Pcg64Mcg::seed_from_u64(7 + channels as u64);
            let sizes = [1, lanes, 3 * lanes, lanes + 1, 300, 2];
            let tasks = tasks(&mut random, &config, vertices, channels, &sizes);
            let run = check(&config, &unit, &tasks, Stalls::NONE, 3);
            predicted(&config, &tasks, &run);
            assert!(run.stall_bank > run.busy / 2, "{run:?}");
            let stalls = held_up(&mut random);
            let late = check(&config, &unit, &tasks, stalls, 4);
            assert_eq!((late.busy, late.stall_bank), (run.busy, run.stall_bank));
        }
    }
}

/// Units of any size that the rules allow, on the interpreter.
#[test]
fn units_of_any_size_keep_to_their_cycles() {
    for seed in 0..40u64 {
        let mut random = Pcg64Mcg::seed_from_u64(1700 + seed);
        let mut pick = |from: &[u32]| from[random.random_range(0..from.len())];
        let modes = ["both", "structured", "unstructured"][pick(&[0, 0, 1, 2]) as usize];
        let (banks, ports) = (pick(&[2, 4, 8, 32]), pick(&[1, 2, 3]));
        let config = config(&format!(
            "banks = {banks}\nports = {ports}\nlanes = {}\nfeature_bits = {}\nweight_bits = {}\n\
             fifo_depth = {}\nsegments = 4\nweights = \"{}\"\nmodes = \"{modes}\"\n\
             counter_bits = {}\n[rit]\nentries = {}\nslot_bits = {}\n[mvoxel]\nrows = {}",
            ports * pick(&[1, 2, 5]),
            pick(&[8, 11, 16]),
            pick(&[4, 7, 15]),
            pick(&[5, 8, 13]),
            ["trusted", "any"][pick(&[0, 1]) as usize],
            pick(&[24, 32]),
            ports * pick(&[2, 8]),
            if modes == "structured" {
                pick(&[16, 32])
            } else {
                16
            },
            banks * pick(&[2, 3, 16]),
        ));
        let unit = GatherUnit::on(EngineKind::Interpreter, &config).unwrap();
        let built = config.supported_vertices();
        let vertices = built[random.random_range(0..built.len())];
        let channels = random.random_range(1..=(3 * banks).min(9)) as usize;
        let sizes: Vec<_> = (0..5).map(|_| random.random_range(1..40)).collect();
        let tasks = tasks(&mut random, &config, vertices, channels, &sizes);
        let run = check(&config, &unit, &tasks, Stalls::NONE, seed);
        predicted(&config, &tasks, &run);
        let stalls = held_up(&mut random);
        check(&config, &unit, &tasks, stalls, seed);
    }
}

/// Rows that were not loaded, weights that are too large or sum to anything.
#[test]
fn broken_promises_of_entries_are_flagged_and_the_rest_stays_right() {
    for (trust, weight_bits) in [("trusted", 9), ("any", 9)] {
        let config = config(&format!(
            "banks = 4\nlanes = 6\nports = 2\nfeature_bits = 10\nweights = \"{trust}\"\n\
             weight_bits = {weight_bits}\n[mvoxel]\nrows = 16"
        ));
        let unit = GatherUnit::on(EngineKind::Interpreter, &config).unwrap();
        let twin = ReferenceGatheringUnit::new(&config);
        let mut seen = 0;
        for seed in 0..9 {
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            let mut task = task(&mut random, &config, Vertices::Eight, 3, 13, 40);
            for entry in &mut task.entries {
                for v in 0..8 {
                    match random.random_range(0..20) {
                        0 => entry.rows[v] = random.random(),
                        1 if seed % 3 == 1 => entry.weights[v] = random.random(),
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
                .unwrap_or_else(|e| panic!("{trust}, seed {seed}: {e}\nagain: {AGAIN}"));
        }
        let sum = if trust == "trusted" { FLAG_SUM } else { 0 };
        assert_eq!(seen, FLAG_ROW | FLAG_WEIGHT | sum, "{trust}");
    }
}
