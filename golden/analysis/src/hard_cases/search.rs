//! Randomised searches for further hard cases: adversarial Gaussians, rotations, weights, depths
//! and poses. Failures are kept in golden/proptest-regressions and tried first afterwards.
#![allow(clippy::unwrap_used, clippy::panic)]

use glam::{DAffine3, DQuat, DVec2, DVec3};
use potamoi_formats::config::Config;
use proptest::prelude::*;

use super::accumulators;
use super::exact::exact;
use super::projection::turned;
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_gaussians::{Cloud, rotation};
use potamoi_reference::ReferenceUnits;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_reference::weights::trilinear;
use potamoi_splats::{
    FixedOptions, FloatOptions, Footprint, Profile, View, render_fixed, render_float,
};
use potamoi_warp::{Shaded, reproject};

/// What a configuration's gathering unit makes of one feature.
fn gathered(config: &str, codes: &[i16; 8], weights: [u16; 8]) -> i16 {
    let config = Config::from_toml(config, "hard case").unwrap();
    accumulators::gathered(&ReferenceGatheringUnit::new(&config), codes, weights).unwrap()
}

/// The command that tries again, the failing input first; more are tried with PROPTEST_CASES=10000
/// before it.
const AGAIN: &str = "again: cargo test -p potamoi-analysis hard_cases::search";

/// Means about the near plane and far off, sizes from dust to millions of frames, any quaternion.
fn gaussian() -> impl Strategy<Value = ([f32; 3], [f32; 3], [f32; 4], f32)> {
    let beside = || prop_oneof![4 => -1.5f32..1.5, 1 => -1e4f32..1e4, 1 => Just(0.0)];
    let depth = prop_oneof![
        4 => 0.15f32..6.0,
        1 => Just(0.2f32),
        1 => Just(-1.0f32),
        1 => Just(3.0f32),
        1 => 1e2f32..1e6
    ];
    let size = || prop_oneof![4 => -6f32..0.5, 1 => -90f32..-20.0, 1 => 2f32..12.0];
    let part = || prop_oneof![4 => -1f32..1.0, 1 => Just(0.0f32), 1 => -1e30f32..1e30];
    let logit = prop_oneof![
        6 => -6f32..6.0,
        1 => Just(f32::INFINITY),
        1 => Just(f32::NEG_INFINITY),
        // Alphas about 1/255.
        2 => -5.56f32..-5.52
    ];
    (
        (beside(), beside(), depth).prop_map(|(x, y, z)| [x, y, z]),
        [size(), size(), size()],
        [part(), part(), part(), part()],
        logit,
    )
}

fn camera() -> Camera {
    Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 0.9, 20, 18)
}

/// Upper bound of the error of one alpha, for a Gaussian whose mean lies within `reach` pixels.
///
/// The vector (p, q) is off by a mean's half units of 2^-12 in both axes times the largest
/// factor, 1 over the dilation's root; by three factors' half units of 2^-30 times the reach;
/// and by its own of 2^-16 in both parts. A Gaussian falls by at most e^-1/2 of that. To it
/// come half a unit of U3.13 in the exponent, one unit of U0.16 of the exponential, and half
/// a unit each of opacity and alpha.
fn alpha_error(reach: f64) -> f64 {
    let root = 2f64.sqrt();
    let vector = root * 2f64.powi(-13) / 0.3f64.sqrt()
        + 3f64.sqrt() * 2f64.powi(-31) * reach
        + root * 2f64.powi(-17);
    (-0.5f64).exp() * vector + 2f64.powi(-14) + 2.0 * 2f64.powi(-16)
}

proptest! {
    /// No NaN, and no pixel farther from the float one than the formats allow: an alpha's error
    /// once in its own weight and once in the transmittance behind it, the effect of a decision
    /// that flips at a threshold, and the codes of colours.
    #[test]
    fn gaussians_of_any_sort_are_drawn_as_in_floats(
        all in prop::collection::vec(gaussian(), 1..12)
    ) {
        let n = all.len();
        let cloud = Cloud::new(
            0,
            all.iter().map(|g| g.0).collect(),
            all.iter().map(|g| g.1).collect(),
            all.iter().map(|g| g.2).collect(),
            all.iter().map(|g| g.3).collect(),
            (0..n).map(|i| [0.3 * i as f32 - 1.0, 1.0, -0.2 * i as f32]).collect(),
        ).unwrap();
        let (float, fixed) = (
            FloatOptions { log_decisions: true, depth: true, ..FloatOptions::default() },
            FixedOptions { log_decisions: true, ..FixedOptions::default() },
        );
        for profile in Profile::ALL {
            let float = render_float(&cloud, &camera(), profile, &float).unwrap();
            let mut units = ReferenceUnits::new(&Config::paper());
            let fixed = render_fixed(&cloud, &camera(), profile, &fixed, &mut units).unwrap();
            prop_assert_eq!(units.gather_flags(), 0);
            prop_assert!(fixed.transmittance.iter().all(|t| *t <= 1 << 20), "{}", AGAIN);
            let depth = float.depth.as_ref().unwrap();
            prop_assert!(depth.iter().all(|d| *d > 0.0), "{}", AGAIN);
            let view = View::new(&cloud, &camera(), profile).unwrap();
            let reach = view.splats().iter().map(|s| s.mean.abs().max_element()).fold(0.0, f64::max);
            let bright = view.splats().iter().map(|s| s.colour.max_element()).fold(0.0, f64::max);
            let pixels = fixed.picture.rgb.iter().zip(&float.picture.rgb).enumerate();
            if fixed.stats.saturations.mean > 0 || reach > 5e5 {
                prop_assert!(pixels.clone().all(|(_, (a, _))| a.iter().all(|v| v.is_finite())));
                continue;
            }
            let flips = fixed.decisions.as_ref()
                .and_then(|d| d.flips(float.decisions.as_ref()?)).unwrap();
            let error = alpha_error(2.0 * reach + 40.0);
            let flipped = flips.skip as f64 * (1.0 / 255.0 + error) + flips.stop as f64;
            let bound = n as f64 * (2.0 * error + 2f64.powi(-21)) * bright
                + flipped * bright + 2f64.powi(-13) + 1e-6;
            for (i, (fixed, float)) in pixels {
                for (a, b) in fixed.iter().zip(float) {
                    let off = f64::from(a - b).abs();
                    prop_assert!(off <= bound, "{} pixel {}: {} > {}\n{}", profile, i, off, bound, AGAIN);
                }
            }
        }
    }

    /// Rotations by quaternions of arbitrary bits, whose lengths range from zero to the largest float.
    #[test]
    fn quaternions_of_any_bits_turn_as_exactly_computed(
        parts in prop_oneof![
            9 => prop::array::uniform4(prop_oneof![
                3 => any::<f32>().prop_filter("a number", |v| v.is_finite()),
                1 => Just(f32::MAX),
                1 => (0u32..100).prop_map(f32::from_bits),
                2 => -1f32..1.0,
            ]),
            1 => Just([0.0; 4]),
        ],
    ) {
        for (right, found) in turned(parts).iter().zip(rotation(parts).to_cols_array()) {
            let off = right.error(found).abs();
            prop_assert!(off <= 16.0 * 2f64.powi(-53), "{:?}: {} {}", parts, off, AGAIN);
        }
    }

    /// The determinant of any two rows, and factors that their format holds.
    #[test]
    fn footprints_of_any_rows_keep_their_determinant(
        rows in prop::array::uniform6(prop_oneof![-1e3f64..1e3, -1e-6f64..1e-6, -1e9f64..1e9]),
        parallel in any::<bool>(), by in -4f64..4.0,
    ) {
        let x = DVec3::new(rows[0], rows[1], rows[2]);
        let y = if parallel { x * by } else { DVec3::new(rows[3], rows[4], rows[5]) };
        let footprint = Footprint::new(x, y, 0.3);
        let dot = |a: DVec3, b: DVec3| {
            (0..3).fold(exact(0.0), |sum, i| sum + exact(a[i]) * exact(b[i]))
        };
        let (xx, yy, xy) = (dot(x, x) + exact(0.3), dot(y, y) + exact(0.3), dot(x, y));
        let right = xx * yy - xy.clone() * xy;
        let off = right.relative(footprint.determinant).abs();
        prop_assert!(off <= 12.0 * 2f64.powi(-53), "{} {}", off, AGAIN);
        let largest = (1.0f64 / 0.3).sqrt() * (1.0 + 1e-12);
        prop_assert!(footprint.factor.iter().all(|l| l.abs() <= largest), "{:?} {}", footprint, AGAIN);
    }

    /// Weights of any place in a cell, of any width, sum to 1 and leave no sum outside its codes;
    /// weights of any words keep all bits of their sum. Each is rounded once.
    #[test]
    fn weights_of_any_place_and_of_any_words_are_summed_exactly(
        codes in prop::array::uniform8(prop_oneof![any::<i16>(), Just(i16::MIN), Just(i16::MAX)]),
        place in prop::array::uniform3(prop_oneof![0u16..=4096, Just(0), Just(4096), Just(2048)]),
        width in 4u32..=15,
        words in prop::array::uniform8(prop_oneof![any::<u16>(), Just(u16::MAX), Just(0)]),
    ) {
        let sum = |weights: &[u16; 8]| {
            let products = weights.iter().zip(&codes).map(|(w, c)| i64::from(*w) * i64::from(*c));
            products.sum::<i64>() as f64
        };
        let weights = trilinear(place, width);
        prop_assert_eq!(weights.iter().map(|w| u32::from(*w)).sum::<u32>(), 1 << width, "{}", AGAIN);
        let found = gathered(&format!("[gu]\nweight_bits = {width}"), &codes, weights);
        let (least, most) = (codes.iter().min().unwrap(), codes.iter().max().unwrap());
        prop_assert!((least..=most).contains(&&found), "{} {}", found, AGAIN);
        let off = f64::from(found) - sum(&weights) / f64::from(1 << width);
        prop_assert!(off.abs() <= 0.5, "{} {}", off, AGAIN);

        let found = gathered("[gu]\nweights = \"any\"", &codes, words);
        let held = (sum(&words) / 32_768.0).clamp(-32_768.0, 32_767.0);
        let off = f64::from(found) - held;
        prop_assert!(off.abs() <= 0.5, "{} {}", off, AGAIN);
    }

    /// Depths of any 32 bits from any pose: each point that lands is a surface's, in front of the
    /// camera, and the nearest of those that do.
    #[test]
    fn depths_of_any_bits_land_where_surfaces_are(
        bits in prop::collection::vec(prop_oneof![
            4 => any::<u32>(),
            4 => 0x3f00_0000u32..0x4100_0000,
            1 => Just(f32::MAX.to_bits()),
        ], 36),
        turn in prop::array::uniform3(-4f64..4.0), shift in prop::array::uniform3(-3f64..3.0),
    ) {
        let camera = |pose| Camera {
            width: 6,
            height: 6,
            focal: DVec2::splat(5.0),
            centre: DVec2::splat(3.0),
            world_to_camera: pose,
        };
        let pose = DAffine3::from_rotation_translation(
            DQuat::from_scaled_axis(DVec3::from(turn)),
            DVec3::from(shift),
        );
        let depth: Vec<f32> = bits.into_iter().map(f32::from_bits).collect();
        let reference = Shaded { picture: Picture::filled(6, 6, [0.5; 3]), depth: depth.clone() };
        let warped = reproject(&reference, &camera(DAffine3::IDENTITY), &camera(pose));
        // Depths of all that land clearly within a pixel, by pixel.
        let mut landed = vec![vec![]; 36];
        for (i, of) in depth.iter().enumerate().filter(|(_, d)| **d > 0.0 && d.is_finite()) {
            let ray = DVec3::new((i % 6) as f64 - 2.5, (i / 6) as f64 - 2.5, 5.0) / 5.0;
            let point = pose.transform_point3(ray * f64::from(*of));
            let at = point.truncate() / point.z * 5.0 + 3.0;
            let is_clear = at.to_array().iter().all(|v| (v - v.round()).abs() > 1e-6 * v.abs());
            if (1e-30..3e38).contains(&point.z) && is_clear && at.min_element() > 0.0 && at.max_element() < 6.0 {
                landed[at.y as usize * 6 + at.x as usize].push(point.z);
            }
        }
        for (i, landed) in landed.into_iter().enumerate() {
            let found = warped.at(i);
            if let Some((from, z)) = found {
                let of = depth[from as usize];
                prop_assert!(z > 0.0 && z.is_finite(), "{} {}", z, AGAIN);
                prop_assert!(of > 0.0 && of.is_finite(), "{} {}", of, AGAIN);
            }
            // What a double may add to a point, and a float's depth.
            for near in landed {
                let least = found.map_or(f64::INFINITY, |(_, z)| f64::from(z));
                prop_assert!(least <= near * (1.0 + 1e-6), "{} {} {}", least, near, AGAIN);
            }
        }
    }
}
