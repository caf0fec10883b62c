//! The fixed-point renderer against the float one, and against itself.

mod orders;
mod recount;

use potamoi_base::camera::Camera;
use potamoi_formats::config::{Config, SplatOpacity};
use potamoi_formats::units::OpCode;
use potamoi_gaussians::{Cloud, ply};
use potamoi_march::streams::UnitStreams;
use potamoi_reference::{ReferenceUnits, Units};
use potamoi_scene::{camera_file, garden};
use potamoi_splats::{
    Cells, FixedFrame, FixedOptions, Flips, FloatFrame, FloatOptions, Order, Profile,
    ScheduleOptions, render_fixed, render_float,
};

use crate::splats_common::{PlainUnits, shared};

fn fixed(cloud: &Cloud, camera: &Camera, profile: Profile, options: &FixedOptions) -> FixedFrame {
    render_fixed(cloud, camera, profile, options, &mut PlainUnits::default()).unwrap()
}

/// The coarsest grid, its cells as they are.
const APART: Cells = Cells {
    halvings: 0,
    merge: false,
};

const LOG: FixedOptions = FixedOptions {
    schedule: ScheduleOptions {
        rows: 512,
        group_tiles: None,
        cells: Cells::MERGED,
        limits: None,
        opacity: SplatOpacity::Multiplied,
    },
    order: Order::Exact,
    hold_records: 8192,
    unit_streams: UnitStreams::PAPER,
    background: [0.0; 3],
    unit: potamoi_splats::CompositingUnit::VectorUnit,
    log_decisions: true,
    widths: potamoi_splats::Widths::PAPER,
    work: potamoi_splats::Work::ALL,
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

/// The accuracy that the formats allow: 80 dB over the frame, 78 over covered pixels.
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
    let counted = float.stats.unwrap();
    println!(
        "{name}, {profile}: {frame:.1} dB over the frame, {covered:.1} dB over covered pixels, \
         {} of {} skips and {} of {} stops flipped",
        flips.skip, counted.exponentials, flips.stop, counted.stopped
    );
    assert!(frame >= 80.0, "{name}: {frame} dB");
    assert!(covered >= 78.0, "{name}: {covered} dB");
    // Decisions flip only where values lie within rounding of a limit.
    assert!(flips.skip * 2000 < counted.exponentials, "{flips:?}");
    assert!(flips.stop * 20 <= counted.stopped, "{flips:?}");
    // The counts are the frame's.
    assert_eq!(fixed.stats.gathers, counted.entries);
    assert_eq!(fixed.stats.streams.rit_written, 4 * counted.entries);
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
    let camera = camera_file::read(&file, &mut potamoi_base::file_keys::Notes::default()).unwrap()
        [0]
    .camera
    .resized(400, 400);
    let config = Config::paper();
    for name in ["playbot_8k", "playbot_31k"] {
        let cloud = ply::read(&data.join(format!("splats/{name}.ply")))
            .unwrap()
            .cloud;
        let mut units = ReferenceUnits::new(&config);
        hold_to_float(name, &cloud, &camera, Profile::Inria, &mut units);
        assert_eq!(units.gather_flags(), 0);
    }
}

fn small() -> (Cloud, Camera) {
    (garden::cloud(), garden::camera().resized(90, 60))
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
