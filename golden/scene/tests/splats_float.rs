//! The float renderer against closed forms and a renderer without tiles.

use glam::{DMat2, DMat3, DQuat, DVec2, DVec3};
use potamoi_base::camera::Camera;
use potamoi_gaussians::Cloud;
use potamoi_splats::{FloatOptions, Profile, render_float};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

fn camera(width: u32, height: u32) -> Camera {
    Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 0.9, width, height)
}

/// The values of one Gaussian after activation, all in f64.
#[derive(Clone, Copy)]
struct Plain {
    depth: f64,
    mean: DVec2,
    covariance: DMat2,
    opacity: f64,
    colour: DVec3,
}

fn random_cloud(n: usize, seed: u64) -> Cloud {
    let mut r = Pcg64::seed_from_u64(seed);
    let mut vec3 = |low: f32, high: f32| -> Vec<[f32; 3]> {
        (0..n)
            .map(|_| [0; 3].map(|_| r.random_range(low..high)))
            .collect()
    };
    let means = vec3(-1.5, 1.5)
        .into_iter()
        .map(|[x, y, z]| [x, y, z + 2.2])
        .collect();
    let (scales, sh) = (vec3(-5.0, -1.2), vec3(-2.0, 2.0));
    let rotations = (0..n)
        .map(|_| [0; 4].map(|_| r.random_range(-1.0f32..1.0)))
        .collect();
    let logits = (0..n).map(|_| r.random_range(-4.0f32..6.0)).collect();
    Cloud::new(0, means, scales, rotations, logits, sh).unwrap()
}

/// Projects by the textbook: Sigma' = J W Sigma W^T J^T + 0.3 I, with W the
/// identity here.
fn project(cloud: &Cloud, i: usize, camera: &Camera, near: f64) -> Option<Plain> {
    let m = DVec3::from(cloud.means()[i].map(f64::from));
    if m.z <= near {
        return None;
    }
    let [w, x, y, z] = cloud.rotations()[i].map(f64::from);
    let r = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize());
    let s = DMat3::from_diagonal(DVec3::from(
        cloud.log_scales()[i].map(|v| f64::from(v).exp()),
    ));
    let sigma = r * s * s * r.transpose();
    let (f, tan) = (
        camera.focal,
        DVec2::new(camera.width.into(), camera.height.into()) / 2.0 / camera.focal,
    );
    let tx = (m.x / m.z).clamp(-1.3 * tan.x, 1.3 * tan.x) * m.z;
    let ty = (m.y / m.z).clamp(-1.3 * tan.y, 1.3 * tan.y) * m.z;
    let jx = DVec3::new(f.x / m.z, 0.0, -f.x * tx / (m.z * m.z));
    let jy = DVec3::new(0.0, f.y / m.z, -f.y * ty / (m.z * m.z));
    let xx = jx.dot(sigma * jx) + 0.3;
    let xy = jx.dot(sigma * jy);
    let yy = jy.dot(sigma * jy) + 0.3;
    let sh = DVec3::from(cloud.sh(i)[0].map(f64::from));
    Some(Plain {
        depth: m.z,
        mean: m.truncate() / m.z * f + camera.centre,
        covariance: DMat2::from_cols(DVec2::new(xx, xy), DVec2::new(xy, yy)),
        opacity: 1.0 / (1.0 + (-f64::from(cloud.opacity_logits()[i])).exp()),
        colour: (0.282_094_791_773_878_14 * sh + 0.5).max(DVec3::ZERO),
    })
}

/// Whether the reference draws a Gaussian in the tile of a pixel; C's casts
/// truncate.
fn in_reference_tile(g: &Plain, x: u32, y: u32) -> bool {
    let [a, b, c] = [
        g.covariance.x_axis.x,
        g.covariance.x_axis.y,
        g.covariance.y_axis.y,
    ];
    let mid = 0.5 * (a + c);
    let lambda = mid + (mid * mid - (a * c - b * b)).max(0.1).sqrt();
    let radius = (3.0 * lambda.sqrt()).ceil();
    let point = g.mean - 0.5;
    let within = |p: f64, pixel: u32| {
        let low = ((p - radius) / 16.0) as i64;
        let high = ((p + radius + 15.0) / 16.0) as i64;
        (low.max(0)..high).contains(&i64::from(pixel / 16))
    };
    within(point.x, x) && within(point.y, y)
}

/// All Gaussians at every pixel, no tiles: colour and transmittance.
fn brute_force(cloud: &Cloud, camera: &Camera, profile: Profile) -> Vec<(DVec3, f64)> {
    let rules = profile.rules();
    let mut list: Vec<Plain> = (0..cloud.len())
        .filter_map(|i| project(cloud, i, camera, rules.near))
        .collect();
    list.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let mut out = Vec::new();
    for y in 0..camera.height {
        for x in 0..camera.width {
            let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let (mut colour, mut t) = (DVec3::ZERO, 1.0);
            for g in &list {
                if profile == Profile::Inria && !in_reference_tile(g, x, y) {
                    continue;
                }
                let d = at - g.mean;
                let power = -0.5 * d.dot(g.covariance.inverse() * d);
                let alpha = (g.opacity * power.exp()).min(rules.alpha_cap);
                if alpha < rules.alpha_min {
                    continue;
                }
                let next = t * (1.0 - alpha);
                if rules.stops(next) {
                    break;
                }
                colour += g.colour * (alpha * t);
                t = next;
            }
            out.push((colour, t));
        }
    }
    out
}

#[test]
fn tiles_change_nothing_that_the_rules_do_not_name() {
    for (profile, seed) in [
        (Profile::Brush, 1),
        (Profile::Inria, 2),
        (Profile::Inria, 3),
    ] {
        let cloud = random_cloud(300, seed);
        let camera = camera(75, 50);
        let frame = render_float(&cloud, &camera, profile, &FloatOptions::default()).unwrap();
        let expected = brute_force(&cloud, &camera, profile);
        let mut drawn = 0;
        for (i, (colour, t)) in expected.iter().enumerate() {
            // f64 against f64: what differs is the order of a few operations.
            assert!((frame.transmittance[i] - t).abs() < 1e-9, "{profile} {i}");
            let seen = DVec3::from(frame.picture.rgb[i].map(f64::from));
            assert!((seen - *colour).abs().max_element() < 1e-6, "{profile} {i}");
            drawn += usize::from(*t < 1.0);
        }
        assert!(drawn > 1000);
    }
}

#[test]
fn one_ball_has_a_closed_form() {
    let camera = camera(64, 48);
    let (z, log_scale, opacity) = (3.0f32, -2.0f32, 0.8f64);
    let cloud = Cloud::new(
        0,
        vec![[0.0, 0.0, z]],
        vec![[log_scale; 3]],
        vec![[0.3, -0.1, 0.9, 0.2]],
        vec![(opacity / (1.0 - opacity)).ln() as f32],
        vec![[1.0, 0.0, -3.0]],
    )
    .unwrap();
    let frame = render_float(&cloud, &camera, Profile::Gsplat, &FloatOptions::default()).unwrap();
    let sigma = f64::from(log_scale).exp() * camera.focal.x / f64::from(z);
    let variance = sigma * sigma + 0.3;
    let channels = [0.282_094_791_773_878_14 + 0.5, 0.5, 0.0];
    for y in 0..48u32 {
        for x in 0..64u32 {
            let i = (y * 64 + x) as usize;
            let (dx, dy) = (f64::from(x) + 0.5 - 32.0, f64::from(y) + 0.5 - 24.0);
            let alpha = opacity * (-(dx * dx + dy * dy) / (2.0 * variance)).exp();
            // 3.33 sigma reaches all pixels above 1/255 here.
            let alpha = if alpha < 1.0 / 255.0 { 0.0 } else { alpha };
            // The logit is an f32: 2^-24 of 1.39, times o (1 - o).
            assert!(
                (1.0 - frame.transmittance[i] - alpha).abs() < 1e-7,
                "{x} {y}"
            );
            for c in 0..3 {
                let d = f64::from(frame.picture.rgb[i][c]) - alpha * channels[c];
                assert!(d.abs() < 2e-7, "{x} {y} {c}: {d}");
            }
        }
    }
}

/// `n` Gaussians one behind the other that fill the frame evenly.
fn layers(logits: &[f32]) -> Cloud {
    let n = logits.len();
    Cloud::new(
        0,
        (0..n)
            .map(|i| [0.0, 0.0, 1.0 + i as f32 / n as f32])
            .collect(),
        vec![[10.0; 3]; n],
        vec![[1.0, 0.0, 0.0, 0.0]; n],
        logits.to_vec(),
        vec![[0.2; 3]; n],
    )
    .unwrap()
}

#[test]
fn opacities_of_zero_and_one_and_the_stop() {
    let camera = camera(16, 16);
    let (zero, one) = (f32::NEG_INFINITY, f32::INFINITY);
    let left = |logits: &[f32], profile| {
        let frame = render_float(&layers(logits), &camera, profile, &FloatOptions::default());
        frame.unwrap().transmittance[100]
    };
    for profile in Profile::ALL {
        let cap = profile.rules().alpha_cap;
        assert_eq!(left(&[zero], profile), 1.0);
        assert_eq!(left(&[one], profile), 1.0 - cap);
        assert_eq!(left(&[zero, one, zero], profile), 1.0 - cap);
    }
    // A second capped layer would leave less than 1e-4 and is not drawn, as in
    // the reference; in 64-bit constants it would be.
    for profile in Profile::ALL {
        assert_eq!(left(&[one; 5], profile), 1.0 - profile.rules().alpha_cap);
    }
    let left = 1.0 - std::hint::black_box(0.99f64);
    assert!(left * left >= 1e-4);
}
