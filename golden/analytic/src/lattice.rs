//! Thin rods in a sphere: empty space close to surfaces.

use glam::{DVec2, DVec3, Vec3Swizzles as _, dvec3};

use super::appearance::{Appearance, wheel};
use super::field::{Field, Motion, Probe, SceneSetup, colour};
use super::sdf;
use potamoi_fields::voxels::Layout;

pub(super) struct Lattice;

const FRAME: SceneSetup = SceneSetup {
    name: "lattice",
    asks: "thin parts",
    points: [136, 136, 136],
    corner: dvec3(-1.0, -1.0, -1.0),
    voxel: 2.0 / 135.0,
    layout: Layout::Constant,
    background: colour(3890, 3850, 3740),
    eye: dvec3(2.1, -3.6, 1.75),
    target: dvec3(0.0, 0.0, 0.0),
    fov: 28.0,
    motion: Motion::Orbit(36.0),
};

/// Distance between rods, and half their width.
const PERIOD: f64 = 0.42;
const ROD: f64 = 0.024;
/// Radius of the balls where rods meet.
const KNOT: f64 = 0.046;
const RADIUS: f64 = 0.95;

fn distance(p: DVec3) -> f64 {
    // The nearest corner of a cubic grid, along which three rods run.
    let q = p - (p / PERIOD).round() * PERIOD;
    let rod = |a: f64, b: f64| DVec2::new(a, b).length() - ROD;
    let rods = rod(q.x, q.y).min(rod(q.y, q.z)).min(rod(q.z, q.x));
    let open = sdf::smooth_min(rods, q.length() - KNOT, 0.02);
    let inside = open.max(p.length() - RADIUS);
    // Three hoops hold the ends.
    let hoop = |q: DVec3| sdf::torus(q, RADIUS, 0.027);
    inside.min(hoop(p)).min(hoop(p.yzx())).min(hoop(p.zxy()))
}

impl Field for Lattice {
    fn frame(&self) -> &'static SceneSetup {
        &FRAME
    }

    fn probe(&self, p: DVec3) -> Probe {
        let d = distance(p);
        Probe::solid(d, 0.9 * d, FRAME.voxel)
    }

    fn look(&self, p: DVec3) -> Appearance {
        let normal = sdf::normal(distance, p, 0.5 * FRAME.voxel);
        let facing = 0.5 + 0.5 * normal.dot(dvec3(-0.5, -0.6, 0.63));
        // Paler to the middle, as through haze.
        let hue = wheel(0.12 + 0.30 * (p.x - 0.5 * p.y) + 0.36 * p.z);
        let albedo = hue * 0.56 + DVec3::splat(0.16);
        Appearance::matte(albedo * (0.34 + 0.80 * facing * facing))
    }
}
