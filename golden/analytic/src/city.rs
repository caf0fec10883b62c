//! Blocks of houses, towers and trees: hundreds of small details.

use glam::{DVec3, dvec3};

use super::appearance::{Appearance, Daylight, smooth_step};
use super::field::{Field, Motion, Probe, SceneSetup, colour};
use super::{noise, sdf};
use potamoi_fields::voxels::Layout;

pub(super) struct City;

const FRAME: SceneSetup = SceneSetup {
    name: "city",
    asks: "many small parts",
    points: [150, 150, 60],
    corner: dvec3(-1.12, -1.12, -0.11),
    voxel: 2.24 / 149.0,
    layout: Layout::Constant,
    background: colour(3270, 3520, 3730),
    eye: dvec3(2.3, -3.3, 2.5),
    target: dvec3(0.0, 0.0, 0.12),
    fov: 35.0,
    motion: Motion::Orbit(54.0),
};

const LIGHT: Daylight = Daylight {
    to_sun: dvec3(-0.70, -0.35, 0.622),
    sun: dvec3(1.0, 0.86, 0.66),
    sky: dvec3(0.56, 0.62, 0.74),
    ground: dvec3(0.38, 0.36, 0.35),
    reach: 0.06,
    stride: LOT / 2.0,
};

/// Distance between lots, and number of lots a side.
const LOT: f64 = 0.125;
const LOTS: i64 = 16;

/// The kind of object on a lot.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Ground,
    House(i64, i64),
    Tree(i64, i64),
}

/// Streets run between every fourth row of lots; a park lies in the middle.
fn street(i: i64) -> bool {
    i.rem_euclid(4) == 3
}

fn park(x: i64, y: i64) -> bool {
    (4..7).contains(&x) && (4..11).contains(&y)
}

/// Signed distance to the object on a lot, from the middle of its ground.
fn lot(p: DVec3, x: i64, y: i64) -> (f64, Part) {
    let nothing = (f64::INFINITY, Part::Ground);
    if !(0..LOTS - 1).contains(&x) || !(0..LOTS - 1).contains(&y) {
        return nothing;
    }
    let random = |k| noise::hash(x, y, k);
    if park(x, y) {
        let at = dvec3(random(1) - 0.5, random(2) - 0.5, 0.0) * (0.4 * LOT);
        let size = 0.036 + 0.016 * random(3);
        let crown = (p - at - DVec3::Z * (size + 0.03)).length() - size;
        return (crown, Part::Tree(x, y));
    }
    if street(x) || street(y) {
        return nothing;
    }
    // Higher to the middle.
    let from = ((x as f64 - 7.0).powi(2) + (y as f64 - 8.0).powi(2)).sqrt();
    let high = 0.07 + 0.08 * random(1) + 0.50 * random(2).powi(3) * (1.15 - 0.11 * from).max(0.1);
    let wide = LOT * (0.40 + 0.06 * random(3));
    let deep = LOT * (0.40 + 0.06 * random(4));
    let body = sdf::cuboid(
        p - DVec3::Z * (high / 2.0),
        dvec3(wide, deep, high / 2.0),
        0.006,
    );
    let d = if random(5) > 0.6 {
        // Set back at the top.
        let top = p - DVec3::Z * (high + 0.03);
        body.min(sdf::cuboid(
            top,
            dvec3(wide * 0.6, deep * 0.6, 0.035),
            0.006,
        ))
    } else {
        body
    };
    (d, Part::House(x, y))
}

fn base(p: DVec3) -> f64 {
    sdf::cuboid(p + DVec3::Z * 0.045, dvec3(1.08, 1.08, 0.045), 0.03)
}

fn nearest(p: DVec3) -> (f64, Part) {
    let mut best = (base(p), Part::Ground);
    // Towers are below this: far above, the slab they fill bounds them.
    let above = p.z - 0.72;
    if above > LOT {
        return (best.0.min(above), Part::Ground);
    }
    let at = p.truncate() / LOT + glam::DVec2::splat(LOTS as f64 / 2.0 - 0.5);
    let [x, y] = at.round().to_array().map(|v| v as i64);
    // The lot below and its neighbours on the side of the point.
    let side = |v: f64| if v - v.round() < 0.0 { -1 } else { 1 };
    for i in [x, x + side(at.x)] {
        for j in [y, y + side(at.y)] {
            let middle =
                dvec3(i as f64, j as f64, 0.0) - dvec3(1.0, 1.0, 0.0) * (LOTS as f64 / 2.0 - 0.5);
            let own = lot(p - middle * LOT, i, j);
            if own.0 < best.0 {
                best = own;
            }
        }
    }
    best
}

const ROOFS: [DVec3; 6] = [
    dvec3(0.74, 0.38, 0.26),
    dvec3(0.82, 0.72, 0.58),
    dvec3(0.62, 0.66, 0.70),
    dvec3(0.88, 0.84, 0.76),
    dvec3(0.36, 0.48, 0.58),
    dvec3(0.80, 0.54, 0.34),
];

impl Field for City {
    fn frame(&self) -> &'static SceneSetup {
        &FRAME
    }

    fn probe(&self, p: DVec3) -> Probe {
        let d = nearest(p).0;
        // What stands on other lots is at least half of one away.
        Probe::solid(d, d.min(0.5 * LOT), FRAME.voxel)
    }

    fn look(&self, p: DVec3) -> Appearance {
        let (normal, light) = LIGHT.at(|p| nearest(p).0, p, FRAME.voxel);
        let albedo = match nearest(p).1 {
            Part::House(x, y) => {
                let pick = noise::hash(x, y, 9) * ROOFS.len() as f64;
                let wall = ROOFS[(pick as usize).min(ROOFS.len() - 1)];
                let storey = 0.90 + 0.10 * (p.z * std::f64::consts::TAU / 0.07).cos();
                wall * if normal.z > 0.5 { 1.0 } else { storey }
            }
            Part::Tree(x, y) => {
                dvec3(0.24, 0.44, 0.17).lerp(dvec3(0.50, 0.52, 0.18), noise::hash(x, y, 8))
            }
            Part::Ground => {
                let at = p.truncate() / LOT + glam::DVec2::splat(LOTS as f64 / 2.0 - 0.5);
                let grass = smooth_step(3.4, 3.6, at.x)
                    * smooth_step(6.6, 6.4, at.x)
                    * smooth_step(3.4, 3.6, at.y)
                    * smooth_step(10.6, 10.4, at.y);
                dvec3(0.46, 0.46, 0.48).lerp(dvec3(0.38, 0.52, 0.24), grass)
            }
        };
        Appearance::matte(albedo * light)
    }
}
