//! A glazed vase: broad and sharp highlights on a dark ground.

use glam::{DVec2, DVec3, dvec3};

use super::appearance::{Appearance, Daylight, smooth_step};
use super::field::{Field, Motion, Probe, SceneSetup, colour};
use super::{noise, sdf};
use potamoi_fields::voxels::Layout;

pub(super) struct Vase;

const FRAME: SceneSetup = SceneSetup {
    name: "vase",
    asks: "gloss",
    points: [88, 88, 104],
    corner: dvec3(-0.87, -0.87, -0.1),
    voxel: 0.02,
    layout: Layout::Linear,
    background: colour(700, 690, 760),
    eye: dvec3(1.6, -4.1, 2.35),
    target: dvec3(0.0, 0.0, 0.86),
    fov: 28.0,
    motion: Motion::Orbit(36.0),
};

const LIGHT: Daylight = Daylight {
    to_sun: dvec3(-0.55, -0.55, 0.628),
    sun: dvec3(0.78, 0.74, 0.68),
    sky: dvec3(0.42, 0.44, 0.50),
    ground: dvec3(0.20, 0.16, 0.13),
    reach: 0.25,
    stride: 0.25,
};

/// Outer radius at a relative height of 0 to 1.
fn profile(up: f64) -> f64 {
    let belly = 0.50 * (-((up - 0.42) / 0.30).powi(2)).exp();
    let foot = 0.23 * (-(up / 0.16).powi(2)).exp();
    let lip = 0.22 * smooth_step(0.80, 1.04, up).powi(2);
    0.13 + belly + foot * 0.5 + lip
}

const HEIGHT: f64 = 1.68;
const FOOT: f64 = 0.06;

/// Signed distance to first order: exact on the surface.
fn body(p: DVec3) -> f64 {
    let up = ((p.z - FOOT) / HEIGHT).clamp(0.0, 1.0);
    let e = 1e-3;
    let slope = (profile(up + e) - profile(up - e)) / (2.0 * e * HEIGHT);
    let out = (p.truncate().length() - profile(up)) / slope.hypot(1.0);
    // Hollow from a little above the foot on.
    let wall = out.max(-out - 0.07);
    let high = (p.z - FOOT - HEIGHT / 2.0).abs() - HEIGHT / 2.0;
    let q = DVec2::new(if up > 0.25 { wall } else { out }, high) + DVec2::splat(0.025);
    q.max(DVec2::ZERO).length() + q.max_element().min(0.0) - 0.025
}

fn table(p: DVec3) -> f64 {
    sdf::disc(p, 0.82, 0.05, 0.03)
}

fn distance(p: DVec3) -> f64 {
    body(p).min(table(p))
}

/// A studio: two soft boxes and a bright strip over a dim room.
fn studio(d: DVec3) -> DVec3 {
    let lamp = |to: DVec3, from: f64, until: f64| smooth_step(from, until, d.dot(to));
    let room = dvec3(0.16, 0.17, 0.20).lerp(dvec3(0.50, 0.53, 0.60), 0.5 + 0.5 * d.z);
    let key = dvec3(5.4, 5.0, 4.4) * lamp(dvec3(-0.62, -0.62, 0.48), 0.90, 0.99);
    let rim = dvec3(1.5, 1.9, 2.6) * lamp(dvec3(0.93, -0.2, 0.31), 0.80, 0.97);
    room + key + rim
}

impl Field for Vase {
    fn frame(&self) -> &'static SceneSetup {
        &FRAME
    }

    fn probe(&self, p: DVec3) -> Probe {
        let d = distance(p);
        Probe::solid(d, 0.6 * d, FRAME.voxel)
    }

    fn look(&self, p: DVec3) -> Appearance {
        let (normal, light) = LIGHT.at(distance, p, FRAME.voxel);
        if table(p) < body(p) {
            let ring = (p.truncate().length() * 40.0 + 3.0 * noise::octaves(p * 4.0, 2)).sin();
            let wood = dvec3(0.36, 0.22, 0.13) * (1.0 + 0.12 * ring);
            return Appearance::matte(wood * light);
        }
        let up = (p.z - FOOT) / HEIGHT;
        let turn = p.y.atan2(p.x);
        let drip = 0.035 * (turn * 7.0).sin() + 0.03 * (turn * 3.0 + 1.0).sin();
        let glaze = dvec3(0.03, 0.22, 0.30).lerp(
            dvec3(0.10, 0.46, 0.48),
            smooth_step(0.15, 0.75, up + 0.2 * noise::octaves(p * 4.0, 3)),
        );
        let clay = dvec3(0.52, 0.27, 0.16);
        let cream = dvec3(0.80, 0.74, 0.60);
        let band = smooth_step(0.07, 0.05, (up - 0.60 - drip * 0.6).abs());
        let albedo = clay
            .lerp(glaze, smooth_step(0.10, 0.14, up + drip))
            .lerp(cream, band);
        let gloss = smooth_step(0.08, 0.16, up + drip);
        Appearance::matte(albedo * light).reflecting(
            normal,
            DVec3::splat(0.07 * gloss),
            0.5 * gloss,
            studio,
        )
    }
}
