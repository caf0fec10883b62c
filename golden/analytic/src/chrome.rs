//! Metal balls that reflect a sky, a horizon and a sun: their appearance depends entirely on the
//! direction.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use glam::{DVec2, DVec3, dvec3};

use super::appearance::{Appearance, Daylight, smooth_step};
use super::curve::Curve;
use super::field::{Field, Motion, Probe, SceneSetup, colour};
use super::sdf;
use potamoi_fields::voxels::Layout;

pub(super) struct Chrome;

const FRAME: SceneSetup = SceneSetup {
    name: "chrome",
    asks: "mirrors",
    points: [108, 108, 64],
    corner: dvec3(-1.08, -1.08, -0.16),
    voxel: 2.16 / 107.0,
    layout: Layout::Linear,
    background: colour(2350, 2800, 3300),
    eye: dvec3(1.4, -4.2, 2.0),
    target: dvec3(0.0, 0.0, 0.36),
    fov: 28.0,
    motion: Motion::Orbit(36.0),
};

const LIGHT: Daylight = Daylight {
    to_sun: TO_SUN,
    sun: dvec3(0.90, 0.82, 0.70),
    sky: dvec3(0.40, 0.48, 0.60),
    ground: dvec3(0.25, 0.22, 0.20),
    reach: 0.30,
    stride: 0.25,
};
const TO_SUN: DVec3 = dvec3(-0.50, -0.60, 0.624);

/// Centre, radius and metal colour of the balls.
const BALLS: [(DVec3, f64, DVec3); 5] = [
    (dvec3(0.02, 0.22, 0.50), 0.50, dvec3(0.90, 0.91, 0.92)),
    (dvec3(-0.55, -0.36, 0.29), 0.29, dvec3(0.98, 0.76, 0.36)),
    (dvec3(0.56, -0.38, 0.24), 0.24, dvec3(0.95, 0.60, 0.48)),
    (dvec3(-0.02, -0.66, 0.16), 0.16, dvec3(0.62, 0.80, 0.94)),
    (dvec3(0.80, 0.14, 0.14), 0.14, dvec3(0.90, 0.91, 0.92)),
];

/// The sky, brighter towards the horizon, over a chequered plain.
fn outdoors(d: DVec3) -> DVec3 {
    const HORIZON: f64 = 0.03;
    if d.z >= HORIZON {
        sky(d)
    } else if d.z <= -HORIZON {
        plain(d)
    } else {
        plain(d).lerp(sky(d), smooth_step(-HORIZON, HORIZON, d.z))
    }
}

fn sky(d: DVec3) -> DVec3 {
    // The square root is not as steep at the horizon.
    static RISE: LazyLock<Curve> = LazyLock::new(|| Curve::new([0.0, 1.0], 4096, |v| v.powf(1.1)));
    let rise = RISE.at(d.z.max(0.0).sqrt());
    let sky = dvec3(0.92, 0.90, 0.86).lerp(dvec3(0.20, 0.42, 0.78), rise);
    let toward = d.dot(TO_SUN);
    if toward <= 0.70 {
        return sky;
    }
    let disc = smooth_step(0.955, 0.985, toward);
    let glow = smooth_step(0.70, 1.0, toward);
    sky + dvec3(2.6, 2.3, 1.7) * disc + dvec3(0.30, 0.22, 0.10) * glow
}

/// A plain below the balls, in squares that fade with distance.
fn plain(d: DVec3) -> DVec3 {
    static NEAR: LazyLock<Curve> = LazyLock::new(|| {
        Curve::new([0.0, 1.0], 4096, |down| {
            let away = (1.0 - down * down).sqrt() / down.max(1e-3);
            (-0.225 * away).exp()
        })
    });
    let down = (-d.z).max(1e-3);
    let near = NEAR.at(down);
    let square = 0.5 + 0.5 * chequered(d.truncate() * (0.9 * 3.2 / down)) * near;
    let plain = dvec3(0.16, 0.14, 0.14).lerp(dvec3(0.78, 0.72, 0.64), square);
    plain.lerp(dvec3(0.66, 0.62, 0.58), 1.0 - near)
}

/// A chequered pattern from -1 to 1, in squares of half a period with soft edges.
fn chequered(at: DVec2) -> f64 {
    static WAVE: LazyLock<Curve> =
        LazyLock::new(|| Curve::new([-1.0, 1.0], 8192, |turn| (3.0 * (TAU * turn).sin()).tanh()));
    let wave = |v: f64| WAVE.at(v - v as i64 as f64);
    let turns = at * TAU.recip();
    wave(turns.x) * wave(turns.y)
}

fn ball(p: DVec3) -> (f64, usize) {
    let mut best = (f64::INFINITY, 0);
    for (i, (middle, radius, _)) in BALLS.iter().enumerate() {
        let d = (p - *middle).length() - radius;
        if d < best.0 {
            best = (d, i);
        }
    }
    best
}

fn ground(p: DVec3) -> f64 {
    sdf::disc(p + DVec3::Z * 0.06, 1.02, 0.06, 0.02)
}

fn distance(p: DVec3) -> f64 {
    ball(p).0.min(ground(p))
}

impl Field for Chrome {
    fn frame(&self) -> &'static SceneSetup {
        &FRAME
    }

    fn probe(&self, p: DVec3) -> Probe {
        let d = distance(p);
        Probe::solid(d, d, FRAME.voxel)
    }

    fn look(&self, p: DVec3) -> Appearance {
        let (d, i) = ball(p);
        if d < ground(p) {
            let metal = BALLS[i].2;
            let normal = (p - BALLS[i].0).normalize_or_zero();
            // The floor darkens what faces it, near where it touches.
            let low = (p.z / BALLS[i].1).clamp(0.0, 1.0);
            return Appearance::matte(DVec3::ZERO).reflecting(
                normal,
                metal * (0.35 + 0.65 * low.sqrt()) * 0.94,
                0.0,
                outdoors,
            );
        }
        let (_, light) = LIGHT.at(distance, p, FRAME.voxel);
        let square = 0.5 + 0.5 * chequered(p.truncate() * (TAU / 0.68));
        let albedo = dvec3(0.27, 0.25, 0.26).lerp(dvec3(0.86, 0.80, 0.72), square);
        Appearance::matte(albedo * light)
    }
}
