//! The ground, the rock below it, and the pond.

use std::f64::consts::TAU;

use glam::DVec3;

use super::paint::{Painter, Stroke, facing};
use super::random::Random;

/// Radius of the island.
pub(super) const RADIUS: f64 = 1.95;
/// The pond's centre and radius.
pub(super) const POND: (DVec3, f64) = (DVec3::new(0.62, 0.0, 0.98), 0.46);
/// The angle between neighbours of a sunflower's seeds: even, without rows.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Height of the ground.
pub(super) fn height(x: f64, z: f64) -> f64 {
    let edge = ((x * x + z * z).sqrt() / RADIUS).powi(4);
    let hills = 0.07 * (1.7 * x + 0.4).sin() * (1.9 * z - 0.3).cos();
    let mound = 0.16 * (-1.6 * (x * x + z * z)).exp();
    hills + mound - 0.16 * edge
}

/// The ground's point above (x, z).
pub(super) fn on_ground(x: f64, z: f64) -> DVec3 {
    DVec3::new(x, height(x, z), z)
}

fn normal(x: f64, z: f64) -> DVec3 {
    let h = 1e-3;
    DVec3::new(
        height(x - h, z) - height(x + h, z),
        2.0 * h,
        height(x, z - h) - height(x, z + h),
    )
    .normalize()
}

/// Distance from the pond's rim, negative inside.
pub(super) fn from_pond(x: f64, z: f64) -> f64 {
    let (centre, radius) = POND;
    let angle = (z - centre.z).atan2(x - centre.x);
    let rim = radius * (1.0 + 0.12 * (2.0 * angle + 0.5).sin() + 0.05 * (3.0 * angle).cos());
    (x - centre.x).hypot(z - centre.z) - rim
}

/// A meadow of overlapping patches.
pub(super) fn ground(painter: &mut Painter, random: &mut Random) {
    let count = 900;
    for i in 0..count {
        let r = RADIUS * ((f64::from(i) + 0.5) / f64::from(count)).sqrt();
        let (s, c) = (f64::from(i) * GOLDEN_ANGLE).sin_cos();
        let (x, z) = (r * c, r * s);
        let shore = from_pond(x, z);
        if shore < -0.04 {
            continue;
        }
        let patchy = 0.5 + 0.5 * (3.1 * x + 1.0).sin() * (2.7 * z).cos();
        let meadow = DVec3::new(0.30, 0.50, 0.13).lerp(DVec3::new(0.46, 0.60, 0.18), patchy);
        let sand = DVec3::new(0.72, 0.62, 0.42);
        let albedo = sand.lerp(meadow, (shore / 0.16).clamp(0.0, 1.0)) * random.range(0.85, 1.12);
        let size = random.range(0.055, 0.08);
        painter.patch(
            on_ground(x, z) - DVec3::Y * 0.01,
            facing(normal(x, z), random.range(0.0, TAU)),
            DVec3::new(size, size * random.range(0.7, 1.0), 0.012),
            albedo,
            0.0,
        );
    }
}

/// The island's underside: a ragged cone in layers.
pub(super) fn rock(painter: &mut Painter, random: &mut Random) {
    let count = 520;
    for i in 0..count {
        let depth = ((f64::from(i) + 0.5) / f64::from(count)).powf(0.8);
        let angle = f64::from(i) * GOLDEN_ANGLE;
        let ragged = 1.0 + 0.10 * (5.0 * angle.sin() + 2.0).sin() + 0.06 * (9.0 * depth).sin();
        let r = RADIUS * (1.0 - depth).powf(0.62) * ragged * 0.97;
        let (s, c) = angle.sin_cos();
        let at = DVec3::new(r * c, -0.16 - 1.0 * depth, r * s);
        let out = DVec3::new(c, -0.45 - 0.3 * depth, s).normalize();
        let layer = 0.5 + 0.5 * (26.0 * depth + 1.3 * (3.0 * angle).sin()).sin();
        let earth = DVec3::new(0.45, 0.31, 0.20).lerp(DVec3::new(0.60, 0.50, 0.40), layer);
        let earth = DVec3::new(0.34, 0.36, 0.15).lerp(earth, (depth * 14.0).min(1.0));
        let size = random.range(0.07, 0.13) * (1.0 - 0.45 * depth);
        painter.patch(
            at,
            facing(out + 0.5 * random.direction(), random.range(0.0, TAU)),
            DVec3::new(size, size * random.range(0.6, 1.0), 0.03),
            earth * random.range(0.8, 1.15),
            0.0,
        );
    }
}

/// Water that mirrors the sun, lilies on it, and stones around.
pub(super) fn pond(painter: &mut Painter, random: &mut Random) {
    let (centre, radius) = POND;
    let level = height(centre.x, centre.z) - 0.03;
    let sun = painter.light.sun;
    // The view direction that the water throws into the sun.
    let mirrored = sun.with_y(-sun.y);
    let count = 90;
    for i in 0..count {
        let r = 1.15 * radius * ((f64::from(i) + 0.5) / f64::from(count)).sqrt();
        let (s, c) = (f64::from(i) * GOLDEN_ANGLE).sin_cos();
        let (x, z) = (centre.x + r * c, centre.z + r * s);
        let shore = from_pond(x, z);
        if shore > 0.02 {
            continue;
        }
        let deep = (-shore / 0.3).clamp(0.0, 1.0);
        let water = DVec3::new(0.42, 0.66, 0.70).lerp(DVec3::new(0.12, 0.36, 0.52), deep);
        painter.add(Stroke {
            at: DVec3::new(x, level, z),
            axes: facing(DVec3::Y, random.range(0.0, TAU)),
            sigma: DVec3::new(0.06, 0.05, 0.006),
            opacity: 0.9,
            colour: water * random.range(0.92, 1.08),
            glow: mirrored * 0.45,
        });
    }
    for (angle, far, size) in [(0.4, 0.5, 0.055), (2.3, 0.55, 0.065), (3.9, 0.3, 0.05)] {
        let (s, c) = f64::sin_cos(angle);
        let at = DVec3::new(
            centre.x + far * radius * c,
            level + 0.012,
            centre.z + far * radius * s,
        );
        painter.patch(
            at,
            facing(DVec3::Y, angle),
            DVec3::new(size, size * 0.85, 0.004),
            DVec3::new(0.28, 0.55, 0.25),
            0.1,
        );
        painter.patch(
            at + DVec3::Y * 0.02,
            facing(DVec3::Y, angle),
            DVec3::new(0.02, 0.02, 0.014),
            DVec3::new(0.95, 0.72, 0.82),
            0.1,
        );
    }
    stones(painter, random);
}

fn stones(painter: &mut Painter, random: &mut Random) {
    let (centre, _) = POND;
    for i in 0..26 {
        let angle = TAU * (f64::from(i) + random.range(-0.3, 0.3)) / 26.0;
        let (s, c) = angle.sin_cos();
        // Walk out to the rim.
        let mut r = 0.2;
        while from_pond(centre.x + r * c, centre.z + r * s) < 0.02 {
            r += 0.01;
        }
        let size = random.range(0.03, 0.058);
        let at = on_ground(centre.x + r * c, centre.z + r * s) + DVec3::Y * (0.3 * size);
        let grey = DVec3::new(0.62, 0.60, 0.57) * random.range(0.75, 1.1);
        let turn = random.range(0.0, TAU);
        // A dark body, and a lit cap a little above it.
        painter.patch(
            at,
            facing(DVec3::new(c, 0.2, s), turn),
            DVec3::new(size, size * 0.75, size * 0.8),
            grey * 0.8,
            0.0,
        );
        painter.patch(
            at + (DVec3::Y + 0.6 * painter.light.sun) * (0.45 * size),
            facing(DVec3::Y + 0.5 * random.direction(), turn),
            DVec3::new(size * 0.75, size * 0.6, size * 0.35),
            grey,
            0.0,
        );
    }
}
