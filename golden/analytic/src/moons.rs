//! A planet with rings and two moons: almost all of the volume is empty.

use glam::{DMat3, DVec3, dvec3};

use super::appearance::{Appearance, smooth_step};
use super::field::{Field, Motion, Probe, SceneSetup, colour};
use super::{noise, sdf};
use potamoi_fields::voxels::Layout;

pub(super) struct Moons;

const FRAME: SceneSetup = SceneSetup {
    name: "moons",
    asks: "mostly void",
    points: [150, 150, 96],
    corner: dvec3(-1.25, -1.25, -0.8),
    voxel: 2.5 / 149.0,
    layout: Layout::Constant,
    background: colour(46, 52, 98),
    eye: dvec3(1.9, -4.3, 1.75),
    target: dvec3(0.0, 0.0, 0.0),
    fov: 29.0,
    motion: Motion::Orbit(36.0),
};

const TO_SUN: DVec3 = dvec3(-0.66, -0.60, 0.452);
const PLANET: f64 = 0.34;
/// Inner and outer radius of the rings, and half their thickness.
const RINGS: [f64; 2] = [0.46, 0.80];
const THICK: f64 = 0.012;
/// Centre, radius and colour.
const MOONS: [(DVec3, f64, DVec3); 3] = [
    (dvec3(0.92, -0.42, 0.34), 0.085, dvec3(0.80, 0.74, 0.66)),
    (dvec3(-0.93, -0.30, 0.42), 0.055, dvec3(0.56, 0.66, 0.76)),
    (dvec3(0.48, 0.86, -0.46), 0.10, dvec3(0.74, 0.52, 0.40)),
];

/// Converts to the planet's own frame, whose equator is the plane z = 0.
fn own(p: DVec3) -> DVec3 {
    let tilt: DMat3 = sdf::turned(dvec3(0.8, 0.6, 0.0), -14.0);
    tilt * p
}

fn planet(p: DVec3) -> f64 {
    p.length() - PLANET
}

fn moon(p: DVec3) -> (f64, usize) {
    let mut best = (f64::INFINITY, 0);
    for (i, (middle, radius, _)) in MOONS.iter().enumerate() {
        let d = (p - *middle).length() - radius;
        if d < best.0 {
            best = (d, i);
        }
    }
    best
}

/// A lower bound of the distance to the rings.
fn rings(own: DVec3) -> f64 {
    let across = own.truncate().length();
    let out = (RINGS[0] - across).max(across - RINGS[1]).max(0.0);
    out.hypot((own.z.abs() - 3.0 * THICK).max(0.0))
}

/// Density of the rings at a distance from the axis, relative to its maximum.
fn fullness(across: f64) -> f64 {
    let ends = smooth_step(RINGS[0], RINGS[0] + 0.03, across)
        * smooth_step(RINGS[1], RINGS[1] - 0.03, across);
    let gap = 1.0 - 0.92 * (-((across - 0.655) / 0.018).powi(2)).exp();
    ends * gap * (0.72 + 0.28 * (across * 75.0).cos())
}

/// The fraction of the sun that the planet does not hide.
fn lit(p: DVec3) -> f64 {
    let along = p.dot(TO_SUN);
    let off = (p - TO_SUN * along).length();
    if along < 0.0 {
        smooth_step(PLANET - 0.02, PLANET + 0.03, off)
    } else {
        1.0
    }
}

impl Field for Moons {
    fn frame(&self) -> &'static SceneSetup {
        &FRAME
    }

    fn probe(&self, p: DVec3) -> Probe {
        let q = own(p);
        let d = planet(p).min(moon(p).0);
        let ring = rings(q);
        let solid = Probe::solid(d, d.min(ring), FRAME.voxel);
        if ring > 0.0 {
            return solid;
        }
        // A Gaussian layer, cut where it has all but ended.
        let layer = (-(q.z / THICK).powi(2)).exp() - (-9f64).exp();
        let density = 46.0 * layer * fullness(q.truncate().length());
        let haze = solid.with_haze(density, FRAME.voxel);
        Probe {
            step: FRAME.voxel / 8.0,
            ..haze
        }
    }

    fn look(&self, p: DVec3) -> Appearance {
        let q = own(p);
        let (moon_d, i) = moon(p);
        let d = planet(p);
        let lambert = |normal: DVec3| 0.07 + 1.08 * smooth_step(-0.12, 1.1, normal.dot(TO_SUN));
        if moon_d < d.min(rings(q) + FRAME.voxel) {
            let normal = (p - MOONS[i].0).normalize_or_zero();
            let spots = noise::octaves(p * 16.0, 3);
            return Appearance::matte(MOONS[i].2 * (0.62 + 0.66 * spots) * lambert(normal) * 1.15);
        }
        if d < 2.0 * FRAME.voxel {
            let normal = p.normalize_or_zero();
            let latitude = own(normal).z;
            let storm = noise::octaves(own(normal) * dvec3(2.4, 2.4, 5.0), 4) - 0.5;
            let band = (latitude * 15.0 + 2.4 * storm).sin();
            let broad = (latitude * 5.0 + 1.0).sin();
            let albedo = dvec3(0.93, 0.70, 0.45)
                .lerp(dvec3(0.70, 0.38, 0.22), 0.5 + 0.5 * band)
                .lerp(dvec3(0.98, 0.90, 0.76), 0.30 + 0.30 * broad);
            // The rings' shadow on it.
            let to_plane = -own(p).z / own(TO_SUN).z;
            let above = own(p) + own(TO_SUN) * to_plane;
            let shade = if to_plane > 0.0 {
                1.0 - 0.6 * fullness(above.truncate().length())
            } else {
                1.0
            };
            return Appearance::matte(albedo * lambert(normal) * shade);
        }
        let across = q.truncate().length();
        let tone = smooth_step(RINGS[0], RINGS[1], across);
        let dust = dvec3(0.86, 0.72, 0.54).lerp(dvec3(0.62, 0.64, 0.70), tone);
        Appearance::matte(dust * (0.10 + 0.90 * lit(p)) * (0.86 + 0.14 * (across * 75.0).cos()))
    }
}
