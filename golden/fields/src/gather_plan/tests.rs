#![allow(clippy::unwrap_used)]

use std::collections::HashSet;

use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

use super::*;
use crate::Nodes;
use potamoi_march::streams::Streams;
use potamoi_march::tiling::Tiling;
use potamoi_reference::{ReferenceUnits, Units as _};

/// Lines, planes, a volume, and hashed ones, of components of their own.
fn tables(random: &mut Pcg64Mcg) -> Vec<Table> {
    let mut values = |count: usize, channels: usize| -> Vec<f32> {
        let each = (0..count * channels).map(|i| {
            let scale = if i % channels < 2 { 3.0 } else { 0.7 };
            random.random_range(-scale..scale)
        });
        each.collect()
    };
    let dense = [([700, 1, 1], 5), ([70, 45, 1], 4), ([33, 21, 17], 3)];
    let mut all: Vec<Table> = dense
        .iter()
        .map(|(points, channels)| {
            let count = points.iter().product();
            Table::new(*points, *channels, values(count, *channels)).unwrap()
        })
        .collect();
    for entries in [2, 97, 4096] {
        all.push(Table::hashed([300; 3], entries, 4, values(entries, 4)).unwrap());
    }
    all
}

/// The finest format for the first two channels, and for the others.
fn bits(table: &Table, config: &Config) -> Vec<u32> {
    let of = |low: bool| finest_of([table], |c| (c < 2) == low, config, "test").unwrap();
    (0..table.channels()).map(|c| of(c < 2)).collect()
}

/// Samples along rays from an eye before the first vertex.
fn samples(table: &Table, random: &mut Pcg64Mcg) -> (DVec3, Vec<Located>) {
    let last = DVec3::from(table.points().map(|p| p as f64 - 1.0));
    let eye = -0.3 * last;
    let mut all = vec![];
    for slot in 0..90 {
        let mut part = || random.random_range(0.0..=1.0);
        let to = last * DVec3::new(part(), part(), part());
        let steps = (0..60).map(|k| f64::from(k) / 50.0);
        let along = steps.map(|t| eye + (to - eye) * t);
        let inside = along.filter(|p| p.cmpge(DVec3::ZERO).all() && p.cmple(last).all());
        all.extend(inside.map(|place| Located { slot, place }));
    }
    (eye, all)
}

fn distance(tiling: &Tiling, mvoxel: usize, eye: DVec3) -> u64 {
    tiling
        .distances_from(eye.to_array())
        .distance(tiling.index(mvoxel))
}

fn configs() -> [Config; 2] {
    ["", "[mvoxel]\nrows = 32\n[gu]\nweight_bits = 8\n"]
        .map(|text| Config::from_toml(text, "test").unwrap())
}

/// Every gathered code is within the sum of what is rounded: half a code of the
/// vertices, half a code of the result, 2^-13 vertices of the place along each
/// axis, and weights that are together 2^axes - 1 units of 2^-W off, which
/// counts half since both sets sum to 1; the latter two times the span of the
/// cell.
#[test]
fn twins_gather_what_floats_do() {
    let mut random = Pcg64Mcg::seed_from_u64(20);
    for (number, table) in tables(&mut random).iter().enumerate() {
        for config in configs() {
            let bits = bits(table, &config);
            let coded = CodedTable::new(table, &bits, &config).unwrap();
            let (eye, samples) = samples(table, &mut random);
            let gathers = coded.gathers(eye, &samples);
            assert!(gathers.parted.samples.is_empty());
            let each: HashSet<_> = gathers.samples.iter().collect();
            assert_eq!(
                (each.len(), gathers.samples.len()),
                (samples.len(), samples.len())
            );
            let mut twins = ReferenceUnits::new(&config);
            let mut codes = vec![];
            twins.gather(&gathers.tasks, &mut codes).unwrap();
            assert_eq!(twins.gather_flags(), 0);
            let axes = table.vertices().ilog2();
            let unit = 2f64.powi(-(config.gu.weight_bits as i32));
            let off = f64::from(axes) * 2f64.powi(-13) + f64::from((1 << axes) - 1) / 2.0 * unit;
            let channels = table.channels();
            let mut exact = vec![0.0; channels];
            let mut worst = 0f64;
            let rows = codes.chunks_exact(channels);
            for (sample, codes) in gathers.samples.iter().zip(rows) {
                let place = samples[*sample as usize].place;
                table.gather(place, &mut exact);
                for channel in 0..channels {
                    let scale = 2f64.powi(bits[channel] as i32);
                    let (mut low, mut high) = (f64::MAX, f64::MIN);
                    table.corners(place, |row, _| {
                        let value = f64::from(table.values()[row * channels + channel]);
                        (low, high) = (low.min(value), high.max(value));
                    });
                    // The place's code may be of the next cell, as far from it.
                    let span = (high - low) * scale + 1.0;
                    let next = if axes == 0 {
                        0.0
                    } else {
                        6.1 * scale * 2f64.powi(-13)
                    };
                    let bound = 1.0 + off * span + next;
                    let share = (f64::from(codes[channel]) - exact[channel] * scale).abs() / bound;
                    assert!(
                        share <= 1.0,
                        "table {number}, {place}: {share} of the bound"
                    );
                    worst = worst.max(share);
                }
            }
            assert!(
                worst > 0.1,
                "table {number}: the bound is not idle: {worst}"
            );
        }
    }
}

/// In a batch, each MVoxel of a table comes once, in the order of distance from the camera, and
/// those of a ray come front to back.
#[test]
fn mvoxels_are_loaded_once_in_order() {
    let mut random = Pcg64Mcg::seed_from_u64(21);
    for table in &tables(&mut random)[..3] {
        let config = Config::from_toml("[mvoxel]\nrows = 32\n", "test").unwrap();
        let coded = CodedTable::new(table, &bits(table, &config), &config).unwrap();
        let Order::Streaming(tiles) = coded.order() else {
            unreachable!("a dense table streams")
        };
        let tiling = tiles.tiling();
        let mvoxel_of = |at: &Located| tiling.locate(at.place.to_array()).mvoxel;
        let (eye, samples) = samples(table, &mut random);
        let gathers = coded.gathers(eye, &samples);
        let (mut loaded, mut last, mut from) = (HashSet::new(), 0, 0);
        for task in &gathers.tasks {
            let own = &gathers.samples[from..from + task.entries.len()];
            assert!(own.is_sorted());
            from += task.entries.len();
            let mvoxel = mvoxel_of(&samples[own[0] as usize]);
            assert!(loaded.insert(mvoxel), "loaded once");
            assert!(tiles.rows(mvoxel).starts_with(&task.rows));
            // Up to the last row that is used, and no further.
            let top = task.vertices.count() - 1;
            let last_row = task.entries.iter().map(|e| usize::from(e.rows[top])).max();
            assert_eq!(task.rows.len(), (last_row.unwrap() + 1) * task.channels);
            let distance = distance(tiling, mvoxel, eye);
            assert!(distance >= last, "{distance} after {last}");
            last = distance;
        }
        assert!(loaded.len() > 5, "{}", loaded.len());
        for ray in samples.chunk_by(|a, b| a.slot == b.slot) {
            let distances = ray.iter().map(|at| distance(tiling, mvoxel_of(at), eye));
            assert!(distances.is_sorted());
        }
    }
}

/// Hashed tables keep the order of samples; a task holds as many rows as fit
/// and none twice, and ends only where the next sample's do not fit.
#[test]
fn scattered_rows_are_fetched_once_a_task() {
    let mut random = Pcg64Mcg::seed_from_u64(22);
    let config = Config::from_toml("[mvoxel]\nrows = 32\n", "test").unwrap();
    for table in &tables(&mut random)[3..] {
        let coded = CodedTable::new(table, &bits(table, &config), &config).unwrap();
        assert!(matches!(coded.order(), Order::Scattered(_)));
        let (eye, samples) = samples(table, &mut random);
        let gathers = coded.gathers(eye, &samples);
        assert!(gathers.samples.iter().copied().eq(0..samples.len() as u32));
        let rows_of = |sample: usize| {
            let mut rows = HashSet::new();
            table.corners(samples[sample].place, |row, _| {
                rows.insert(row);
            });
            rows
        };
        let (mut next, mut early) = (0, 0);
        for task in &gathers.tasks {
            let mut needed = HashSet::new();
            for sample in next..next + task.entries.len() {
                needed.extend(rows_of(sample));
            }
            next += task.entries.len();
            let rows = task.rows.len() / task.channels;
            // Places next to a vertex may round into the next cell.
            assert!(rows <= 32 && rows.abs_diff(needed.len()) <= 8, "{rows}");
            if next < samples.len() && rows == needed.len() {
                let before = needed.len();
                needed.extend(rows_of(next));
                early += u32::from(needed.len() <= 32 && before > 0);
            }
        }
        // A place that rounds across a vertex may need rows of the next cell.
        assert!(
            20 * early as usize <= gathers.tasks.len(),
            "{early} of {} tasks ended early",
            gathers.tasks.len()
        );
    }
}

#[test]
fn units_that_cannot_gather_are_refused_by_field() {
    let all = tables(&mut Pcg64Mcg::seed_from_u64(23));
    for (table, text, expected) in [
        (0, "[gu]\nvertices = [8]", "gu.vertices"),
        (1, "[gu]\nvertices = [8]", "gu.vertices"),
        (2, "[gu]\nvertices = [4]", "gu.vertices"),
        (0, "[gu]\nbanks = 4\nsegments = 1", "gu.segments"),
    ] {
        let config = Config::from_toml(text, "test").unwrap();
        let table = &all[table];
        let made = CodedTable::new(table, &vec![8; table.channels()], &config);
        let error = made.unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    // Rows of a hashed table lie anywhere, and entries of other units are cells.
    let hashed = Table::hashed([99; 3], 64, 2, vec![0.5; 128]).unwrap();
    for (text, expected) in [
        ("rit.entry = \"compact\"", "rit.entry"),
        (
            "[gu]\nchannels = 2\nmodes = \"structured\"\nvertices = [8]",
            "gu.organisation",
        ),
    ] {
        let config = Config::from_toml(text, "test").unwrap();
        let made = CodedTable::new(&hashed, &[8; 2], &config);
        let error = made.unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let odd = Table::new([3, 1, 6], 1, vec![0.0; 18]).unwrap();
    let error = CodedTable::new(&odd, &[8], &Config::paper()).unwrap_err();
    assert!(error.to_string().contains("table.points"), "{error}");
}

/// The codes of every sample, after executing the planned tasks.
fn carried_out(coded: &CodedTable, gathers: &Gathers, samples: usize, config: &Config) -> Vec<i16> {
    let width = coded.channels();
    let mut found = vec![None; samples];
    let mut units = ReferenceUnits::new(config);
    let mut stats = FixedStats::default();
    coded
        .carry_out(gathers, &mut units, &mut stats, |sample, codes| {
            assert_eq!(found[sample as usize].replace(codes.to_vec()), None);
        })
        .unwrap();
    assert_eq!(units.gather_flags(), 0);
    assert_eq!(stats.tasks, gathers.mvoxels() as u64);
    let moved = 2 * gathers.rows() * width as u64;
    assert_eq!(stats.streams.mvoxels_read, moved);
    assert_eq!(
        stats.scattered_bytes,
        if gathers.row_by_row { moved } else { 0 }
    );
    let sums = 4 * stats.split_entries * width as u64;
    assert_eq!(stats.streams.partial_sums, sums);
    assert_eq!(stats.waiting > 0, stats.split_entries > 0);
    found.into_iter().flat_map(Option::unwrap).collect()
}

/// Lines, planes and volumes give the same codes with both halos, and MVoxels
/// that share nothing load no more rows in all than there are.
#[test]
fn split_halos_gather_what_shared_ones_do() {
    let mut random = Pcg64Mcg::seed_from_u64(24);
    for table in &tables(&mut random)[..3] {
        for config in configs() {
            let bits = bits(table, &config);
            let (eye, samples) = samples(table, &mut random);
            let [shared, split] = [Halo::Shared, Halo::Split].map(|halo| {
                let coded = CodedTable::with_halo(table, &bits, &config, halo).unwrap();
                let gathers = coded.gathers(eye, &samples);
                let codes = carried_out(&coded, &gathers, samples.len(), &config);
                (codes, gathers)
            });
            assert_eq!(shared.0, split.0);
            assert!(split.1.rows() <= table.rows() as u64);
            assert!(!split.1.parted.samples.is_empty());
        }
    }
}

/// A volume hashed by MVoxel gives the same codes in both orders, those of the
/// float gathering within a code, and takes the order with fewer rows.
#[test]
fn blocks_give_the_same_codes_in_either_order() {
    let mut random = Pcg64Mcg::seed_from_u64(25);
    let rows = 3 * HashUnit::BLOCK_ROWS;
    let values = (0..rows * 4).map(|_| random.random_range(-1.0..1.0));
    let values = values.collect();
    let table = Table::hashed_by(HashUnit::MVoxel, [16; 3], rows, 4, values).unwrap();
    let config = &configs()[0];
    let frac = finest_of([&table], |_| true, config, "test").unwrap();
    let coded = CodedTable::new(&table, &[frac; 4], config).unwrap();
    let Order::Blocks(blocks) = coded.order() else {
        unreachable!("a table of blocks")
    };
    let (eye, many) = samples(&table, &mut random);
    for (samples, streams) in [(&many[..], true), (&many[..20], false)] {
        let orders = blocks.orders(eye, samples, 15);
        let [streamed, single] = orders.each_ref().map(|gathers| {
            assert!(!gathers.row_by_row || gathers.parted.samples.is_empty());
            carried_out(&coded, gathers, samples.len(), config)
        });
        assert_eq!(streamed, single);
        assert!(!streams || !orders[0].parted.samples.is_empty());
        let taken = coded.gathers(eye, samples);
        let fewest = orders.iter().map(Gathers::rows).min();
        assert_eq!(Some(taken.rows()), fewest);
        assert_eq!(taken.row_by_row, !streams, "{fewest:?}");
        let mut exact = [0.0; 4];
        for (at, codes) in samples.iter().zip(streamed.chunks_exact(4)) {
            table.gather(at.place, &mut exact);
            for (code, exact) in codes.iter().zip(exact) {
                // As in the bound above: a span of at most 2, three axes.
                let scale = 2f64.powi(frac as i32);
                let off = (f64::from(*code) - exact * scale).abs();
                let bound =
                    1.0 + (3.0 * 2f64.powi(-13) + 3.5 * 2f64.powi(-15)) * (2.0 * scale + 1.0);
                assert!(off <= bound + 6.1 * scale * 2f64.powi(-13), "{off}");
            }
        }
    }
}

/// The traffic count of a batch equals that of its gathers: with both halos, row by row, for
/// blocks in either order, and for a tree in which some samples have no node.
#[test]
fn batches_are_counted_as_they_are_gathered() {
    let mut random = Pcg64Mcg::seed_from_u64(26);
    let mut all = tables(&mut random);
    let rows = 3 * HashUnit::BLOCK_ROWS;
    let blocks = Table::hashed_by(HashUnit::MVoxel, [16; 3], rows, 4, vec![0.5; rows * 4]);
    all.push(blocks.unwrap());
    let nodes = Nodes::new([9; 3], 2, |[x, y, z]| (x + y + z) % 3 > 0);
    let fine = nodes.rows();
    all.push(Table::tree(nodes, 3, vec![0.5; fine * 3]).unwrap());
    let (mut split, mut orders) = (0, HashSet::new());
    for (number, table) in all.iter().enumerate() {
        let (eye, samples) = samples(table, &mut random);
        for (config, halo) in configs()
            .iter()
            .flat_map(|config| [Halo::Shared, Halo::Split].map(|halo| (config, halo)))
        {
            let bits = vec![0; table.channels()];
            let coded = CodedTable::with_halo(table, &bits, config, halo).unwrap();
            for many in [samples.len(), 20, 0] {
                let gathers = coded.gathers(eye, &samples[..many]);
                let (mut entries, mut streams) = (0, Streams::default());
                for visit in &gathers.visits {
                    entries += visit.whole + visit.split;
                    split += visit.split;
                    streams.visit(visit, UnitStreams::of(config));
                }
                let scattered = if gathers.row_by_row {
                    streams.mvoxels_read
                } else {
                    0
                };
                let expected = Counted {
                    tasks: gathers.mvoxels() as u64,
                    entries,
                    streams,
                    scattered,
                };
                let mut count = BatchCount::new(&coded);
                for at in &samples[..many] {
                    count.sample(at.place);
                }
                assert_eq!(count.done(), expected, "table {number}, {halo:?}, {many}");
                orders.insert((number, scattered > 0));
            }
        }
    }
    assert!(split > 1000, "{split}");
    // Blocks are gathered in both orders.
    assert!(orders.contains(&(6, false)) && orders.contains(&(6, true)));
}

/// By hand: of nine vertices an axis, the middle one starts the second
/// MVoxel of four.
#[test]
fn a_sample_on_the_seam_has_an_entry_on_each_side() {
    let of = |halo, cell| {
        let tiling = Tiling::new([9; 3], [4; 3], halo);
        let mut tally = Tally::default();
        tally.touch(&tiling, &tiling.place(cell, [0; 3]));
        tally.done()
    };
    let entries = |halo, cell| {
        let all = of(halo, cell);
        let sum = |of: fn(&Touched) -> u64| all.values().map(of).sum::<u64>();
        [sum(|t| t.whole), sum(|t| t.split)]
    };
    assert_eq!(entries(Halo::Split, [1, 1, 1]), [1, 0]);
    assert_eq!(entries(Halo::Split, [3, 1, 1]), [0, 2]);
    assert_eq!(entries(Halo::Split, [3, 3, 1]), [0, 4]);
    assert_eq!(entries(Halo::Split, [3, 7, 3]), [0, 8]);
    assert_eq!(entries(Halo::Shared, [3, 3, 3]), [1, 0]);
    let touched = of(Halo::Split, [3, 0, 0]);
    // Vertices (3, 1, 1) there and (0, 1, 1) here, of 4 x 4 x 4.
    assert_eq!(touched[&0].last, 3 + 4 * (1 + 4));
    assert_eq!(touched[&1].last, 4 * (1 + 4));
}
