//! Balanced stones: diffuse solids in sun and shade.

use std::sync::LazyLock;

use glam::{DMat3, DVec3, dvec3};

use super::appearance::{Appearance, Daylight, smooth_step};
use super::field::{Field, Motion, Probe, SceneSetup, colour};
use super::{noise, sdf};
use potamoi_fields::voxels::Layout;

pub(super) struct Cairn;

const FRAME: SceneSetup = SceneSetup {
    name: "cairn",
    asks: "diffuse solids",
    points: [98, 98, 112],
    corner: dvec3(-1.0, -1.0, -0.12),
    voxel: 2.0 / 97.0,
    layout: Layout::Constant,
    background: colour(2990, 3310, 3560),
    eye: dvec3(2.3, -4.0, 2.35),
    target: dvec3(0.0, 0.0, 0.93),
    fov: 30.0,
    motion: Motion::Orbit(36.0),
};

const LIGHT: Daylight = Daylight {
    to_sun: dvec3(-0.52, -0.56, 0.645),
    sun: dvec3(0.98, 0.88, 0.70),
    sky: dvec3(0.52, 0.62, 0.74),
    ground: dvec3(0.26, 0.26, 0.20),
    reach: 0.24,
    stride: 0.25,
};

/// Centre, half axes, axis and angle of tilt, and colour of the stones.
const STONES: [(DVec3, DVec3, DVec3, f64, DVec3); 8] = [
    (
        dvec3(0.0, 0.0, 0.27),
        dvec3(0.60, 0.52, 0.27),
        dvec3(1.0, 0.4, 0.0),
        3.0,
        dvec3(0.46, 0.46, 0.48),
    ),
    (
        dvec3(0.06, -0.02, 0.68),
        dvec3(0.45, 0.42, 0.19),
        dvec3(0.3, 1.0, 0.0),
        -6.0,
        dvec3(0.64, 0.52, 0.42),
    ),
    (
        dvec3(-0.03, 0.02, 0.99),
        dvec3(0.39, 0.30, 0.15),
        dvec3(0.2, 1.0, 0.0),
        7.0,
        dvec3(0.38, 0.43, 0.46),
    ),
    (
        dvec3(0.04, 0.0, 1.26),
        dvec3(0.26, 0.25, 0.15),
        dvec3(1.0, 0.0, 0.0),
        9.0,
        dvec3(0.72, 0.67, 0.58),
    ),
    (
        dvec3(0.0, 0.01, 1.49),
        dvec3(0.22, 0.17, 0.10),
        dvec3(0.0, 1.0, 0.0),
        -9.0,
        dvec3(0.52, 0.36, 0.30),
    ),
    (
        dvec3(0.03, 0.0, 1.67),
        dvec3(0.11, 0.11, 0.095),
        dvec3(1.0, 1.0, 0.0),
        6.0,
        dvec3(0.42, 0.45, 0.47),
    ),
    (
        dvec3(0.68, -0.36, 0.10),
        dvec3(0.17, 0.13, 0.11),
        dvec3(0.0, 1.0, 0.0),
        10.0,
        dvec3(0.66, 0.62, 0.56),
    ),
    (
        dvec3(-0.58, -0.52, 0.08),
        dvec3(0.13, 0.15, 0.09),
        dvec3(1.0, 0.0, 0.0),
        12.0,
        dvec3(0.50, 0.38, 0.32),
    ),
];

/// Rotations into the stones' own axes.
static TILTS: LazyLock<[DMat3; 8]> = LazyLock::new(|| STONES.map(|s| sdf::turned(s.2, s.3)));

/// Signed distance, and the stone; `None` for the ground.
fn nearest(p: DVec3) -> (f64, Option<usize>) {
    // Uneven ground that falls off to a rounded rim.
    let ground = p - DVec3::Z * (0.008 * (p.x * 9.0).sin() * (p.y * 8.0 + 1.0).cos());
    let mut best = (sdf::disc(ground - DVec3::Z * -0.01, 0.95, 0.07, 0.05), None);
    for (i, (middle, half, ..)) in STONES.iter().enumerate() {
        let reach = (p - *middle).length() - half.max_element();
        if reach > best.0 {
            continue;
        }
        let own = TILTS[i] * (p - *middle);
        let d = sdf::ellipsoid(own, *half);
        if d < best.0 {
            best = (d, Some(i));
        }
    }
    best
}

impl Field for Cairn {
    fn frame(&self) -> &'static SceneSetup {
        &FRAME
    }

    fn probe(&self, p: DVec3) -> Probe {
        let (d, _) = nearest(p);
        Probe::solid(d, 0.8 * d, FRAME.voxel)
    }

    fn look(&self, p: DVec3) -> Appearance {
        let (normal, light) = LIGHT.at(|p| nearest(p).0, p, FRAME.voxel);
        let albedo = match nearest(p).1 {
            Some(i) => {
                let turned = TILTS[i] * (p - STONES[i].0);
                // Layers that wander, and a few pale spots.
                let wander = noise::octaves(p * 5.0, 2);
                let layer = (turned.z * 38.0 + 6.0 * wander).sin();
                let spots = smooth_step(0.62, 0.8, noise::value(p * 11.0));
                STONES[i].4 * (1.0 + 0.09 * layer + 0.35 * (wander - 0.5))
                    + DVec3::splat(0.10 * spots)
            }
            None => {
                let patch = noise::octaves(p * dvec3(4.0, 4.0, 1.0), 3);
                let moss = dvec3(0.30, 0.40, 0.17)
                    .lerp(dvec3(0.56, 0.52, 0.34), smooth_step(0.35, 0.7, patch));
                moss * (0.75 + 0.25 * normal.z)
            }
        };
        Appearance::matte(albedo * light)
    }
}
