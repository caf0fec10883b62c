//! Fields of several tables in the hardware's formats.

use std::path::Path;

use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_fields::{Along, BatchSize, Field, FixedField, FixedOptions};
use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;
use potamoi_march::tiling::Halo;
use potamoi_march::{FixedFrame, FixedStats};
use potamoi_reference::ReferenceUnits;
use potamoi_scene::{Model, Scene};

use crate::fields_common::{config, scene};

/// A checkpoint of TensoRF and two snapshots of Instant-NGP, which other
/// programs wrote (tools/torch-fixtures, tools/ngp-fixtures), a built-in scene as
/// a tree of EfficientNeRF and as Instant-NGP hashed by MVoxel, and the least PSNR
/// of the fixed-point picture against the float one, over covered pixels, in dB.
const SCENES: [(&str, f64); 5] = [
    ("tensorf/tiny.th", 75.0),
    ("ngp/cube.ingp", 65.0),
    ("ngp/cascades.ingp", 75.0),
    ("cairn:efficientnerf", 75.0),
    ("cairn:ngp-mvoxel", 65.0),
];

fn field(scene: &Scene) -> &dyn Field {
    match scene.model() {
        Model::Field(field) => &**field,
        _ => panic!("a field"),
    }
}

/// Batches of at most this many entries, with the same number of samples a ray.
fn bounded(entries: usize) -> Option<BatchSize> {
    Some(BatchSize {
        samples: u32::MAX,
        entries,
    })
}

fn render(scene: &Scene, config: &Config, options: &FixedOptions) -> FixedFrame {
    let made = FixedField::new(field(scene), config).unwrap();
    render_made(&made, scene, config, options)
}

/// The same of a field that is in the hardware's formats already.
fn render_made(
    made: &FixedField<'_>,
    scene: &Scene,
    config: &Config,
    options: &FixedOptions,
) -> FixedFrame {
    let mut twins = ReferenceUnits::new(config);
    let frame = made.render(scene.camera(), options, &mut twins).unwrap();
    assert_eq!(twins.gather_flags(), 0);
    frame
}

/// The cost of the formats: the picture stays close to the float one. A field in 16 bits should
/// reach 45 dB; these limits leave room for a change of a scale, but not for a mistake.
#[test]
fn pictures_stay_next_to_float_ones() {
    let config = config("");
    // Gaussians whose colours are a field's.
    for (name, least) in SCENES.into_iter().chain([("compact/tiny.npz", 75.0)]) {
        let scene = scene(name, 48);
        let float = scene.render_float().unwrap();
        let fixed = scene
            .render_fixed(&config, &mut ReferenceUnits::new(&config))
            .unwrap();
        let psnr = fixed
            .picture
            .psnr(&float.picture, |i| float.covered[i])
            .unwrap();
        println!("{name}: {psnr:.1} dB over covered pixels");
        assert!(psnr > least, "{name}: {psnr}");
        assert!(fixed.counts.feature_vectors > 1000);
        // Hashed by MVoxel, it depends on the frame.
        if !name.ends_with("mvoxel") {
            let scattered = name.starts_with("ngp") || name.starts_with("compact");
            assert_eq!(fixed.counts.scattered_bytes > 0, scattered, "{name}");
        }
    }
}

/// The memory-centric order yields the picture of the pixel-centric one, bit for bit: one ray
/// after another and one sample after another, for any group and batch.
#[test]
fn the_picture_depends_neither_on_ray_groups_nor_on_batches() {
    // A sample a batch, batches that end within a group, and all of a frame at once.
    depends_neither_on(&[(16, bounded(1)), (7, bounded(1000)), (1000, None)]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn the_picture_depends_neither_on_more_ray_groups_nor_on_batches() {
    depends_neither_on(&[
        (22, bounded(5000)),
        (1000, bounded(1 << 18)),
        (20, None),
        (8, None),
    ]);
}

/// Sides of ray groups and batches.
fn depends_neither_on(groups: &[(u32, Option<BatchSize>)]) {
    let config = config("");
    for (name, _) in SCENES {
        let scene = scene(name, 16);
        let made = FixedField::new(field(&scene), &config).unwrap();
        let pixel_centric = FixedOptions {
            group_side: Some(1),
            batch: bounded(1),
            ..FixedOptions::default()
        };
        let expected = render_made(&made, &scene, &config, &pixel_centric);
        let covered = expected.transmittance.iter().filter(|t| **t < 1 << 20);
        assert!(covered.count() > 50);
        for &(side, batch) in groups {
            let options = FixedOptions {
                group_side: Some(side),
                batch,
                ..FixedOptions::default()
            };
            let frame = render_made(&made, &scene, &config, &options);
            assert_eq!(frame.picture, expected.picture, "{name}, {side}, {batch:?}");
            assert_eq!(frame.transmittance, expected.transmittance);
            assert_eq!(frame.stops, expected.stops);
            assert_eq!(frame.stats.samples, expected.stats.samples);
            assert!(frame.stats.tasks <= expected.stats.tasks);
            assert!(frame.stats.streams.mvoxels_read <= expected.stats.streams.mvoxels_read);
        }
    }
}

/// Nothing is stored twice, a sample has an entry in each MVoxel that holds
/// vertices of it, and the picture is the same bit for bit: of volumes, planes
/// and lines, with the preset's rows and with fewer.
#[test]
fn split_halos_give_the_picture_of_shared_ones() {
    let groups = [(1, bounded(1)), (7, bounded(1000)), (1000, None)];
    split_halos_give_the_same(&[("tensorf/tiny.th", 32), ("ngp/cube.ingp", 64)], &groups);
    split_halos_give_the_same(&[("cairn:tensorf", 512)], &groups[1..2]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn split_halos_give_the_picture_of_shared_ones_for_every_ray_group() {
    let scenes = [
        ("cairn:tensorf", 512),
        ("tensorf/tiny.th", 32),
        ("ngp/cube.ingp", 64),
        ("ngp/cascades.ingp", 64),
        ("cairn:ngp-mvoxel", 512),
    ];
    let groups = [
        (1, bounded(1)),
        (16, bounded(1)),
        (7, bounded(1000)),
        (22, bounded(5000)),
        (1000, None),
    ];
    split_halos_give_the_same(&scenes, &groups);
}

/// Of scenes and their MVoxels' rows, for sides of ray groups and batches.
fn split_halos_give_the_same(scenes: &[(&str, u32)], groups: &[(u32, Option<BatchSize>)]) {
    for &(name, rows) in scenes {
        let mut config = config("");
        config.mvoxel.rows = rows;
        let scene = scene(name, 22);
        let halos = [Halo::Shared, Halo::Split];
        let made = halos.map(|halo| FixedField::with_halo(field(&scene), &config, halo).unwrap());
        let expected = render_made(&made[0], &scene, &config, &FixedOptions::default());
        for &(side, batch) in groups {
            let options = FixedOptions {
                group_side: Some(side),
                batch,
                ..FixedOptions::default()
            };
            let [shared, split] = made
                .each_ref()
                .map(|made| render_made(made, &scene, &config, &options));
            for frame in [&shared, &split] {
                assert_eq!(frame.picture, expected.picture, "{name}, {side}, {batch:?}");
                assert_eq!(frame.transmittance, expected.transmittance);
            }
            let [shared, split] = [shared.stats, split.stats];
            assert_eq!(shared.stopped, split.stopped);
            assert_eq!(shared.outcomes.composited, split.outcomes.composited);
            // Blocks of a hash store nothing twice with either.
            if !name.ends_with("mvoxel") {
                assert_eq!((shared.split_entries, shared.waiting), (0, 0));
                assert!(
                    split.split_entries > 0 && split.waiting > 0,
                    "{name}, {side}"
                );
                assert!(split.streams.partial_sums > 0);
            }
            assert!(split.entries > shared.entries, "{name}, {side}");
            // Of every table, the same samples, once each.
            let samples = |s: &FixedStats| {
                let all = s.orders.iter().map(|o| o.streamed + o.row_by_row);
                all.collect::<Vec<_>>()
            };
            assert_eq!(samples(&shared), samples(&split));
        }
    }
}

/// Tables hashed by MVoxel stream where a batch uses enough of each, and revert
/// where it does not; the picture is the same, and no more rows are loaded than
/// either order needs.
#[test]
fn tables_hashed_by_mvoxel_revert_where_mvoxels_are_under_used() {
    let config = config("");
    let scene = scene("cairn:ngp-mvoxel", 90);
    let large = FixedOptions {
        batch: bounded(usize::MAX),
        ..FixedOptions::default()
    };
    let small = FixedOptions {
        group_side: Some(8),
        batch: bounded(1),
        ..FixedOptions::default()
    };
    let made = FixedField::new(field(&scene), &config).unwrap();
    let [large, small] =
        [large, small].map(|options| render_made(&made, &scene, &config, &options));
    assert_eq!(large.picture, small.picture);
    let reverts = [&large, &small].map(|frame| frame.stats.reverts_from());
    println!("{reverts:?}, {:?}", large.stats.orders);
    // Of a sample a ray, an MVoxel is not worth its rows.
    let hashed = field(&scene).tables().iter().position(|t| t.is_hashed());
    assert_eq!(reverts[1], hashed.map(|first| first + 1));
    assert!(
        reverts[0] > reverts[1] || reverts[0].is_none(),
        "{reverts:?}"
    );
    // Rows that hold no block: no order but one.
    let mut narrow = config.clone();
    narrow.mvoxel.rows = 256;
    let frame = render(&scene, &narrow, &FixedOptions::default());
    assert_eq!(frame.picture, large.picture);
    assert_eq!(frame.stats.reverts_from(), reverts[1]);
}

/// Samples of a frame within the field's box, and those where the field is not
/// known to be empty: one pixel, one axis and one step after another.
fn counted(field: &dyn Field, camera: &Camera) -> [u64; 2] {
    let sampling = field.sampling();
    let [low, high] = sampling.bounds;
    let mut places = vec![DVec3::ZERO; field.tables().len()];
    let [mut within, mut gathered] = [0; 2];
    for pixel in 0..camera.width * camera.height {
        let (x, y) = (pixel % camera.width, pixel / camera.width);
        let (origin, direction) = camera.ray(x, y);
        let ahead = match sampling.along {
            Along::Axis => camera.world_to_camera.transform_vector3(direction).z,
            Along::Ray => 1.0,
        };
        let [mut from, mut to] = sampling.range.map(|depth| depth / ahead);
        for axis in 0..3 {
            let crossed =
                [low[axis], high[axis]].map(|face| (face - origin[axis]) / direction[axis]);
            from = from.max(crossed[0].min(crossed[1]));
            to = to.min(crossed[0].max(crossed[1]));
        }
        let mut k = 0u32;
        while from + f64::from(k) * sampling.step <= to {
            within += 1;
            let at = origin + direction * (from + f64::from(k) * sampling.step);
            gathered += u64::from(field.index(at, &mut places));
            k += 1;
        }
    }
    [within, gathered]
}

/// Every gathered sample has one entry in each table, and its opacity is computed once.
#[test]
fn counts_are_those_of_the_tables() {
    let config = config("");
    let small = 1 << 18;
    // And one with enough samples in a batch that levels hashed by MVoxel stream.
    let streaming = ("cairn:ngp-mvoxel", 90, usize::MAX);
    let all = SCENES.map(|(name, _)| (name, 24, small));
    for (name, side, batch_entries) in all.into_iter().chain([streaming]) {
        let scene = scene(name, side);
        let field = field(&scene);
        let options = FixedOptions {
            terminate: false,
            batch: bounded(batch_entries),
            ..FixedOptions::default()
        };
        let stats = render(&scene, &config, &options).stats;
        let tables = field.tables();
        let [within, samples] = counted(field, scene.camera());
        println!("{name}: {samples} of {within} samples are gathered");
        assert!(samples > 1000 && samples < within);
        assert_eq!(stats.samples, within, "{name}");
        assert_eq!(stats.rays, u64::from(side * side));
        let density = if name.contains("ngp") {
            OpCode::Exp
        } else {
            OpCode::Softplus
        };
        for op in [density, OpCode::OneMinusExp] {
            assert_eq!(stats.vector_elements[&op], samples, "{name}, {op:?}");
        }
        let gathered = stats.orders.iter().map(|o| o.streamed + o.row_by_row);
        assert!(gathered.eq(tables.iter().map(|_| samples)), "{name}");
        if name.ends_with("mvoxel") {
            // An entry in each MVoxel that holds vertices.
            let whole = stats.entries - stats.split_entries;
            let once = samples * tables.len() as u64;
            assert!(whole <= once && once <= stats.entries);
            assert_eq!(whole < once, stats.split_entries > 0);
            assert_eq!(stats.split_entries > 0, batch_entries > small, "{side}");
            assert_eq!(stats.features, 4 * whole);
            assert_eq!(stats.streams.partial_sums, 4 * 4 * stats.split_entries);
            assert_eq!(stats.streams.rit_written, 48 * stats.entries);
            // Some of the larger picture's samples exceed the calibration set.
            assert!(stats.held == 0 || side > 24 && stats.held < samples / 10_000);
            continue;
        }
        assert_eq!(stats.entries, samples * tables.len() as u64, "{name}");
        assert_eq!(stats.features, samples * field.channels() as u64);
        // An id alone, or an id and a weight a vertex.
        let bytes = |vertices: usize| {
            if vertices == 1 {
                4
            } else {
                6 * vertices as u64
            }
        };
        let entry: u64 = tables.iter().map(|t| bytes(t.vertices())).sum();
        assert_eq!(stats.streams.rit_written, samples * entry);
        assert_eq!(
            stats.scattered_bytes > 0,
            tables.iter().any(|t| t.is_hashed())
        );
        assert!(stats.scattered_bytes < stats.streams.mvoxels_read);
        assert_eq!(stats.waves > 0, name.starts_with("tensorf"));
        assert_eq!(
            stats.held, 0,
            "{name}: the calibration set covers the scene"
        );
        // Rays that stop leave samples out.
        let stopping = render(&scene, &config, &FixedOptions::default()).stats;
        assert!(stopping.entries <= stats.entries && stopping.stopped > 0);
    }
}

/// A unit without an operation, or without the vertices of a table.
#[test]
fn configurations_that_do_not_fit_are_refused_by_field() {
    let tensorf = scene("tensorf/tiny.th", 8);
    let ngp = scene("ngp/cube.ingp", 8);
    let refused = |scene: &Scene, text: &str| {
        let config = Config::from_toml(text, "test").unwrap();
        let rendered = scene.render_fixed(&config, &mut ReferenceUnits::new(&config));
        rendered.unwrap_err().to_string()
    };
    let error = refused(&ngp, "");
    assert!(
        error.contains("vu.ops") && error.contains("sigmoid"),
        "{error}"
    );
    let fields = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/fields.toml"),
    )
    .unwrap();
    let with = |text: &str| format!("{text}\n{fields}");
    let error = refused(&tensorf, &with("[gu]\nvertices = [8]\n"));
    assert!(
        error.contains("gu.vertices") && error.contains("4 among them"),
        "{error}"
    );
    let error = refused(&ngp, &with("[gu]\nvertices = [4]\n"));
    assert!(
        error.contains("gu.vertices") && error.contains("8 among them"),
        "{error}"
    );
}
