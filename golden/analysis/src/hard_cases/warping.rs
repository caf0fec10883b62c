//! Warping: invalid depths, surfaces at one depth, small angles, rotations near zero and half a
//! turn, and regressions over degenerate poses.

use glam::{DAffine3, DMat2, DQuat, DVec2, DVec3};
use potamoi_formats::config::Config;

use super::exact::{Exact, exact};
use super::{Case, Draws, Measuring, Stop, Worst, cases};
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_warp::{BayesianRidge, Shaded, reproject, rotation_vector, subtended};

cases! {
    "warping";
    depths_that_are_none, "warping depths of 0, infinity, NaN and below 0", "";
    z_fighting, "surfaces that fight for a pixel", "";
    small_angles, "the angle of warping, 1e-12 to pi", "";
    turns_near_none_and_half, "turns near none and near half a turn", "";
    poses_that_say_little, "regression over one, two, equal and collinear poses", "";
}

fn camera(width: u32, height: u32, shift: DVec3) -> Camera {
    Camera {
        width,
        height,
        focal: DVec2::new(40.0, 42.0),
        centre: DVec2::new(f64::from(width), f64::from(height)) / 2.0,
        world_to_camera: DAffine3::from_translation(shift),
    }
}

fn shaded(side: u32, depth: Vec<f32>) -> Shaded {
    Shaded {
        picture: Picture::filled(side, side, [0.5; 3]),
        depth,
    }
}

fn depths_that_are_none(_: &Config) -> Measuring {
    let odd = [0.0, -0.0, f32::INFINITY, f32::NAN, f32::NEG_INFINITY, -1.0];
    let depth: Vec<f32> = (0..64).map(|i| odd[i % odd.len()]).collect();
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for shift in [
        DVec3::ZERO,
        DVec3::new(0.01, 0.0, 0.5),
        DVec3::new(0.0, 0.0, -0.5),
    ] {
        let (from, to) = (camera(8, 8, DVec3::ZERO), camera(8, 8, shift));
        let warped = reproject(&shaded(8, depth.clone()), &from, &to);
        (0..64).for_each(|i| ours.count(warped.at(i).is_some()));
        // The paper's equations, written where they fall.
        let mut buffer = [f32::INFINITY; 64];
        for (i, depth) in depth.iter().enumerate() {
            let [x, y] = [(i % 8) as f32 + 0.5, (i / 8) as f32 + 0.5];
            let point = DVec3::new(
                f64::from((x - 4.0) / 40.0 * depth),
                f64::from((y - 4.0) / 42.0 * depth),
                f64::from(*depth),
            ) + shift;
            let at = [
                (point.x / point.z * 40.0 + 4.0) as usize,
                (point.y / point.z * 42.0 + 4.0) as usize,
            ];
            if at[0] < 8 && at[1] < 8 && (point.z as f32) < buffer[8 * at[1] + at[0]] {
                buffer[8 * at[1] + at[0]] = point.z as f32;
            }
        }
        buffer.iter().for_each(|z| fails.count(z.is_finite()));
    }
    Ok(Case {
        naive: "the equations as they stand, casts to pixels".into(),
        unit: "pixels of 192 covered by nothing".into(),
        fails,
        bound: 0.0,
        from: "what is no surface is no point".into(),
        ours,
    })
}

/// Many points of nearly one depth on each pixel, whatever the order in which threads come.
fn z_fighting(_: &Config) -> Measuring {
    let side = 64;
    let mut draws = Draws(23);
    let ulps = |u: f64| f32::from_bits(3f32.to_bits() + (u * 3.0) as u32);
    let depth: Vec<f32> = (0..side * side).map(|_| ulps(draws.next())).collect();
    let (from, mut to) = (camera(side, side, DVec3::ZERO), camera(8, 8, DVec3::ZERO));
    to.focal /= 8.0;
    let reference = shaded(side, depth.clone());
    // The least depth, and of equal ones the first.
    let mut best = [None::<(f32, u32)>; 64];
    let mut last = [None::<(f32, u32)>; 64];
    for (i, z) in (0..).zip(&depth) {
        let pixel = (i % side / 8 + 8 * (i / side / 8)) as usize;
        let cell = &mut best[pixel];
        if cell.is_none_or(|(least, _)| *z < least) {
            *cell = Some((*z, i));
        }
        // Points that come last win ties.
        let cell = &mut last[pixel];
        if cell.is_none_or(|(least, _)| *z <= least) {
            *cell = Some((*z, i));
        }
    }
    let mut ours = Worst::default();
    for threads in [1, 2, 4, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let warped = pool?.install(|| reproject(&reference, &from, &to));
        for (i, best) in best.iter().enumerate() {
            ours.count(warped.at(i).map(|(from, z)| (z, from)) != *best);
        }
    }
    let mut fails = Worst::default();
    best.iter()
        .zip(&last)
        .for_each(|(a, b)| fails.count(a != b));
    Ok(Case {
        naive: "a z-buffer in which the last of equals wins, run backwards".into(),
        unit: "pixels of 64 that depend on the order".into(),
        fails,
        bound: 0.0,
        from: "depth and place are compared as one integer".into(),
        ours,
    })
}

fn angle(a: DVec3, b: DVec3) -> Exact {
    let product = |p: f64, q: f64| exact(p) * exact(q);
    let minor = |i: usize, j: usize| product(a[i], b[j]) - product(a[j], b[i]);
    let cross = [minor(1, 2), minor(2, 0), minor(0, 1)].map(|m| m.clone() * m);
    let [x, y, z] = cross;
    let dot = product(a.x, b.x) + product(a.y, b.y) + product(a.z, b.z);
    let ratio = ((x + y + z).sqrt() / dot.clone()).atan();
    if dot.to_f64() < 0.0 {
        ratio + Exact::pi()
    } else {
        ratio
    }
}

fn small_angles(_: &Config) -> Measuring {
    let mut draws = Draws(29);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    let pi = std::f64::consts::PI;
    for theta in [
        1e-12,
        1e-8,
        1e-4,
        3e-4,
        1e-2,
        0.7,
        1.5,
        2.5,
        pi - 1e-3,
        pi - 1e-6,
    ] {
        for _ in 0..20 {
            let axis = DVec3::new(draws.next(), draws.next(), draws.next()).normalize();
            let a = axis.any_orthonormal_vector() * draws.between(0.1, 9.0);
            let b = DQuat::from_axis_angle(axis, theta) * a * draws.between(0.1, 9.0);
            let right = angle(a, b);
            ours.see(right.error(subtended(a, b)));
            let (f, g) = (a.as_vec3(), b.as_vec3());
            let cosine = f.dot(g) / (f.length() * g.length());
            fails.see(right.error(f64::from(cosine.clamp(-1.0, 1.0).acos())));
        }
    }
    Ok(Case {
        naive: "the arc cosine in 32 bits".into(),
        unit: "rad".into(),
        fails,
        bound: 12.0 * 2f64.powi(-53),
        from: "a cross product's roundings, relative to the vectors' lengths".into(),
        ours,
    })
}

fn turns_near_none_and_half(_: &Config) -> Measuring {
    let pi = std::f64::consts::PI;
    let angles = [
        0.0,
        1e-200,
        1e-30,
        1e-16,
        1e-9,
        1e-8,
        1e-7,
        1e-3,
        1.0,
        3.0,
        pi - 1e-3,
        pi - 1e-8,
        pi - 1e-12,
        pi,
        pi + 1e-9,
        4.0,
        2.0 * pi - 1e-7,
    ];
    let mut draws = Draws(31);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for angle in angles {
        for _ in 0..10 {
            let axis = [0; 3].map(|_| draws.between(-1.0, 1.0));
            let axis = DVec3::from(axis).normalize();
            let (s, c) = (angle / 2.0).sin_cos();
            // Rounded: neither the axis nor the length is exactly that any more.
            let turn = DQuat::from_xyzw(axis.x * s, axis.y * s, axis.z * s, c);
            let short = if turn.w < 0.0 { -turn } else { turn };
            let part = [short.x, short.y, short.z];
            let squares = part.map(|v| exact(v) * exact(v));
            let length = squares
                .into_iter()
                .fold(exact(0.0), |sum, v| sum + v)
                .sqrt();
            let half = if short.w == 0.0 {
                Exact::pi() * exact(0.5)
            } else {
                (length.clone() / exact(short.w)).atan()
            };
            let found = rotation_vector(turn);
            let naive = |v: f64| 2.0 * turn.w.acos() / (1.0 - turn.w * turn.w).sqrt() * v;
            for (axis, v) in part.into_iter().enumerate() {
                let right = if length.is_zero() {
                    exact(0.0)
                } else {
                    exact(2.0) * half.clone() * exact(v) / length.clone()
                };
                ours.see(right.error(found[axis]));
                fails.see(right.error(naive(turn.to_array()[axis])));
            }
        }
    }
    Ok(Case {
        naive: "axis and angle by the arc cosine of w".into(),
        unit: "rad".into(),
        fails,
        bound: 8.0 * pi * 2f64.powi(-53),
        from: "eight roundings of at most half a turn".into(),
        ours,
    })
}

/// A value at the mean of the features is the mean of the values, whatever the fit's slope.
fn poses_that_say_little(_: &Config) -> Measuring {
    let line = |n: i32, step: f64| -> Vec<Vec<f64>> {
        (0..n)
            .map(|k| vec![f64::from(k) * step, 2.0 * f64::from(k) * step])
            .collect()
    };
    let cases: [(Vec<Vec<f64>>, Vec<f64>); 7] = [
        (line(1, 1.0), vec![0.7]),
        (line(2, 1.0), vec![0.1, 0.4]),
        (line(2, 1.0), vec![0.25, 0.25]),
        (line(5, 1.0), vec![0.3; 5]),
        (line(5, 1.0), vec![0.1, 0.2, 0.3, 0.4, 0.5]),
        (line(5, 0.0), vec![0.2, 0.1, 0.4, 0.3, 0.5]),
        (line(5, 1e-9), vec![0.2, 0.2, 0.2, 0.2, 0.2 + 1e-12]),
    ];
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for (rows, values) in cases {
        let n = values.len() as f64;
        let mean = values.iter().fold(exact(0.0), |sum, v| sum + exact(*v)) / exact(n);
        let centre = [0, 1].map(|f| rows.iter().map(|r| r[f]).sum::<f64>() / n);
        let fit = BayesianRidge::default().fit(&rows, &values);
        let fit = fit.ok_or_else(|| Stop::NotComputed("no fit".to_owned()))?;
        ours.see(mean.error(fit.at(&centre)));
        // Of values on a line what is fitted lies between their mean and them: it is shrunk.
        let step = values.get(1).map_or(0.0, |v| v - values[0]);
        let on_a_line = |(k, v): (usize, &f64)| (v - values[0] - k as f64 * step).abs() < 1e-12;
        if rows.last() != rows.first() && values.iter().enumerate().all(on_a_line) {
            for (row, value) in rows.iter().zip(&values) {
                let [own, value] = [fit.at(row), *value].map(|v| v - mean.to_f64());
                let [low, high] = [value.min(0.0), value.max(0.0)];
                ours.see((low - own).max(own - high).max(0.0));
            }
        }
        // The normal equations of centred features.
        let mut square = DMat2::ZERO;
        let mut right = DVec2::ZERO;
        for (row, value) in rows.iter().zip(&values) {
            let d = DVec2::new(row[0] - centre[0], row[1] - centre[1]);
            square += DMat2::from_cols(d * d.x, d * d.y);
            right += d * *value;
        }
        let determinant = square.determinant();
        let slope = DVec2::new(
            (square.y_axis.y * right.x - square.y_axis.x * right.y) / determinant,
            (square.x_axis.x * right.y - square.x_axis.y * right.x) / determinant,
        );
        fails.see(mean.error(mean.to_f64() + 0.0 * (slope.x + slope.y)));
    }
    Ok(Case {
        naive: "normal equations, their determinant 0".into(),
        unit: "absolute, of values up to 1".into(),
        fails,
        bound: 32.0 * 2f64.powi(-53),
        from: "roundings of two means and two products".into(),
        ours,
    })
}
