//! Gathering units of cells, Verilated: compact entries, whole cells at once by
//! parity, banks in parts, and deeper pipelines, against the twin in every bit and
//! the cycle model in every cycle.
mod random;
mod split;

use potamoi_cycles::{GatherWork, Stalls};
use potamoi_formats::config::Config;
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_reference::weights;
use potamoi_rtl::{Check, GatherUnit};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::cells::cells;
use random::{all, check};

const AGAIN: &str = "cargo test -p potamoi-rtl --test rtl gather_cells";
const EIGHT: &str = "modes = \"structured\"\nvertices = [8]\n";

fn config(text: &str) -> Config {
    Config::from_toml(text, "test").unwrap()
}

#[test]
fn pipelined_units_differ_in_latency_alone() {
    let sizes = Vertices::ALL.map(|v| (v, 13));
    all("[gu]\npipelined = true\nbanks = 8\n", &sizes);
    let single = "[gu]\npipelined = true\nbanks = 8\nports = 1\nmodes = \"unstructured\"\n";
    all(single, &[(Vertices::One, 8)]);
}

#[test]
fn compact_entries_give_the_features_of_the_paper_s() {
    let sizes = Vertices::ALL.map(|v| (v, 9));
    all("[gu]\nbanks = 8\n[rit]\nentry = \"compact\"\n", &sizes);
    let narrow = "[mvoxel]\nrows = 64\n[gu]\nbanks = 4\nports = 3\npipelined = true\nweight_bits = 8\n\
        fifo_depth = 9\nvertices = [8, 2]\n[rit]\nentry = \"compact\"\nentries = 24\n";
    let sizes = [(Vertices::Eight, 4), (Vertices::Two, 9), (Vertices::One, 4)];
    all(narrow, &sizes);
}

#[test]
fn whole_cells_are_read_at_once_by_parity() {
    whole_cells_are_read_at_once("paper", 8);
    let pipelined = format!(
        "[gu]\norganisation = \"parity\"\npipelined = true\n{EIGHT}[rit]\nentry = \"compact\"\n"
    );
    all(
        &pipelined,
        &[4, 7].map(|channels| (Vertices::Eight, channels)),
    );
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn whole_cells_of_other_units_are_read_at_once_by_parity() {
    whole_cells_are_read_at_once("compact", 64);
    let wide = format!(
        "[mvoxel]\nrows = 4096\n[gu]\norganisation = \"parity\"\nbanks = 16\nports = 3\n{EIGHT}\
         weights = \"any\"\n[rit]\nslot_bits = 32\nentries = 24\n"
    );
    all(&wide, &[(Vertices::Eight, 2)]);
}

/// C = 4, C = 2, two segments, and a small unit of `rows` rows.
fn whole_cells_are_read_at_once(entry: &str, rows: u32) {
    let rit = format!("[rit]\nentry = \"{entry}\"\n");
    for channels in [4, 2, 7] {
        let text = format!("[gu]\norganisation = \"parity\"\n{EIGHT}{rit}");
        all(&text, &[(Vertices::Eight, channels)]);
    }
    let small = format!(
        "[mvoxel]\nrows = {rows}\n[gu]\norganisation = \"parity\"\nbanks = 8\nports = 1\n\
         pipelined = true\nweight_bits = 10\nfeature_bits = 12\n{EIGHT}{rit}"
    );
    all(&small, &[(Vertices::Eight, 1)]);
}

/// Two samples a cycle, without a bubble, of 4 channels and of 2, with compact
/// entries; with the paper's, what a stream of 16 B a cycle brings: a third of one.
#[test]
fn whole_cells_run_at_two_samples_a_cycle() {
    // The paper's entries keep up on a stream of 96 B a cycle alone.
    for (entry, stream) in [("compact", 128), ("paper", 128), ("paper", 768)] {
        for channels in [4, 2] {
            let text = format!(
                "[gu]\nchannels = {channels}\n{EIGHT}[rit]\nentry = \"{entry}\"\nstream_bits = {stream}\n"
            );
            let config = config(&text);
            assert!(config.is_parity());
            let unit = GatherUnit::build(&config).unwrap();
            let mut random = Pcg64Mcg::seed_from_u64(3);
            let tasks: Vec<_> = (0..6)
                .map(|_| cells(&mut random, &config, Vertices::Eight, (channels, 600)))
                .collect();
            let totals = check(&config, &unit, &tasks, Stalls::NONE);
            let samples = totals.entries;
            assert_eq!(samples, 3600);
            assert_eq!(totals.busy, samples / 2);
            if entry == "compact" || stream == 768 {
                assert_eq!(totals.issue_span(), samples / 2, "no bubble");
            } else {
                // From the first beat on, and through the pipeline.
                let stages = u64::from(
                    config.rit_pipeline().cycles() + config.gather_pipeline().cycles() + 1,
                );
                assert_eq!(totals.cycles - totals.first_beat, 3 * samples + stages);
            }
        }
    }
}

/// Parts of cells: vertices that lie elsewhere weigh 0. The unit's sums are the
/// twin's, and those of the parts add up to the cell's, rounded once to its feature.
#[test]
fn exact_sums_of_parts_add_up_to_the_cell() {
    let config = config("[gu]\nbanks = 8\nsums = \"exact\"\n");
    let unit = GatherUnit::build(&config).unwrap();
    let twin = ReferenceGatheringUnit::new(&config);
    let mut random = Pcg64Mcg::seed_from_u64(4);
    let whole = cells(&mut random, &config, Vertices::Eight, (11, 50));
    let parts = [0u8, 1].map(|side| {
        let mut part = whole.clone();
        for entry in &mut part.entries {
            for v in (0..8).filter(|v| v >> 1 & 1 != side) {
                entry.weights[usize::from(v)] = 0;
            }
        }
        part
    });
    let [low, high] = parts;
    let single = cells(&mut random, &config, Vertices::One, (11, 50));
    let mut sums = vec![];
    for tasks in [
        &[whole.clone(), low, high][..],
        std::slice::from_ref(&single),
    ] {
        let mut expected = vec![];
        for task in tasks {
            assert_eq!(twin.sums(task, &mut expected).unwrap(), 0);
        }
        let conditions = Check {
            stalls: Stalls::NONE,
            seed: 5,
            flags: 0,
            progress: &mut |_| {},
        };
        let totals = unit.check(&config, tasks, &expected, conditions);
        totals.unwrap_or_else(|e| panic!("{e}\nagain: {AGAIN}"));
        sums.push(expected);
    }
    let (cells, parts) = sums[0].split_at(sums[0].len() / 3);
    let (low, high) = parts.split_at(cells.len());
    let mut features = vec![];
    twin.gather(&whole, &mut features).unwrap();
    let mut rounded_first = 0;
    for (i, sum) in cells.iter().enumerate() {
        assert_eq!(low[i] + high[i], *sum);
        let round = |sum: i32| twin.reducer().round(sum.into());
        assert_eq!(round(*sum), features[i]);
        rounded_first += u32::from(round(low[i]) + round(high[i]) != features[i]);
    }
    assert!(rounded_first > 0, "rounding the parts is not the same");
    features.clear();
    twin.gather(&single, &mut features).unwrap();
    let codes: Vec<_> = sums[1].iter().map(|sum| (sum >> 15) as i16).collect();
    assert_eq!(codes, features);
}

/// Two records of half as many channels as banks in a row: half the rows to load,
/// the same features.
#[test]
fn two_records_share_a_row() {
    for ports in [1, 2] {
        let text = format!("[gu]\nbanks = 32\nports = {ports}\nrecords_a_row = 2\n");
        let (two, one) = (
            config(&text),
            config(&text.replace("records_a_row = 2", "")),
        );
        let units = [&two, &one].map(|config| GatherUnit::build(config).unwrap());
        let mut random = Pcg64Mcg::seed_from_u64(8);
        // An odd number of records, and one more than a row holds by itself.
        for (records, channels) in [(17, 16), (512, 16), (511, 9)] {
            let tasks: Vec<_> = (0..3)
                .map(|_| {
                    let mut task = cells(&mut random, &one, Vertices::One, (channels, 70));
                    task.rows = (0..records * channels).map(|_| random.random()).collect();
                    for entry in &mut task.entries {
                        entry.rows[0] = random.random_range(0..records as u16);
                    }
                    task
                })
                .collect();
            let [a, b] = [
                check(&two, &units[0], &tasks, Stalls::NONE),
                check(&one, &units[1], &tasks, Stalls::NONE),
            ];
            assert_eq!(a.busy, b.busy);
            assert!(
                a.stalls[1] * 2 <= b.stalls[1],
                "{:?} {:?}",
                a.stalls,
                b.stalls
            );
        }
        // Twice as many, and wider ones as before.
        let mut many = cells(&mut random, &one, Vertices::One, (16, 70));
        many.rows = (0..1024 * 16).map(|_| random.random()).collect();
        many.entries[3].rows[0] = 1023;
        check(&two, &units[0], &[many], Stalls::NONE);
        let wide = cells(&mut random, &one, Vertices::One, (17, 70));
        check(&two, &units[0], &[wide], Stalls::NONE);
        let cell = cells(&mut random, &one, Vertices::Eight, (32, 70));
        check(&two, &units[0], &[cell], Stalls::NONE);
    }
}

/// Every cell of an MVoxel, and of each every vertex alone: no two vertices of a
/// cell meet in a group of banks, and each is found where it is. Exhaustive, so
/// that no position is left to a sample.
#[test]
fn no_cell_of_an_mvoxel_has_a_conflict() {
    no_cell_has_a_conflict(&[(8, "paper"), (512, "paper"), (512, "compact")]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn no_cell_of_other_mvoxels_has_a_conflict() {
    no_cell_has_a_conflict(&[
        (8, "compact"),
        (64, "paper"),
        (64, "compact"),
        (4096, "paper"),
    ]);
}

fn no_cell_has_a_conflict(cases: &[(usize, &str)]) {
    for &(rows, entry) in cases {
        let text = format!(
            "[mvoxel]\nrows = {rows}\n[gu]\norganisation = \"parity\"\nbanks = 8\n{EIGHT}\
             [rit]\nentry = \"{entry}\"\n"
        );
        let config = config(&text);
        let edge = config.mvoxel.edges(3).unwrap()[0];
        let mut entries = vec![];
        for first in 0..rows {
            let place = [first % edge, first / edge % edge, first / (edge * edge)];
            if place.iter().any(|at| at + 1 == edge) {
                continue;
            }
            let corner = |v: usize| [0, 1, 2].map(|axis| place[axis] + (v >> axis & 1));
            let groups: std::collections::BTreeSet<_> =
                (0..8).map(|v| corner(v).map(|at| at % 2)).collect();
            assert_eq!(groups.len(), 8);
            for v in 0..8 {
                let row = |[x, y, z]: [usize; 3]| (x + edge * (y + edge * z)) as u16;
                let fraction = [0, 1, 2].map(|axis| 4096 * (v >> axis & 1) as u16);
                entries.push(RitEntry {
                    slot: 0,
                    rows: std::array::from_fn(|v| row(corner(v))),
                    weights: weights::trilinear(fraction, 15),
                });
            }
        }
        assert_eq!(entries.len(), 8 * (edge - 1).pow(3));
        let task = GatherTask {
            vertices: Vertices::Eight,
            channels: 1,
            rows: (0..rows as i16).collect(),
            entries,
        };
        let expected =
            |e: &RitEntry| e.rows[e.weights.iter().position(|w| *w != 0).unwrap()] as i16;
        let wanted: Vec<_> = task.entries.iter().map(expected).collect();
        let mut twin = vec![];
        ReferenceGatheringUnit::new(&config)
            .gather(&task, &mut twin)
            .unwrap();
        assert_eq!(wanted, twin);
        let unit = GatherUnit::build(&config).unwrap();
        check(&config, &unit, &[task], Stalls::NONE);
    }
}

#[test]
fn what_is_no_cell_is_refused_by_name() {
    let config = config("[gu]\nbanks = 8\n[rit]\nentry = \"compact\"\n");
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let task = cells(&mut random, &config, Vertices::Eight, (4, 3));
    let refused = |task: GatherTask| {
        let error = GatherWork::new(&config, &[task]).unwrap_err();
        error.to_string()
    };
    let mut other = task.clone();
    other.entries[1].rows[5] += 1;
    assert!(refused(other).contains("entry 1 names rows"));
    let mut other = task;
    other.entries[2].weights = [4096; 8];
    other.entries[2].weights[0] += 1;
    other.entries[2].weights[7] -= 1;
    let error = refused(other);
    assert!(error.contains("no split tree"), "{error}");
}
