//! The reducer of the Python package against the reference unit, on drawn entries and on the extremes.

use std::path::Path;

use potamoi_formats::config::{Config, Sums};
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;

use crate::python::{empty, python, run};

/// Tables `[gu]`, each beside the knobs of `potamoi.Reducer` as JSON.
const UNITS: [(&str, &str); 7] = [
    ("", "{}"),
    ("weights = \"any\"", r#"{"weights": "any"}"#),
    (
        "feature_bits = 8\nweight_bits = 4",
        r#"{"feature_bits": 8, "weight_bits": 4}"#,
    ),
    (
        "feature_bits = 11\nweight_bits = 9\nweights = \"any\"",
        r#"{"feature_bits": 11, "weight_bits": 9, "weights": "any"}"#,
    ),
    ("pipelined = true", r#"{"registered_products": true}"#),
    (
        "organisation = \"parity\"\nchannels = 4\nmodes = \"structured\"\nvertices = [8]",
        r#"{"registered_products": true}"#,
    ),
    ("sums = \"exact\"", r#"{"sums": "exact"}"#),
];
/// Rows of an MVoxel, and channels of each.
const ROWS: usize = 20;
const CHANNELS: usize = 3;
/// Entries of an MVoxel.
const ENTRIES: usize = 500;
const SEED: u64 = 0x0070_6f74_616d_6f69;

/// SplitMix64.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A code: drawn, or an end of the range.
    fn code(&mut self, bits: u32) -> i16 {
        let most = (1i64 << (bits - 1)) - 1;
        (match self.next() % 4 {
            0 => most,
            1 => -most - 1,
            _ => (self.next() as i64).rem_euclid(2 * most + 2) - most - 1,
        }) as i16
    }

    /// Weights that sum to 1, for exact sums, or any words.
    fn weights(&mut self, config: &Config, count: usize) -> [u16; 8] {
        let (mut out, mut left) = ([0; 8], 1 << config.gu.weight_bits);
        let sums_to_one = config.gu.sums == Sums::Exact || self.next().is_multiple_of(2);
        for (v, weight) in out.iter_mut().enumerate().take(count) {
            let own = match sums_to_one {
                true if v + 1 == count => left,
                true => self.next() % (left + 1),
                false => self.next() & 0xffff,
            };
            left = left.saturating_sub(own);
            *weight = own as u16;
        }
        out
    }

    fn task(&mut self, config: &Config, vertices: Vertices) -> GatherTask {
        let entries = (0..ENTRIES).map(|slot| RitEntry {
            slot: slot as u32,
            // A row above the loaded ones now and then.
            rows: [(); 8].map(|()| (self.next() % (ROWS as u64 + 1)) as u16),
            weights: self.weights(config, vertices.count()),
        });
        let entries = entries.collect();
        let bits = config.gu.feature_bits;
        GatherTask {
            vertices,
            channels: CHANNELS,
            rows: (0..ROWS * CHANNELS).map(|_| self.code(bits)).collect(),
            entries,
        }
    }
}

fn words<T: Copy>(all: impl IntoIterator<Item = T>, bytes: impl Fn(T) -> [u8; 2]) -> Vec<u8> {
    all.into_iter().flat_map(bytes).collect()
}

/// Writes what `python/tests/reduce.py` reads of a task.
fn ask(folder: &Path, name: &str, knobs: &str, task: &GatherTask) {
    let shape = format!(
        r#"{{"knobs": {knobs}, "vertices": {}, "channels": {CHANNELS}}}"#,
        task.vertices.count()
    );
    let entries = || task.entries.iter();
    let write = |kind: &str, bytes: Vec<u8>| {
        std::fs::write(folder.join(format!("{name}.{kind}")), bytes).unwrap();
    };
    write("task", shape.into_bytes());
    write("rows", words(task.rows.iter().copied(), i16::to_le_bytes));
    write(
        "entry_rows",
        words(entries().flat_map(|e| e.rows), u16::to_le_bytes),
    );
    write(
        "entry_weights",
        words(entries().flat_map(|e| e.weights), u16::to_le_bytes),
    );
}

fn expected(config: &Config, task: &GatherTask) -> Vec<i32> {
    let unit = ReferenceGatheringUnit::new(config);
    match config.gu.sums {
        Sums::Rounded => {
            let mut codes = vec![];
            unit.gather(task, &mut codes).unwrap();
            codes.into_iter().map(i32::from).collect()
        }
        Sums::Exact => {
            let mut sums = vec![];
            unit.sums(task, &mut sums).unwrap();
            sums
        }
    }
}

#[test]
fn the_python_reducer_gives_the_features_of_the_reference_unit() {
    let folder = empty("python-reducer");
    let mut draw = Draw(SEED);
    let mut asked = vec![];
    for (i, (table, knobs)) in UNITS.iter().enumerate() {
        let config = Config::from_toml(&format!("[gu]\n{table}\n"), "test").unwrap();
        for vertices in config.supported_vertices() {
            let task = draw.task(&config, vertices);
            let name = format!("{i}-{}", vertices.count());
            ask(&folder, &name, knobs, &task);
            asked.push((name, *table, expected(&config, &task)));
        }
    }
    assert!(asked.len() > 3 * UNITS.len(), "{}", asked.len());
    run(python().arg("tests/reduce.py").arg(&folder));
    for (name, table, expected) in asked {
        let found = std::fs::read(folder.join(format!("{name}.results"))).unwrap();
        let found: Vec<i32> = (found.chunks(4))
            .map(|bytes| i32::from_le_bytes(bytes.try_into().unwrap()))
            .collect();
        assert!(found == expected, "seed {SEED:#x}, {name}: {table}");
    }
}
