#![allow(clippy::unwrap_used)]

use std::sync::atomic::{AtomicU64, Ordering};

use potamoi_base::effects::{Choices, Effect};
use potamoi_base::mask::Mask;
use potamoi_base::precision::Precision;
use potamoi_cycles::batch::{Batch, Pricing};
use potamoi_cycles::frame_meter::{FrameMeter, GatherSums};
use potamoi_cycles::mac_array::MacArray;
use potamoi_formats::config::Config;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::observer::{Observer, VectorCall};
use potamoi_reference::{Product, ReferenceUnits};
use potamoi_scene::Scene;
use potamoi_warp::Profile;
use proptest::prelude::*;

use super::*;

const CACHE: u32 = 512 * 1024;

fn scene(name: &str, width: u32) -> Scene {
    let mut scene = Scene::open(name).unwrap();
    scene.set_size(Some(width), Some(width)).unwrap();
    scene
}

/// What the units did is what the renderer counts, and each byte is in a stream.
#[test]
fn counts_are_those_of_the_renderer() {
    let config = Config::paper();
    for name in ["garden", "lantern"] {
        let scene = scene(name, 40);
        let rendered = scene
            .render_fixed(&config, &mut ReferenceUnits::new(&config))
            .unwrap();
        let (counts, streams) = (&rendered.counts, &rendered.counts.streams);
        let work = FrameWork::count(&scene, &config, MacArray::PAPER, CACHE, None).unwrap();
        let total = work.total();
        assert_eq!(work.pixels, 1600);
        assert_eq!(total.mvoxels, counts.mvoxels, "{name}");
        assert_eq!(total.entries, counts.feature_vectors, "{name}");
        assert_eq!(
            total.elements,
            counts.elements.values().sum::<u64>(),
            "{name}"
        );
        assert_eq!(total.row_bytes, streams.mvoxels_read, "{name}");
        assert_eq!(total.rit_bytes, streams.rit_written, "{name}");
        assert_eq!(total.rit_read_bytes, streams.rit_read, "{name}");
        assert_eq!(total.feature_bytes, streams.features, "{name}");
        assert!(total.gather_busy <= total.gather_cycles && total.gather_busy > 0);
        assert!(total.vector_busy <= total.vector_cycles && total.vector_busy > 0);
        // No operation is faster than all multipliers.
        assert!(
            total.macs > 0 && total.macs <= total.array_cycles * 24 * 24,
            "{name}"
        );
        assert!(work.reads.reads >= work.reads.misses && work.reads.misses > 0);
        assert!(work.reads.sectors * 32 >= work.reads.bytes);
    }
}

/// Sums of entries that lie in several `MVoxel`s, where none keeps a halo, go out and come back.
#[test]
fn partial_sums_go_out_and_back() {
    let config = Config::paper();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("split.toml");
    let text = "[model]\nkind = \"builtin\"\nname = \"lantern\"\n[render]\nhalo = \"split\"\n";
    std::fs::write(&path, text).unwrap();
    let scene = scene(path.to_str().unwrap(), 24);
    let rendered = scene
        .render_fixed(&config, &mut ReferenceUnits::new(&config))
        .unwrap();
    let streams = rendered.counts.streams;
    assert!(streams.partial_sums > 0);
    let work = FrameWork::count(&scene, &config, MacArray::PAPER, CACHE, None).unwrap();
    let spilled = streams.spills + 2 * streams.partial_sums;
    assert_eq!(work.spilled_bytes, spilled);
}

/// The formulas' sums: vertices are read in just the cycles in which the unit issues, and neither
/// sum is more than it takes.
#[test]
fn sums_are_no_more_than_the_unit_takes() {
    let config = Config::paper();
    for name in ["garden", "lantern"] {
        let through = &mut ReferenceUnits::new(&config);
        let scene = scene(name, 40);
        let Counted { work, sums, .. } =
            FrameWork::rendered(&scene, &config, MacArray::PAPER, CACHE, None, through).unwrap();
        let total = work.total();
        assert_eq!(sums.reads, total.gather_busy, "{name}");
        assert_eq!(sums.cycles(), sums.reads.max(sums.loads));
        assert!(sums.cycles() < total.gather_cycles, "{name}");
        assert!(sums.reads + sums.loads > total.gather_cycles / 2, "{name}");
        let formulas = work.as_one_sum(sums, &config).unwrap().total();
        assert_eq!(formulas.gather_cycles, sums.cycles());
        assert_eq!(formulas.vector_cycles, total.vector_busy);
    }
}

/// A frame of some pixels asks for less, and of all of them for as much.
#[test]
fn a_mask_asks_for_its_pixels() {
    let config = Config::paper();
    for name in ["garden", "lantern"] {
        let scene = scene(name, 40);
        let count = |only: Option<&Mask>| {
            FrameWork::count(&scene, &config, MacArray::PAPER, CACHE, only).unwrap()
        };
        let all = count(None);
        assert_eq!(count(Some(&Mask::new([40, 40], |_| true))), all, "{name}");
        let few = count(Some(&Mask::new([40, 40], |i| i % 40 < 3)));
        assert_eq!(few.pixels, 120);
        let (few, all) = (few.total(), all.total());
        assert!(few.entries * 2 < all.entries, "{name}");
        assert!(few.vector_cycles * 2 < all.vector_cycles, "{name}");
        assert!(few.macs * 2 < all.macs, "{name}");
    }
}

/// Frames that are rendered otherwise are counted by themselves.
#[test]
fn a_manner_of_its_own_is_kept_by_itself() {
    let config = Config::paper();
    let folder = tempfile::tempdir().unwrap();
    let kept = WorkCache::new(folder.path());
    let array = MacArray::PAPER;
    let plain = scene("lantern", 24);
    let mut farther = plain.clone();
    farther.set_step(1.0).unwrap();
    let mut sooner = plain.clone();
    let precision = Precision {
        stop_below: Some(0.1),
        ..Precision::default()
    };
    sooner.set_precision(precision).unwrap();
    for scene in [&plain, &farther, &sooner] {
        let (work, was_kept) = kept.frame(scene, &config, array, CACHE).unwrap();
        assert!(!was_kept);
        let (counted, _) = WorkCache::new(tempfile::tempdir().unwrap().path())
            .frame(scene, &config, array, CACHE)
            .unwrap();
        assert_eq!(work, counted);
        assert!(kept.frame(scene, &config, array, CACHE).unwrap().1);
    }
}

/// A path is what its frames are, and is kept.
#[test]
fn a_path_is_counted_once() {
    let config = Config::paper();
    let folder = tempfile::tempdir().unwrap();
    let scene = scene("lantern", 24);
    let options = PathOptions {
        frames: 5,
        fps: 30.0,
        window: 3,
        phi: None,
        profile: Profile::Potamoi,
        array: [24, 24],
        is_double_buffered: false,
        cache: CACHE,
        parts: PathParts::All,
    };
    let steps = AtomicU64::new(0);
    let count = || {
        WorkCache::new(folder.path())
            .path(&scene, &config, &options, &|| {
                steps.fetch_add(1, Ordering::Relaxed);
            })
            .unwrap()
    };
    let (path, was_kept) = count();
    assert!(!was_kept);
    assert_eq!(steps.load(Ordering::Relaxed), PathWork::steps(&options));
    assert_eq!(
        (
            path.targets.len(),
            path.chained.len(),
            path.references.len()
        ),
        (5, 5, 2)
    );
    assert_eq!(path.reference_frames[0], (Some(0), 0));
    for target in path.targets.iter().chain(&path.chained) {
        assert_eq!(target.classes.pixels(), 24 * 24);
        match (&target.work, target.reference) {
            (Some(work), Some(_)) => assert_eq!(work.pixels, target.classes.rendered),
            (None, Some(_)) => assert_eq!(target.classes.rendered, 0),
            (work, None) => assert!(work.is_none() && target.classes.rendered == 24 * 24),
        }
    }
    assert!((0..4).all(|i| 4 * path.half(i).frame_pixels == path.full(i).frame_pixels));
    // Full frames are the model's own; warped ones are nearer to it than half the resolution.
    assert_eq!(path.full_quality.full_db, None);
    assert!(path.warped_quality.full_db > path.half_quality.full_db);
    let (again, was_kept) = count();
    assert!(was_kept && again == path);
    // What was damaged is counted again.
    let files = std::fs::read_dir(folder.path()).unwrap();
    let mut files = files.map(|file| file.unwrap().path());
    let is_path = |file: &std::path::PathBuf| {
        file.file_name()
            .unwrap()
            .to_string_lossy()
            .starts_with("path-")
    };
    std::fs::write(files.find(is_path).unwrap(), "{").unwrap();
    assert!(!count().1);
    // Another GPU, array, clock and vector unit render nothing again, and are counted as if they had.
    let other = PathOptions {
        array: [16, 32],
        is_double_buffered: true,
        cache: 1 << 10,
        ..options
    };
    let text = "clock_ghz = 0.5\n[vu]\nlanes = 7\n[vu.exp]\npipelined = true\n";
    let units = Config::from_toml(text, "test").unwrap();
    let kept = WorkCache::new(folder.path())
        .path(&scene, &units, &other, &|| ())
        .unwrap();
    assert!(kept.1);
    let anew = PathWork::count(&scene, &units, &other, &|| ()).unwrap();
    assert_eq!(kept.0, anew);
    assert_ne!(kept.0.references[0].reads, path.references[0].reads);
    assert_ne!(kept.0.references[0].total(), path.references[0].total());
    // Other ports are counted again, with the pictures and reads that are kept.
    let ports = Config::from_toml("[gu]\nports = 1\n", "test").unwrap();
    steps.store(0, Ordering::Relaxed);
    let counted = WorkCache::new(folder.path())
        .path(&scene, &ports, &options, &|| {
            steps.fetch_add(1, Ordering::Relaxed);
        })
        .unwrap();
    assert!(!counted.1);
    // Two references in full and at half the resolution, and each frame warped in two ways.
    assert_eq!(steps.load(Ordering::Relaxed), 2 * 2 + 2 * 5);
    let anew = PathWork::count(&scene, &ports, &options, &|| ()).unwrap();
    assert_eq!(counted.0, anew);
    // A configuration that cannot render the scene is refused before anything is rendered.
    let text = "[vu]\nops = [\"pass\", \"relu\", \"add\", \"multiply\", \"exp\"]\n";
    let less = Config::from_toml(text, "test").unwrap();
    let empty = tempfile::tempdir().unwrap();
    steps.store(0, Ordering::Relaxed);
    let refused = WorkCache::new(empty.path()).path(&scene, &less, &options, &|| {
        steps.fetch_add(1, Ordering::Relaxed);
    });
    assert!(refused.unwrap_err().to_string().contains("one-minus-exp"));
    assert_eq!(steps.load(Ordering::Relaxed), 0);
    let wider = PathOptions {
        window: 5,
        ..options
    };
    assert!(
        !WorkCache::new(folder.path())
            .path(&scene, &config, &wider, &|| ())
            .unwrap()
            .1
    );
}

#[test]
fn products_are_counted_as_the_array_does_them() {
    let config = Config::paper();
    let mut meter = FrameMeter::new(&config);
    let product = Product {
        rows: 4096,
        depth: 39,
        columns: 128,
    };
    meter.multiplied(&product);
    let pricing = Pricing::new(&config, MacArray::PAPER).unwrap();
    let events = meter.into_events();
    let batches: Vec<Batch> = events.iter().map(|own| own.priced(&pricing)).collect();
    let expected = Batch {
        products: 1,
        macs: 4096 * 39 * 128,
        array_cycles: 49_992,
        // Six folds of columns, two of rows.
        input_bytes: 2 * 4096 * 39 * 6,
        weight_bytes: 2 * 576 * 12,
        output_bytes: 2 * 4096 * 128,
        // Sums of 32 bits that the first fold of rows hands to the second.
        partial_bytes: 4 * 4096 * 128,
        ..Batch::default()
    };
    assert_eq!(batches, [expected]);
}

/// Operands and results of 32 bits: two are read of a sum, one of an exponential.
#[test]
fn operands_and_results_are_counted() {
    let config = Config::paper();
    let mut meter = FrameMeter::new(&config);
    for (code, b) in [(OpCode::Add, &[1; 30][..]), (OpCode::Exp, &[0; 30][..])] {
        let op = VectorOp::new(code);
        let [a, out] = [&[1000; 30], &[0; 30]];
        meter.computed(&VectorCall { op, a, b, out }).unwrap();
    }
    let pricing = Pricing::new(&config, MacArray::PAPER).unwrap();
    let events = meter.into_events();
    let batches: Vec<Batch> = events.iter().map(|own| own.priced(&pricing)).collect();
    let bytes = (batches[0].operand_bytes, batches[0].result_bytes);
    assert_eq!((batches.len(), bytes), (1, (4 * 30 * 3, 4 * 30 * 2)));
}

proptest! {
    #[test]
    fn parts_are_the_whole(counts in prop::collection::vec(0u64..1 << 40, 6), number in 1u64..50) {
        let whole = Batch {
            runs: counts[0],
            entries: counts[1],
            gather_cycles: counts[2],
            feature_bytes: counts[3],
            macs: counts[4],
            output_bytes: counts[5],
            ..Batch::default()
        };
        let mut sum = Batch::default();
        let parts: Vec<Batch> = whole.parts(number).collect();
        prop_assert_eq!(parts.len() as u64, number);
        parts.iter().for_each(|part| sum += *part);
        prop_assert_eq!(sum, whole);
        let bytes = parts.iter().map(|p| p.feature_bytes);
        prop_assert!(bytes.clone().max().unwrap() - bytes.min().unwrap() <= 1);
    }
}

/// Factors of conics that 16 bits hold take one pass of the array instead of two; coefficients that
/// are left out are counted.
#[test]
fn narrow_conics_and_fewer_harmonics_are_less_work() {
    let config = Config::paper();
    let mut scene = Scene::open("garden").unwrap();
    scene.set_size(Some(40), Some(40)).unwrap();
    let count = |scene: &Scene| {
        let mut twins = ReferenceUnits::new(&config);
        FrameWork::rendered(scene, &config, MacArray::PAPER, 512 << 10, None, &mut twins)
            .unwrap()
            .work
    };
    let own = count(&scene);
    let mut narrow = scene.clone();
    let at = |bits| Precision {
        conic_bits: Some(bits),
        ..Precision::default()
    };
    narrow.set_precision(at(14)).unwrap();
    let macs = |work: &FrameWork| work.total().macs as f64;
    assert!((macs(&count(&narrow)) / macs(&own) - 0.5).abs() < 0.01);
    narrow.set_precision(at(15)).unwrap();
    assert!((macs(&count(&narrow)) / macs(&own) - 1.0).abs() < 0.01);
    assert_eq!(own.left_out_coefficients, 0);
    let highest = scene.facts().highest_harmonic() as u8;
    assert!(highest > 0);
    let without = Effect::SphericalHarmonics(highest);
    scene.set_choices(Choices::default().leave_out(without));
    let left_out = 3 * (2 * u64::from(highest) + 1);
    assert_eq!(count(&scene).left_out_coefficients, left_out);
}

/// Splat units composite instead of vector unit and array: a job a ray group, whose records are the
/// gathered ones; two units take little more than half of the time, and the same cycles.
#[test]
fn splat_units_do_the_compositing() {
    let scene = scene("garden", 72);
    let config = |units: u32| {
        let text =
            format!("[vu.exp]\npipelined = true\n[su]\nlanes = 1\ntiles = 4\nunits = {units}\n");
        Config::from_toml(&text, "test").unwrap()
    };
    let count = |units: u32| {
        FrameWork::count(&scene, &config(units), MacArray::PAPER, CACHE, None).unwrap()
    };
    let [one, two] = [1, 2].map(count);
    let (total, side_by_side) = (one.total(), two.total());
    // 5 x 5 tiles in groups of 2 x 2.
    assert_eq!(total.splat_jobs, 9);
    // A group without a Gaussian begins no batch.
    assert!((4..=9).contains(&one.batches.len()));
    assert_eq!(total.splat_records, total.entries);
    assert_eq!(total.splat_pixels, 25 * 256);
    assert_eq!((total.vector_cycles, total.array_cycles), (0, 0));
    let pairs = one.pixel_pairs.unwrap();
    assert_eq!(total.splat_counted, pairs.pairs_drawn + pairs.pairs_stopped);
    assert!(total.splat_cycles > total.splat_square_sums && total.splat_counted > 1_000);
    assert_eq!(total.splat_elapsed, total.splat_cycles);
    assert_eq!(side_by_side.splat_cycles, total.splat_cycles);
    let share = side_by_side.splat_elapsed as f64 / total.splat_cycles as f64;
    let formulas = one.as_one_sum(GatherSums::default(), &config(1)).unwrap();
    let formulas = formulas.total().splat_cycles as f64 / total.splat_cycles as f64;
    assert!((0.8..=1.0).contains(&formulas), "{formulas}");
    assert!((0.5..0.75).contains(&share), "{share}");
}
