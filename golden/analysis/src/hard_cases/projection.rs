//! Gaussians that cannot be projected as they stand: at, beside and behind the camera, far
//! outside the frame, and with quaternions of no or any length.

use glam::{DVec2, DVec3};
use potamoi_formats::config::Config;
use potamoi_formats::record::{FACTOR, MEAN};

use super::exact::{Exact, exact};
use super::{Case, Draws, Measuring, Worst, cases, ensure};
use potamoi_base::camera::Camera;
use potamoi_gaussians::{Cloud, rotation};
use potamoi_splats::{Footprint, Profile, Projected, RecordForm, Saturations, View, record};

cases! {
    "projection";
    at_and_behind_the_camera, "Gaussians at the camera, on the near plane, behind it", "";
    beside_the_frame, "Gaussians far beside the frame, as wide as they are near", "";
    far_outside_the_frame, "means farther than a record holds", "";
    quaternions, "quaternions of length 0, 1e-45 to 3e38", "";
}

fn camera() -> Camera {
    Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 1.0, 32, 32)
}

fn at_and_behind_the_camera(_: &Config) -> Measuring {
    let depths = [
        -3e38f32, -5.0, -0.2, -1e-30, -0.0, 0.0, 1e-45, 1e-30, 0.005, 0.2, 1e30,
    ];
    let scales = [-1e38f32, -50.0, 0.0, 88.0];
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for profile in Profile::ALL {
        let rules = profile.rules();
        for z in depths {
            for x in [0.0f32, 0.1, -1e30] {
                for scale in scales {
                    let cloud = Cloud::new(
                        0,
                        vec![[x, 0.0, z]],
                        vec![[scale, -3.0, scale]],
                        vec![[1.0, 0.2, -0.1, 0.4]],
                        vec![0.0],
                        vec![[0.0; 3]],
                    );
                    let view = View::new(&cloud?, &camera(), profile)?;
                    for p in view.splats() {
                        let f = p.footprint;
                        let finite = p.mean.is_finite()
                            && f.determinant.is_finite()
                            && f.covariance.iter().chain(&f.factor).all(|v| v.is_finite());
                        ours.count(!finite || !rules.sees(f64::from(z)));
                    }
                    // The division alone: mirrored behind, no number at the camera.
                    let c = camera();
                    let (mean, sigma) = (x / z * c.focal.x as f32, scale.exp() / z);
                    let shown = (mean + c.centre.x as f32).abs() < 64.0;
                    let sees = rules.sees(f64::from(z));
                    fails.count((shown && !sees) || !mean.is_finite() || !sigma.is_finite());
                }
            }
        }
    }
    Ok(Case {
        naive: "division by the depth, nothing culled".into(),
        unit: "Gaussians mirrored or not finite".into(),
        fails,
        bound: 0.0,
        from: "culled by a comparison, and finite in 64 bits up to the largest scale".into(),
        ours,
    })
}

/// Gaussians far beside the frame, the larger the nearer they are: where their projection's slope is
/// taken at the mean, it smears them over all of the frame. What there is along a pixel's ray is a
/// Gaussian of the ray's distance, exact in 64 bits: all are alike in every direction.
fn beside_the_frame(_: &Config) -> Measuring {
    let camera = camera();
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for profile in Profile::ALL {
        let rules = profile.rules();
        for (slope, depth) in [(3.0, 0.3), (5.0, 0.4), (10.0, 1.0), (30.0, 4.0)] {
            // Of standard deviations from the frame's edge: three and a half on screen, more in space.
            let sigma = depth * slope / 5.0;
            let mean = DVec3::new(slope * depth, 0.0, depth);
            let log_scale = [sigma.ln() as f32; 3];
            let cloud = Cloud::new(
                0,
                vec![mean.to_array().map(|v| v as f32)],
                vec![log_scale],
                vec![[1.0, 0.0, 0.0, 0.0]],
                vec![20.0],
                vec![[0.0; 3]],
            );
            let view = View::new(&cloud?, &camera, profile)?;
            // The same at the mean's own slope.
            let per_depth = camera.focal / depth;
            let at_the_mean = Footprint::new(
                per_depth.x * sigma * DVec3::new(1.0, 0.0, -slope),
                per_depth.y * sigma * DVec3::Y,
                rules.dilation,
            );
            let centre = DVec2::new(slope, 0.0) * camera.focal + camera.centre;
            for (x, y) in (0..camera.height).flat_map(|y| (0..camera.width).map(move |x| (x, y))) {
                let pixel = DVec2::new(x.into(), y.into()) + 0.5;
                let ray = ((pixel - camera.centre) / camera.focal).extend(1.0);
                let away = mean.cross(ray.normalize()).length() / sigma;
                let seen = (-0.5 * away * away).exp();
                ensure(seen < rules.alpha_min, || format!("{seen} along a ray"))?;
                let drawn = |f: &Footprint| {
                    let [xx, xy, yy] = f.covariance;
                    let d = centre - pixel;
                    let form = yy * d.x * d.x - 2.0 * xy * d.x * d.y + xx * d.y * d.y;
                    (-0.5 * form / f.determinant).exp() >= rules.alpha_min
                };
                fails.count(drawn(&at_the_mean));
                // Of what reaches no pixel nothing is left.
                ours.count(view.splats().iter().any(|own| drawn(&own.footprint)));
            }
        }
    }
    Ok(Case {
        naive: "the projection's slope at the mean".into(),
        unit: "pixels of 16,384 drawn where alpha is below 1/255 along the ray".into(),
        fails,
        bound: 0.0,
        from: "the slope is held at 1.3 of the frame's edge: they are as far off on screen as in space".into(),
        ours,
    })
}

/// Means past the record's S19.12: what a pixel of the frame sees of them.
fn far_outside_the_frame(_: &Config) -> Measuring {
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for away in [
        2f64.powi(20) + 3.0,
        -(2f64.powi(20)) + 3.0,
        2f64.powi(40) + 3.0,
        1e300,
    ] {
        let splat = Projected {
            index: 0,
            depth: 1.0,
            mean: DVec2::new(away, 3.0),
            footprint: Footprint::new(DVec3::X * 3.0, DVec3::Y * 3.0, 0.3),
            opacity: 0.9,
            colour: DVec3::ONE,
        };
        let mut held = Saturations::default();
        let record = record(&splat, 0, RecordForm::default(), &mut held);
        ensure(held.mean == 1, || format!("a mean of {away} is not held"))?;
        let [l11, l21, l22] = record.factor.map(|l| FACTOR.value(l.into()));
        let alpha = |mean: [i32; 2]| {
            let d = DVec2::splat(3.0) - DVec2::from(mean.map(|m| MEAN.value(m.into())));
            let (p, q) = (l11 * d.x + l21 * d.y, l22 * d.y);
            0.9 * (-0.5 * (p * p + q * q)).exp()
        };
        // Nothing of it reaches the frame.
        ours.see(alpha(record.mean));
        let cut = |v: f64| (v * 4096.0) as i128 as i32;
        fails.see(alpha(splat.mean.to_array().map(cut)));
    }
    Ok(Case {
        naive: "the code's low 32 bits".into(),
        unit: "alpha where nothing is".into(),
        fails,
        bound: 0.0,
        from: "held at the format's end, 2^19 pixels away".into(),
        ours,
    })
}

/// Entries of the rotation of a quaternion of any length, column by column; of none no turn.
pub(super) fn turned(quaternion: [f32; 4]) -> [Exact; 9] {
    let [w, x, y, z] = quaternion.map(|v| exact(f64::from(v)));
    let twice = |a: &Exact, b: &Exact| exact(2.0) * a.clone() * b.clone();
    let norm = [&w, &x, &y, &z].map(|v| v.clone() * v.clone());
    let norm = norm.into_iter().fold(exact(0.0), |sum, v| sum + v);
    let one = || {
        if norm.is_zero() {
            exact(1.0)
        } else {
            norm.clone()
        }
    };
    [
        one() - twice(&y, &y) - twice(&z, &z),
        twice(&x, &y) + twice(&w, &z),
        twice(&x, &z) - twice(&w, &y),
        twice(&x, &y) - twice(&w, &z),
        one() - twice(&x, &x) - twice(&z, &z),
        twice(&y, &z) + twice(&w, &x),
        twice(&x, &z) + twice(&w, &y),
        twice(&y, &z) - twice(&w, &x),
        one() - twice(&x, &x) - twice(&y, &y),
    ]
    .map(|v| v / one())
}

/// Entries of a rotation, column by column, of a quaternion divided by its length in 32 bits.
pub(super) fn normalised_in_32_bits([w, x, y, z]: [f32; 4]) -> [f32; 9] {
    let length = (w * w + x * x + y * y + z * z).sqrt();
    let unit = glam::Quat::from_xyzw(x / length, y / length, z / length, w / length);
    match unit.is_finite() {
        true => glam::Mat3::from_quat(unit).to_cols_array(),
        false => [f32::NAN; 9],
    }
}

/// Upper bound of the error of a rotation's entries: sixteen roundings of 64 bits.
pub(super) const ROTATION: f64 = 16.0 / (1u64 << 53) as f64;

fn quaternions(_: &Config) -> Measuring {
    let mut all = vec![
        [0.0f32; 4],
        [1e30; 4],
        [1e-30; 4],
        [1e-45, 0.0, -1e-45, 0.0],
    ];
    all.extend([
        [f32::MAX, f32::MAX, -f32::MAX, 0.0],
        [-0.0; 4],
        [3.0, 0.0, 0.0, 0.0],
    ]);
    let mut draws = Draws(11);
    for _ in 0..60 {
        let scale = 10f64.powf(draws.between(-30.0, 30.0));
        all.push([0; 4].map(|_| (scale * draws.between(-1.0, 1.0)) as f32));
    }
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for quaternion in all {
        let right = turned(quaternion);
        for (right, found) in right.iter().zip(rotation(quaternion).to_cols_array()) {
            ours.see(right.error(found));
        }
        let naive = normalised_in_32_bits(quaternion);
        for (right, found) in right.iter().zip(naive) {
            fails.see(right.error(found.into()));
        }
    }
    Ok(Case {
        naive: "normalised in 32 bits".into(),
        unit: "absolute, of a rotation's entries".into(),
        fails,
        bound: ROTATION,
        from: "sixteen roundings of 64 bits".into(),
        ours,
    })
}
