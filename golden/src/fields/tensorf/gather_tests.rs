#![allow(clippy::unwrap_used)]

use std::collections::HashSet;

use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

use super::super::{LINES, PLANES, Rules, tests::gathered};
use super::*;
use crate::fields::{Layer, Mlp};
use crate::units::{Twins, Units as _};

/// A model of 70 x 45 x 33 vertices with components of its own in every table.
fn model() -> Tensorf {
    let mut random = Pcg64Mcg::seed_from_u64(20);
    let points = [70, 45, 33];
    let mut table = |sides: [usize; 2], channels: usize| {
        let count = sides[0] * sides[1] * channels;
        let values = (0..count).map(|i| {
            let scale = if i % channels < 2 { 3.0 } else { 0.7 };
            random.random_range(-scale..scale)
        });
        Table::new([sides[0], sides[1], 1], channels, values.collect()).unwrap()
    };
    let channels = [5, 4, 3];
    let plane = |m: usize| PLANES[m].map(|axis| points[axis]);
    let planes = [0, 1, 2].map(|m| table(plane(m), channels[m]));
    let lines = [0, 1, 2].map(|m| table([points[LINES[m]], 1], channels[m]));
    let [a, b, c] = planes;
    let [d, e, f] = lines;
    let rules = Rules {
        feature_frequencies: 0,
        view_frequencies: 0,
        ..Rules::new([DVec3::new(-1.2, -1.0, -0.8), DVec3::new(1.0, 0.9, 0.8)])
    };
    let layer = |inputs: usize, outputs: usize| {
        Layer::new(inputs, vec![0.1; inputs * outputs], vec![0.0; outputs]).unwrap()
    };
    // Two channels of each table are density.
    let mlp = Mlp::new(vec![layer(4 + 3, 3)]).unwrap();
    Tensorf::new([a, b, c, d, e, f], [2; 3], layer(3 + 2 + 1, 4), mlp, rules).unwrap()
}

fn camera(width: u32, height: u32) -> Camera {
    let eye = DVec3::new(2.0, -1.5, 1.1);
    Camera::look_at(eye, DVec3::ZERO, DVec3::Z, 0.9, width, height)
}

/// The most that two neighbouring codes of a channel differ.
fn steepest(table: &Table, channel: usize, frac: u32) -> f64 {
    let [x, y, _] = table.points();
    let at = |i: usize, j: usize| table.values()[(i + x * j) * table.channels() + channel];
    let mut most = 0f32;
    for j in 0..y {
        for i in 0..x {
            most = most.max((at((i + 1).min(x - 1), j) - at(i, j)).abs());
            most = most.max((at(i, (j + 1).min(y - 1)) - at(i, j)).abs());
        }
    }
    f64::from(most) * 2f64.powi(frac as i32) + 1.0
}

/// Every gathered code is within the sum of what is rounded: half a code of
/// each vertex, half a code of the result, 2^-13 vertices of the place along
/// each axis, and weights that are together 3 (planes) or 1 (lines) units of
/// 2^-W off. Since both sets of weights sum to 1, the last counts half, times
/// the span of the cell.
#[test]
fn twins_gather_what_floats_do() {
    let field = model();
    for text in ["", "[mvoxel]\nrows = 32\n[gu]\nweight_bits = 8\n"] {
        let config = Config::from_toml(text, "test").unwrap();
        let tiled = field.tiled(&config).unwrap();
        let gathers = tiled.gathers(&camera(24, 18), usize::MAX).unwrap();
        let mut twins = Twins::new(&config);
        let mut codes = vec![];
        twins.gather(&gathers.tasks, &mut codes).unwrap();
        assert_eq!(twins.gather_flags(), 0);
        assert_eq!(gathers.sources.len(), ENTRIES * gathers.samples.len());
        assert!(gathers.samples.len() > 10_000);
        let seen: HashSet<_> = gathers
            .sources
            .iter()
            .map(|s| (s.table, s.sample))
            .collect();
        assert_eq!(seen.len(), gathers.sources.len());
        let exact: Vec<_> = gathers
            .samples
            .iter()
            .map(|s| gathered(&field, s.at).unwrap())
            .collect();
        let channels: Vec<usize> = field.tables().iter().map(Table::channels).collect();
        let start: Vec<usize> = (0..ENTRIES).map(|t| channels[..t].iter().sum()).collect();
        let slopes: Vec<Vec<f64>> = (0..ENTRIES)
            .map(|t| {
                let frac = |c| tiled.tables()[t].frac_bits(c);
                (0..channels[t])
                    .map(|c| steepest(&field.tables()[t], c, frac(c)))
                    .collect()
            })
            .collect();
        let unit = 2f64.powi(-(config.gu.weight_bits as i32));
        let (mut rest, mut worst) = (&codes[..], 0f64);
        for source in &gathers.sources {
            let table = source.table;
            let (own, other) = rest.split_at(channels[table]);
            rest = other;
            let (axes, off) = if table < 3 { (2.0, 3.0) } else { (1.0, 1.0) };
            for (channel, code) in own.iter().enumerate() {
                let value = exact[source.sample][start[table] + channel];
                let value = value * 2f64.powi(tiled.tables()[table].frac_bits(channel) as i32);
                let slope = slopes[table][channel];
                let bound = 1.0 + axes * slope * (2f64.powi(-13) + off / 2.0 * unit);
                let share = (f64::from(*code) - value).abs() / bound;
                assert!(
                    share <= 1.0,
                    "{source:?}, channel {channel}: {code} {value}"
                );
                worst = worst.max(share);
            }
        }
        assert!(rest.is_empty());
        println!(
            "{} entries, at most {worst:.2} of the bound",
            gathers.sources.len()
        );
        assert!(worst > 0.3, "the bound is not idle: {worst}");
    }
}

/// In a group, MVoxels of a table come once and never nearer the camera.
#[test]
fn mvoxels_are_loaded_once_in_order() {
    let field = model();
    let config = Config::from_toml("[mvoxel]\nrows = 32\n", "test").unwrap();
    let tiled = field.tiled(&config).unwrap();
    assert_eq!(tiled.tables()[0].counts(), [10, 15]);
    assert_eq!(tiled.tables()[3].counts(), [2, 1]);
    let camera = camera(24, 18);
    let gathers = tiled.gathers(&camera, usize::MAX).unwrap();
    let mut eye = [DVec3::ZERO; ENTRIES];
    field.place(camera.position(), &mut eye);
    let (mut loaded, mut last, mut from) = (HashSet::new(), (0, 0), 0);
    for task in &gathers.tasks {
        let source = gathers.sources[from];
        let sources = &gathers.sources[from..from + task.entries.len()];
        assert!(sources.windows(2).all(|s| s[0].sample < s[1].sample));
        from += task.entries.len();
        let table = &tiled.tables()[source.table];
        let mut places = [DVec3::ZERO; ENTRIES];
        field.place(gathers.samples[source.sample].at, &mut places);
        let (mvoxel, _) = table.entry(places[source.table], 0, 15);
        assert!(loaded.insert((source.table, mvoxel)));
        let place = (source.table, table.distance(mvoxel, eye[source.table]));
        assert!(place >= last, "{place:?} after {last:?}");
        last = place;
    }
    assert_eq!(from, gathers.sources.len());
    assert_eq!(last.0, 5);
}

/// A ray's MVoxels come front to back: their distance never falls along it.
#[test]
fn distances_grow_along_every_ray() {
    let field = model();
    let config = Config::from_toml("[mvoxel]\nrows = 32\n", "test").unwrap();
    let tiled = field.tiled(&config).unwrap();
    let camera = camera(16, 12);
    let samples = tiled.gathers(&camera, usize::MAX).unwrap().samples;
    let mut eye = [DVec3::ZERO; ENTRIES];
    field.place(camera.position(), &mut eye);
    let mut places = [DVec3::ZERO; ENTRIES];
    for ray in samples.chunk_by(|a, b| a.pixel == b.pixel) {
        for (number, table) in tiled.tables().iter().enumerate() {
            let mut last = 0;
            for sample in ray {
                field.place(sample.at, &mut places);
                let (mvoxel, _) = table.entry(places[number], 0, 15);
                let distance = table.distance(mvoxel, eye[number]);
                assert!(distance >= last);
                last = distance;
            }
        }
    }
}

#[test]
fn entries_stop_at_the_limit_and_groups_follow_one_another() {
    let field = model();
    let config = Config::paper();
    let tiled = field.tiled(&config).unwrap();
    assert_eq!(tiled.tables()[0].counts(), [3, 3]);
    let few = tiled.tasks(&camera(24, 18), 600).unwrap();
    let entries: usize = few.iter().map(|t| t.entries.len()).sum();
    assert!((600..6000).contains(&entries), "{entries}");
    assert!(tiled.tasks(&camera(24, 18), 0).unwrap().is_empty());
    // More than one group wide: slots begin again.
    let mut wide = camera(300, 2);
    wide.focal = glam::DVec2::splat(300.0);
    let wide = tiled.gathers(&wide, usize::MAX).unwrap();
    let slots: Vec<_> = wide.samples.iter().map(|s| (s.pixel, s.slot)).collect();
    assert!(
        slots
            .iter()
            .any(|(p, s)| p[0] >= 221 && *s == p[0] - 221 + p[1] * 79)
    );
    assert!(slots.iter().all(|(_, s)| *s < 442));
}

#[test]
fn units_that_cannot_gather_are_refused_by_field() {
    let field = model();
    for (text, expected) in [
        ("[gu]\nvertices = [8]", "gu.vertices"),
        ("[gu]\nvertices = [8, 4]", "gu.vertices"),
        ("[gu]\nbanks = 4\nsegments = 1", "gu.segments"),
    ] {
        let config = Config::from_toml(text, "test").unwrap();
        let error = field.tiled(&config).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    assert_eq!(rectangle(512), [32, 16]);
    assert_eq!(rectangle(256), [16, 16]);
    assert_eq!(rectangle(8), [4, 2]);
}
