//! Pictures, decisions and bytes of the renderer.
#![allow(clippy::unwrap_used)]
use super::*;
use crate::depth;
use crate::view::{TILE, TILE_PIXELS};
use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f64x4, f64x8};
use glam::{DVec2, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

const LOG: FloatOptions = FloatOptions {
    background: [0.25, 0.0, 1.0],
    log_decisions: true,
    depth: true,
    work: Work::ALL,
    vectors: None,
};

/// Evaluates every pixel of every entry with the library's exponential, one after another.
fn plain(view: &View) -> FloatFrame {
    let rules = view.rules();
    let [width, height] = view.size();
    let (first, ranks) = view.by_tile();
    let mut picture = Picture::filled(width, height, [0.0; 3]);
    let mut transmittance = vec![1.0; picture.rgb.len()];
    let mut depth = vec![f64::INFINITY; picture.rgb.len()];
    let mut decisions = Decisions::new(first.clone());
    let mut stats = FloatStats::default();
    for t in 0..view.tile_count() {
        let [[x0, y0], [columns, rows]] = view.tile_pixels(t);
        for pixel in 0..TILE_PIXELS {
            let (x, y) = (pixel as u32 % TILE, pixel as u32 / TILE);
            if x >= columns || y >= rows {
                continue;
            }
            let centre = DVec2::new(f64::from(x0 + x), f64::from(y0 + y)) + rules.pixel_centre;
            let (mut colour, mut left, mut far) = (DVec3::ZERO, 1.0, 0.0);
            for (entry, place) in (first[t]..first[t + 1]).enumerate() {
                let splat = &view.splats()[ranks[place] as usize];
                stats.exponentials += 1;
                let alpha = splat.alpha(centre - splat.mean).min(rules.alpha_cap);
                if alpha < rules.alpha_min {
                    continue;
                }
                let after = left * (1.0 - alpha);
                if rules.stops(after) {
                    decisions.stop[t][pixel] = entry as u32;
                    stats.stopped += 1;
                    break;
                }
                colour += splat.colour * (alpha * left);
                far += splat.depth * (alpha * left);
                left = after;
                stats.drawn += 1;
                decisions.drawn[place][pixel / 64] |= 1 << (pixel % 64);
            }
            let to = ((y0 + y) * width + x0 + x) as usize;
            let background = DVec3::from(LOG.background.map(f64::from));
            picture.rgb[to] = (colour + left * background).as_vec3().to_array();
            transmittance[to] = left;
            if left < 1.0 {
                depth[to] = far / (1.0 - left);
            }
        }
    }
    FloatFrame {
        picture,
        transmittance,
        depth: Some(depth),
        stats: Some(stats),
        decisions: Some(decisions),
    }
}

/// From dust to needles that cross the frame a million times over, with
/// opacities from none to all.
fn cloud(n: usize, scales: [f32; 2], seed: u64) -> Cloud {
    let mut r = Pcg64::seed_from_u64(seed);
    let mut draw = |low: f32, high: f32| r.random_range(low..high);
    let means = (0..n)
        .map(|_| [draw(-1.0, 1.0), draw(-1.0, 1.0), draw(0.3, 4.0)])
        .collect();
    let log_scales = (0..n).map(|_| [0; 3].map(|_| draw(scales[0], scales[1])));
    let log_scales = log_scales.collect();
    let rotations = (0..n).map(|_| [0; 4].map(|_| draw(-1.0, 1.0))).collect();
    let logits = (0..n)
        .map(|i| match i % 50 {
            0 => f32::INFINITY,
            1 => f32::NEG_INFINITY,
            _ => draw(-7.0, 7.0),
        })
        .collect();
    let sh = (0..n).map(|_| [0; 3].map(|_| draw(-2.0, 4.0))).collect();
    Cloud::new(0, means, log_scales, rotations, logits, sh).unwrap()
}

fn camera(width: u32, height: u32) -> Camera {
    Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 0.9, width, height)
}

#[test]
fn a_mask_renders_its_pixels_and_nothing_else() {
    let cloud = cloud(300, [-5.0, -1.0], 7);
    let camera = camera(45, 37);
    let view = View::new(&cloud, &camera, Profile::Inria).unwrap();
    let all = render_view(&view, &LOG).unwrap();
    // Single pixels, and tiles without any.
    let mask = Mask::new([45, 37], |i| i % 7 == 3 && i / 45 < 20);
    let some = render_masked(&cloud, &camera, Profile::Inria, &LOG, &mask).unwrap();
    let [all_depth, some_depth] = [&all, &some].map(|f| f.depth.as_ref().unwrap());
    for i in 0..all.transmittance.len() {
        if mask.has(i) {
            assert_eq!(some.picture.rgb[i], all.picture.rgb[i]);
            assert_eq!(some.transmittance[i], all.transmittance[i]);
            assert_eq!(some_depth[i], all_depth[i]);
        } else {
            assert_eq!(some.picture.rgb[i], LOG.background);
            assert_eq!((some.transmittance[i], some_depth[i]), (1.0, f64::INFINITY));
        }
    }
    // Entries of the lower tile row are not taken; few pixels, few exponentials.
    let [some_stats, all_stats] = [some.stats.unwrap(), all.stats.unwrap()];
    assert!(
        0 < some_stats.entries && some_stats.entries < all_stats.entries,
        "{some_stats:?} {all_stats:?}"
    );
    assert!(
        some_stats.exponentials * 6 < all_stats.exponentials,
        "{some_stats:?} {all_stats:?}"
    );
    let every = Mask::new([45, 37], |_| true);
    let again = render_masked(&cloud, &camera, Profile::Inria, &LOG, &every).unwrap();
    assert_eq!(again, all);
    let other = Mask::new([37, 45], |_| true);
    let error = render_masked(&cloud, &camera, Profile::Inria, &LOG, &other).unwrap_err();
    assert!(
        error.to_string().contains("`mask` is [37, 45] pixels"),
        "{error}"
    );
}

#[test]
fn spans_and_groups_change_no_decision() {
    let mut culled = 0;
    for (seed, scales, size) in [
        (1, [-6.0, -3.0], [75, 50]),
        (2, [-6.0, -1.0], [17, 33]),
        (3, [-12.0, 2.0], [61, 48]),
        (4, [-30.0, 14.0], [40, 40]),
        (5, [-80.0, 80.0], [16, 31]),
    ] {
        let cloud = cloud(500, scales, seed);
        for profile in Profile::ALL {
            let view = View::new(&cloud, &camera(size[0], size[1]), profile).unwrap();
            let (fast, slow) = (render_view(&view, &LOG).unwrap(), plain(&view));
            assert_eq!(fast.decisions, slow.decisions, "{seed} {profile}");
            let counts = |s: Option<FloatStats>| s.map(|s| [s.exponentials, s.drawn, s.stopped]);
            assert_eq!(counts(fast.stats), counts(slow.stats));
            let stats = fast.stats.unwrap();
            assert!(
                stats.drawn > 400 && stats.evaluated >= stats.drawn,
                "{stats:?}"
            );
            culled += u64::from(stats.evaluated < stats.exponentials / 2);
            // Two units of the last place an exponential, some hundred deep.
            for (a, b) in fast.transmittance.iter().zip(&slow.transmittance) {
                assert!((a - b).abs() < 1e-14, "{seed} {profile}: {a} {b}");
            }
            // A weight of at least 1/255, less what 1 - T cancels.
            let [fast_depth, slow_depth] = [&fast, &slow].map(|f| f.depth.as_ref().unwrap());
            for (a, b) in fast_depth.iter().zip(slow_depth) {
                assert!(
                    a == b || (a - b).abs() < 1e-11 * b,
                    "{seed} {profile}: {a} {b}"
                );
            }
            let pixels = fast.picture.rgb.iter().zip(&slow.picture.rgb);
            for (a, b) in pixels.flat_map(|(a, b)| a.iter().zip(b)) {
                assert!((a - b).abs() <= f32::EPSILON * b.abs(), "{a} {b}");
            }
        }
    }
    assert!(culled > 5, "{culled}");
}

/// The frame without stats and decisions, which are kept by another way through the renderer.
fn unlogged(frame: FloatFrame) -> FloatFrame {
    FloatFrame {
        stats: None,
        decisions: None,
        ..frame
    }
}

/// Vectors of this processor. Those that it lacks are named.
fn vectors() -> Vec<Vectors> {
    for own in Vectors::ALL.iter().filter(|own| own.level().is_none()) {
        println!("skipped: {own}: this processor does not have it");
    }
    Vectors::here().collect()
}

#[test]
fn neither_vectors_nor_threads_nor_a_log_change_a_byte() {
    let camera = camera(150, 90);
    let levels = vectors();
    assert!(!levels.is_empty());
    for (scales, profile) in [
        ([-6.0, -1.0], Profile::Inria),
        ([-12.0, 2.0], Profile::Gsplat),
        ([-30.0, 14.0], Profile::Inria),
        ([-6.0, -1.0], Profile::Brush),
    ] {
        let cloud = cloud(8000, scales, 9);
        let render = |threads, options: FloatOptions| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let frame = || render_float(&cloud, &camera, profile, &options);
            pool.build().unwrap().install(frame).unwrap()
        };
        let one = render(1, LOG);
        assert!(
            one.stats.unwrap().visible > 4096,
            "more than a chunk of Gaussians"
        );
        let plain = unlogged(one.clone());
        for vectors in levels.iter().copied().map(Some) {
            let options = FloatOptions { vectors, ..LOG };
            assert_eq!(render(2, options), one, "{vectors:?}");
            for threads in [1, 2, 5] {
                let options = FloatOptions {
                    log_decisions: false,
                    ..options
                };
                assert_eq!(render(threads, options), plain, "{vectors:?} {threads}");
                let options = FloatOptions {
                    depth: false,
                    ..options
                };
                let shallow = FloatFrame {
                    depth: None,
                    ..plain.clone()
                };
                assert_eq!(render(threads, options), shallow, "{vectors:?} {threads}");
            }
        }
    }
}

#[test]
fn vectors_that_are_not_there_are_refused() {
    let (cloud, camera) = (cloud(9, [-6.0, -1.0], 9), camera(20, 20));
    for own in Vectors::ALL {
        let options = FloatOptions {
            vectors: Some(own),
            ..FloatOptions::default()
        };
        let found = render_float(&cloud, &camera, Profile::Inria, &options);
        assert_eq!(found.is_ok(), own.level().is_some());
        if let Err(error) = found {
            let text = error.to_string();
            assert!(text.contains(&format!("`vectors` is {own}")), "{text}");
        }
    }
    assert!(Vectors::widest().is_some());
}

/// Equal depths, depths that differ only in their last bits, and one far off, which leaves few bits of
/// the others' in a key.
#[test]
fn the_order_is_that_of_whole_depths() {
    let count = 9000;
    let cloud = cloud(count, [-6.0, -1.0], 4);
    let mut r = Pcg64::seed_from_u64(4);
    for far in [3.0, 1e30] {
        let depths: Vec<f64> = (0..count)
            .map(|i| match i % 4 {
                0 => 1.5,
                1 => f64::from_bits(1.5f64.to_bits() + r.random_range(0..9)),
                2 => f64::from_bits(1.5f64.to_bits() + r.random_range(0..1 << 40)),
                _ => r.random_range(0.2..if i == 7 { far * 2.0 } else { 3.0 }),
            })
            .collect();
        let expected = depth::sort(&cloud, depths.iter().copied().zip(0..).collect());
        let chunks: Vec<Vec<f64>> = depths.chunks(splats::CHUNK).map(<[f64]>::to_vec).collect();
        let index = |slot: u32| slot as usize;
        let found = order::front_to_back(&cloud, &chunks, index);
        let found: Vec<usize> = found.into_iter().map(index).collect();
        let expected: Vec<usize> = expected.into_iter().map(|own| own.1).collect();
        assert_eq!(found, expected);
    }
    assert!(order::front_to_back(&cloud, &[], |_| 0).is_empty());
}

/// The exponential of one pixel, written without vectors.
fn exp(x: f64) -> f64 {
    let x = if x > -700.0 { x } else { -700.0 };
    let shifted = x * std::f64::consts::LOG2_E + exponential::ROUND;
    let power = shifted - exponential::ROUND;
    let r = (x - power * exponential::LN_2[0]) - power * exponential::LN_2[1];
    let c = &exponential::POLYNOMIAL;
    let (r2, r4, r8);
    r2 = r * r;
    r4 = r2 * r2;
    r8 = r4 * r4;
    let low = (c[2] + c[3] * r) * r2;
    let mid = ((c[4] + c[5] * r) + (c[6] + c[7] * r) * r2) * r4;
    let high = ((c[8] + c[9] * r) + (c[10] + c[11] * r) * r2) * r8;
    let value = 1.0 + (r + (low + (mid + high)));
    value * f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52)
}

/// e^x of each, by both widths of these vectors.
#[inline(always)]
fn exps<S: Simd>(simd: S, x: [f64; 8]) -> [[f64; 8]; 2] {
    let mut both = [[0.0; 8]; 2];
    for at in [0, 4] {
        let own = exponential::exp::<S, f64x4<S>>(f64x4::from_slice(simd, &x[at..at + 4]));
        own.store_slice(&mut both[0][at..at + 4]);
    }
    let wide = exponential::exp::<S, f64x8<S>>(f64x8::from_slice(simd, &x));
    wide.store_slice(&mut both[1]);
    both
}

#[test]
fn the_exponential_is_within_two_units_of_the_last_place_on_all_vectors() {
    let mut x: Vec<f64> = vec![0.0, -0.0, -700.0, -701.0, -1e300, f64::NEG_INFINITY];
    // Dense near 0, down to -700.
    for i in 0..300_000 {
        let u = f64::from(i) / 3e5;
        x.extend([-700.0 * u, -8.0 * u, -u * u * u * 1e-3]);
    }
    // Where the reduction changes its power of two, from both sides.
    for k in 0..1000 {
        let edge = -(f64::from(k) + 0.5) * std::f64::consts::LN_2;
        x.extend([edge.next_down(), edge, edge.next_up()]);
    }
    for own in vectors() {
        let level = own.level().unwrap();
        for x in x.as_chunks().0 {
            for found in dispatch!(level, simd => exps(simd, *x)) {
                assert_eq!(
                    found.map(f64::to_bits),
                    x.map(|x| exp(x).to_bits()),
                    "{own}"
                );
            }
        }
    }
    for x in x {
        let expected = x.max(-700.0).exp();
        assert!((exp(x) / expected - 1.0).abs() < 4e-16, "{x}");
    }
    assert_eq!(exp(0.0), 1.0);
    assert!(exp(-700.0) < 1.1e-304 && exp(-700.0) > 0.9e-304);
}

/// Nothing is seen where no Gaussian is in view, infinitely far; with and without a log.
#[test]
fn a_view_without_gaussians_has_depths() {
    let behind = Cloud::new(
        0,
        vec![[0.0, 0.0, -5.0]],
        vec![[0.1; 3]],
        vec![[1.0, 0.0, 0.0, 0.0]],
        vec![0.5],
        vec![[1.0; 3]],
    );
    let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 0.9, 20, 18);
    for log_decisions in [false, true] {
        let options = FloatOptions {
            log_decisions,
            depth: true,
            ..FloatOptions::default()
        };
        let cloud = behind.as_ref().unwrap();
        let frame = render_float(cloud, &camera, Profile::Inria, &options).unwrap();
        assert_eq!(frame.depth, Some(vec![f64::INFINITY; 360]));
    }
}
