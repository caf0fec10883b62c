//! The fixed-point renderer held to the float one, and to itself.
#![allow(clippy::unwrap_used, clippy::panic)]

mod splats_common;

use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;
use potamoi_golden::camera::Camera;
use potamoi_golden::scene::{camera_file, garden};
use potamoi_golden::splats::{
    Cloud, FixedFrame, FixedOptions, Flips, FloatFrame, FloatOptions, Order, Profile,
    ScheduleOptions, ply, render_fixed, render_float, tasks,
};
use potamoi_golden::streams::RitReads;
use potamoi_golden::units::{Twins, Units};
use splats_common::{PlainUnits, shared};

fn fixed(cloud: &Cloud, camera: &Camera, profile: Profile, options: &FixedOptions) -> FixedFrame {
    render_fixed(cloud, camera, profile, options, &mut PlainUnits::default()).unwrap()
}

const LOG: FixedOptions = FixedOptions {
    schedule: ScheduleOptions {
        rows: 512,
        group_tiles: None,
        merge: true,
    },
    order: Order::Exact,
    hold_records: 8192,
    rit_reads: RitReads::PAPER,
    background: [0.0; 3],
    log_decisions: true,
};

fn both(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    units: &mut dyn Units,
) -> (FloatFrame, FixedFrame, Flips) {
    let float = FloatOptions {
        log_decisions: true,
        ..FloatOptions::default()
    };
    let float = render_float(cloud, camera, profile, &float).unwrap();
    let fixed = render_fixed(cloud, camera, profile, &LOG, units).unwrap();
    let flips = fixed
        .decisions
        .as_ref()
        .and_then(|d| d.flips(float.decisions.as_ref()?))
        .unwrap();
    (float, fixed, flips)
}

/// The formats' promise: 80 dB over the frame, 78 over covered pixels.
fn hold_to_float(
    name: &str,
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    units: &mut dyn Units,
) {
    let (float, fixed, flips) = both(cloud, camera, profile, units);
    let frame = fixed.picture.psnr(&float.picture, |_| true).unwrap();
    let covered = fixed
        .picture
        .psnr(&float.picture, |i| float.transmittance[i] < 1.0)
        .unwrap();
    println!(
        "{name}, {profile}: {frame:.1} dB over the frame, {covered:.1} dB over covered pixels, \
         {} of {} skips and {} of {} stops flipped",
        flips.skip, float.stats.exponentials, flips.stop, float.stats.stopped
    );
    assert!(frame >= 80.0, "{name}: {frame} dB");
    assert!(covered >= 78.0, "{name}: {covered} dB");
    // Decisions flip only where values lie within rounding of a limit.
    assert!(flips.skip * 2000 < float.stats.exponentials, "{flips:?}");
    assert!(flips.stop * 20 <= float.stats.stopped, "{flips:?}");
    // The counts are the frame's.
    assert_eq!(fixed.stats.gathers, float.stats.entries);
    assert_eq!(fixed.stats.streams.rit_written, 4 * float.stats.entries);
    let elements = &fixed.stats.vector_elements;
    assert_eq!(elements[&OpCode::Exp], fixed.stats.exponentials);
    assert_eq!(elements[&OpCode::SquareSum], fixed.stats.exponentials);
    assert_eq!(
        elements[&OpCode::Multiply],
        fixed.stats.exponentials + fixed.stats.drawn
    );
}

#[test]
fn the_garden_stays_within_the_formats_promise() {
    let (cloud, camera) = (garden::cloud(), garden::camera());
    for profile in [Profile::Inria, Profile::Gsplat, Profile::Brush] {
        let camera = camera.resized(160, 120);
        hold_to_float(
            "garden",
            &cloud,
            &camera,
            profile,
            &mut PlainUnits::default(),
        );
    }
}

/// Both published scenes at 400 x 400, through the units' twins in the default
/// formats.
#[test]
fn playbot_stays_within_the_formats_promise() {
    let Some(data) = shared() else {
        println!("skipped: playbot: no shared data (set POTAMOI_SHARED)");
        return;
    };
    let file = data.join("cameras/camera_playbot_31k_800.json");
    let camera = camera_file::read(&file).unwrap()[0]
        .camera
        .resized(400, 400);
    let config = Config::paper();
    for name in ["playbot_8k", "playbot_31k"] {
        let cloud = ply::read(&data.join(format!("splats/{name}.ply"))).unwrap();
        let mut units = Twins::new(&config);
        hold_to_float(name, &cloud, &camera, Profile::Inria, &mut units);
        assert_eq!(units.gather_flags(), 0);
    }
}

fn small() -> (Cloud, Camera) {
    (garden::cloud(), garden::camera().resized(90, 60))
}

#[test]
fn the_picture_depends_on_neither_groups_nor_mvoxels() {
    let (cloud, camera) = small();
    let whole = fixed(&cloud, &camera, Profile::Inria, &LOG);
    for (rows, group_tiles, merge) in [
        (512, Some([1, 1]), true),
        (512, Some([1, 1]), false),
        (64, Some([4, 3]), true),
        (64, None, false),
        (7, None, true),
        (65536, None, true),
    ] {
        let options = FixedOptions {
            schedule: ScheduleOptions {
                rows,
                group_tiles,
                merge,
            },
            hold_records: 10,
            ..LOG
        };
        let other = fixed(&cloud, &camera, Profile::Inria, &options);
        assert_eq!(other.picture, whole.picture, "{rows} {group_tiles:?}");
        assert_eq!(other.transmittance, whole.transmittance);
        assert_eq!(other.decisions, whole.decisions);
        assert_eq!(other.stats.gathers, whole.stats.gathers);
        assert_eq!(other.stats.exponentials, whole.stats.exponentials);
        // One MVoxel needs nothing held back.
        assert_eq!(other.stats.hold.spilled > 0, rows != 65536);
    }
}

#[test]
fn any_permutation_gives_the_same_bits_even_in_depth_ties() {
    let (cloud, camera) = small();
    // Every Gaussian twice, the second in another colour: exact depth ties.
    let n = cloud.len();
    let order: Vec<usize> = (0..n).chain(0..n).collect();
    let twice = cloud.select(&order).unwrap();
    let sh = (0..2 * n)
        .flat_map(|i| {
            twice
                .sh(i)
                .iter()
                .map(move |c| c.map(|v| if i < n { v } else { 0.3 - v }))
        })
        .collect();
    let twice = Cloud::new(
        twice.degree(),
        twice.means().to_vec(),
        twice.log_scales().to_vec(),
        twice.rotations().to_vec(),
        twice.opacity_logits().to_vec(),
        sh,
    )
    .unwrap();
    let reversed: Vec<usize> = (0..2 * n).rev().collect();
    let strided: Vec<usize> = (0..2 * n).map(|i| (i * 7919) % (2 * n)).collect();
    assert!(!(2 * n).is_multiple_of(7919));
    for order in [Order::Exact, Order::Approximate] {
        let options = FixedOptions { order, ..LOG };
        let plain = fixed(&twice, &camera, Profile::Inria, &options);
        let float = render_float(&twice, &camera, Profile::Inria, &FloatOptions::default());
        let float = float.unwrap();
        for permutation in [&reversed, &strided] {
            let other = twice.select(permutation).unwrap();
            assert_eq!(fixed(&other, &camera, Profile::Inria, &options), plain);
            let again = render_float(&other, &camera, Profile::Inria, &FloatOptions::default());
            assert_eq!(again.unwrap(), float);
        }
    }
    // The tie-break matters: file order would have shown.
    let naive = |c: &Cloud| {
        let mut depth: Vec<(f32, usize)> = c.means().iter().map(|m| (m[2], 0)).collect();
        depth.iter_mut().enumerate().for_each(|(i, d)| d.1 = i);
        depth.sort_by(|a, b| a.0.total_cmp(&b.0));
        depth.iter().map(|d| c.sh(d.1)[0]).collect::<Vec<_>>()
    };
    assert_ne!(naive(&twice), naive(&twice.select(&reversed).unwrap()));
}

#[test]
fn the_approximate_order_is_counted_and_shows() {
    let (cloud, camera) = small();
    let exact = fixed(&cloud, &camera, Profile::Inria, &LOG);
    let options = FixedOptions {
        order: Order::Approximate,
        ..LOG
    };
    let loose = fixed(&cloud, &camera, Profile::Inria, &options);
    assert_eq!(exact.stats.inversions, 0);
    assert!(loose.stats.inversions > 0);
    assert_eq!(loose.stats.gathers, exact.stats.gathers);
    let psnr = loose.picture.psnr(&exact.picture, |_| true).unwrap();
    assert!(psnr > 15.0 && psnr < 80.0, "{psnr}");
    // With a single MVoxel, arrival is rank order.
    let one = FixedOptions {
        schedule: ScheduleOptions {
            rows: 65536,
            group_tiles: None,
            merge: true,
        },
        ..options
    };
    let one = fixed(&cloud, &camera, Profile::Inria, &one);
    assert_eq!((one.stats.inversions, one.picture), (0, exact.picture));
}

#[test]
fn tasks_alone_are_what_rendering_gathers() {
    let (cloud, camera) = small();
    let options = ScheduleOptions {
        rows: 100,
        group_tiles: Some([3, 2]),
        merge: true,
    };
    let groups = tasks(&cloud, &camera, Profile::Inria, &options).unwrap();
    let mut units = PlainUnits::default();
    let fixed_options = FixedOptions {
        schedule: options,
        ..LOG
    };
    let frame = render_fixed(&cloud, &camera, Profile::Inria, &fixed_options, &mut units).unwrap();
    let all: Vec<_> = groups.iter().flat_map(|g| &g.tasks).collect();
    assert_eq!(frame.stats.tasks, all.len() as u64);
    let entries: usize = all.iter().map(|t| t.entries.len()).sum();
    assert_eq!(frame.stats.gathers, entries as u64);
    let rows: Vec<usize> = all.iter().map(|t| t.rows.len() / 16).collect();
    assert_eq!(units.loaded, rows);
    for group in &groups {
        assert!(group.mvoxels.is_sorted_by_key(|m| m.min_rank));
        for (task, mvoxel) in group.tasks.iter().zip(&group.mvoxels) {
            let used: std::collections::BTreeSet<u16> =
                task.entries.iter().map(|e| e.rows[0]).collect();
            // Only used rows are loaded, and no more than fit.
            assert_eq!(used.len(), task.rows.len() / 16);
            assert!(used.len() <= 100);
            assert!(
                task.entries
                    .iter()
                    .all(|e| (e.slot as usize) < group.tiles.len())
            );
            let first = u32::from(task.rows[14] as u16) | u32::from(task.rows[15] as u16) << 16;
            assert_eq!(first, mvoxel.min_rank);
        }
    }
}

#[test]
fn the_background_fills_what_is_left() {
    let (cloud, camera) = small();
    let black = fixed(&cloud, &camera, Profile::Inria, &LOG);
    let options = FixedOptions {
        background: [1.0, 0.5, 0.0],
        ..LOG
    };
    let lit = fixed(&cloud, &camera, Profile::Inria, &options);
    for (i, left) in black.transmittance.iter().enumerate() {
        let left = *left as f32 / 1_048_576.0;
        let expected = [left, left * 0.5, 0.0];
        for c in 0..3 {
            let more = lit.picture.rgb[i][c] - black.picture.rgb[i][c];
            assert!((more - expected[c]).abs() < 1e-6);
        }
    }
}

/// Gaussians one behind the other that fill the frame evenly.
fn layers(n: usize, logit: f32) -> Cloud {
    Cloud::new(
        0,
        (0..n)
            .map(|i| [0.0, 0.0, 1.0 + i as f32 / n as f32])
            .collect(),
        vec![[10.0; 3]; n],
        vec![[1.0, 0.0, 0.0, 0.0]; n],
        vec![logit; n],
        vec![[0.886_226_9, -0.886_226_9, 0.0]; n],
    )
    .unwrap()
}

#[test]
fn weights_and_what_is_left_sum_to_exactly_one() {
    let camera = Camera::look_at(
        glam::DVec3::ZERO,
        glam::DVec3::Z,
        glam::DVec3::NEG_Y,
        0.9,
        16,
        16,
    );
    // Alpha of 1/200: 4,096 layers, of which some 1,800 are drawn.
    let cloud = layers(4096, -(199f32.ln()));
    let (float, fixed, _) = both(&cloud, &camera, Profile::Inria, &mut PlainUnits::default());
    let drawn = fixed.stats.drawn / 256;
    assert!((1500..4096).contains(&drawn), "{drawn}");
    for (i, left) in fixed.transmittance.iter().enumerate() {
        // Every channel is the same at every layer, so the picture is exactly
        // (1 - T) times it: an integer identity, read from 32 fraction bits.
        let gone = f64::from((1u32 << 20) - left) / f64::from(1u32 << 20);
        for (c, code) in [(0, 3072.0), (1, 1024.0), (2, 2048.0)] {
            assert_eq!(fixed.picture.rgb[i][c], (gone * code / 4096.0) as f32);
        }
    }
    // T is a product of rounded factors: n (2^-17 T + 2^-21) at most, and
    // summed over a falling T well below 2,000 x 2^-21 + max(n T) 2^-17.
    let mut exact = 1.0f64;
    let mut naive = 65536u64;
    let (mut worst, mut worst_naive) = (0.0f64, 0.0f64);
    let mut held = 1u64 << 20;
    let alpha = (65536.0f64 / 200.0).round() as u64;
    for _ in 0..drawn {
        exact *= 1.0 - 1.0 / 200.0;
        held = (held * (65536 - alpha) + (1 << 15)) >> 16;
        naive = (naive * (65536 - alpha)) >> 16;
        worst = worst.max((held as f64 / f64::from(1 << 20) - exact).abs());
        worst_naive = worst_naive.max((naive as f64 / 65536.0 - exact).abs());
    }
    let bound = 200.0 * 2f64.powi(-21) + 200.0 * 2f64.powi(-17) / std::f64::consts::E;
    assert!(worst < bound, "{worst} {bound}");
    // Cut off at 16 bits it falls short by a layer's worth, and the bound is
    // broken.
    assert!(worst_naive > bound, "{worst_naive} {bound}");
    let off =
        (f64::from(fixed.transmittance[0]) / f64::from(1 << 20) - float.transmittance[0]).abs();
    assert!(off < bound, "{off}");
}

/// A second layer at the cap would leave less than 1e-4 and is not drawn. The
/// exact product says so; rounded to U1.20, 105 codes, it is above.
#[test]
fn pixels_stop_by_the_exact_product() {
    let (eye, ahead) = (glam::DVec3::ZERO, glam::DVec3::Z);
    let camera = Camera::look_at(eye, ahead, glam::DVec3::NEG_Y, 0.9, 16, 16);
    for (profile, cap) in [(Profile::Inria, 64_881), (Profile::Gsplat, 65_470)] {
        let frame = fixed(&layers(5, f32::INFINITY), &camera, profile, &LOG);
        assert_eq!((frame.stats.drawn, frame.stats.stopped), (256, 256));
        // 16 bits of alpha to 20 of T.
        let left = (65_536 - cap) << 4;
        assert!(frame.transmittance.iter().all(|t| *t == left), "{profile}");
    }
}

#[test]
fn giants_and_far_means_keep_their_promise() {
    // Needles and discs far larger than the frame, seen at a slant, some with
    // means hundreds of frames aside.
    let n = 60;
    let means = (0..n)
        .map(|i| {
            let i = i as f32;
            [
                (i * 1.7).sin() * 40.0,
                (i * 0.9).cos() * 25.0,
                3.0 + 0.2 * i,
            ]
        })
        .collect();
    let scales = (0..n).map(|i| [3.0, -6.0 + 0.1 * i as f32, 2.0]).collect();
    let rotations = (0..n)
        .map(|i| {
            let i = i as f32;
            [i.sin(), (2.0 * i).cos(), 0.3, (3.0 * i).sin()]
        })
        .collect();
    let sh = (0..n)
        .map(|i| [0.02 * i as f32, 0.5, -0.01 * i as f32])
        .collect();
    let cloud = Cloud::new(0, means, scales, rotations, vec![-1.0; n], sh).unwrap();
    let camera = Camera::look_at(
        glam::DVec3::ZERO,
        glam::DVec3::Z,
        glam::DVec3::NEG_Y,
        0.9,
        64,
        64,
    );
    let (float, fixed, _) = both(&cloud, &camera, Profile::Inria, &mut PlainUnits::default());
    assert_eq!(fixed.stats.saturations.total(), 0);
    assert!(float.transmittance.iter().filter(|t| **t < 0.5).count() > 1000);
    let psnr = fixed.picture.psnr(&float.picture, |_| true).unwrap();
    assert!(psnr >= 78.0, "{psnr}");
}

#[test]
fn units_that_return_too_little_are_found_out() {
    struct Forgetful(PlainUnits);
    impl potamoi_golden::units::Units for Forgetful {
        fn gather(
            &mut self,
            tasks: &[potamoi_golden::units::GatherTask],
            features: &mut Vec<i16>,
        ) -> Result<(), potamoi_golden::units::UnitError> {
            self.0.gather(tasks, features)?;
            features.pop();
            Ok(())
        }
        fn vector(
            &mut self,
            op: potamoi_formats::units::VectorOp,
            a: &[i32],
            b: &[i32],
            out: &mut [i32],
        ) -> Result<(), potamoi_golden::units::UnitError> {
            self.0.vector(op, a, b, out)
        }
    }
    let (cloud, camera) = small();
    let mut units = Forgetful(PlainUnits::default());
    let failed = render_fixed(&cloud, &camera, Profile::Inria, &LOG, &mut units);
    assert!(failed.unwrap_err().to_string().contains("feature channels"));
}

#[test]
fn options_out_of_range_are_refused() {
    let (cloud, camera) = small();
    let refused = |schedule: ScheduleOptions, camera: &Camera| {
        let options = FixedOptions { schedule, ..LOG };
        let r = render_fixed(
            &cloud,
            camera,
            Profile::Inria,
            &options,
            &mut PlainUnits::default(),
        );
        r.unwrap_err().to_string()
    };
    let plain = ScheduleOptions::default();
    assert!(refused(ScheduleOptions { rows: 0, ..plain }, &camera).contains("`rows`"));
    let none = Some([0, 4]);
    assert!(
        refused(
            ScheduleOptions {
                group_tiles: none,
                ..plain
            },
            &camera
        )
        .contains("group_tiles")
    );
    let wide = camera.resized(8192, 4096);
    assert!(refused(plain, &wide).contains("131072 tiles"));
}
