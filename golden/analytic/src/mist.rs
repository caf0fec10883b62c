//! Hills in morning fog, which lies in the valleys, thick below and torn above.

use std::sync::LazyLock;

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::appearance::{Appearance, Daylight, smooth_step};
use super::field::{Field, Motion, Probe, SceneSetup, colour};
use super::heights::Heights;
use super::noise;
use potamoi_fields::voxels::Layout;

pub(super) struct Mist;

const FRAME: SceneSetup = SceneSetup {
    name: "mist",
    asks: "fog",
    points: [120, 120, 62],
    corner: dvec3(-1.2, -1.2, -0.12),
    voxel: 2.4 / 119.0,
    layout: Layout::Constant,
    background: colour(2960, 3050, 3300),
    eye: dvec3(2.2, -3.9, 2.5),
    target: dvec3(0.0, 0.0, 0.26),
    fov: 28.0,
    motion: Motion::Orbit(36.0),
};

const LIGHT: Daylight = Daylight {
    to_sun: dvec3(-0.78, -0.35, 0.519),
    sun: dvec3(1.05, 0.78, 0.52),
    sky: dvec3(0.42, 0.52, 0.70),
    ground: dvec3(0.20, 0.20, 0.18),
    reach: 0.22,
    stride: 0.25,
};

const RADIUS: f64 = 1.15;

/// Position, height and half width of the hills.
const HILLS: [(DVec2, f64, f64); 11] = [
    (dvec2(0.22, 0.32), 0.66, 0.34),
    (dvec2(-0.20, 0.48), 0.30, 0.22),
    (dvec2(0.58, 0.12), 0.24, 0.20),
    (dvec2(-0.62, 0.16), 0.40, 0.28),
    (dvec2(-0.78, -0.34), 0.20, 0.16),
    (dvec2(-0.34, -0.50), 0.24, 0.18),
    (dvec2(0.10, -0.34), 0.17, 0.15),
    (dvec2(0.46, -0.62), 0.26, 0.20),
    (dvec2(0.86, -0.28), 0.22, 0.18),
    (dvec2(0.74, 0.62), 0.28, 0.22),
    (dvec2(-0.02, -0.86), 0.16, 0.15),
];

/// The land up to a little beyond [`FAR`], to less than 5e-6, which is well below a thousandth of
/// a voxel.
static LAND: LazyLock<Heights> = LazyLock::new(|| Heights::new(RADIUS + FAR + 0.01, 320, land));

/// Distance from the rim beyond which the land does not matter: it is too far from shadow rays to
/// darken them.
const FAR: f64 = 0.34;

/// Height of the land and its slopes along x and y.
fn land(at: DVec2) -> (f64, DVec2) {
    let (mut height, mut slope) = (0.0, DVec2::ZERO);
    for (middle, high, wide) in HILLS {
        let off = (at - middle) / wide;
        let below = 1.0 / (1.0 + 1.6 * off.length_squared());
        let own = high * below * below;
        height += own;
        slope -= off * (6.4 * own * below / wide);
    }
    let [x, y] = (at * 13.0 + dvec2(0.7, 2.0)).to_array();
    let [u, v] = (dvec2(at.x - at.y, at.x + at.y) * 17.0).to_array();
    height += 0.016 * x.sin() * y.cos() + 0.009 * u.sin() * v.cos();
    slope += 13.0 * 0.016 * dvec2(x.cos() * y.cos(), -x.sin() * y.sin());
    let (du, dv) = (
        0.009 * 17.0 * u.cos() * v.cos(),
        -0.009 * 17.0 * u.sin() * v.sin(),
    );
    slope += dvec2(du + dv, dv - du);
    (height, slope)
}

/// Signed distance to first order: exact on the surface, a lower bound far from the land.
fn distance(p: DVec3) -> f64 {
    let at = p.truncate();
    let rim = at.length() - RADIUS;
    let below = rim.max(-0.08 - p.z);
    if rim > FAR {
        return below;
    }
    LAND.at(at).map_or(below, |(height, slope)| {
        below.max((p.z - height) / (1.0 + slope.length_squared()).sqrt())
    })
}

/// Maximum optical depth of the fog per unit of length.
const THICKEST: f64 = 7.5;

/// Optical depth of the fog per unit of length.
fn fog(p: DVec3) -> f64 {
    let rim = smooth_step(RADIUS - 0.02, RADIUS - 0.30, p.truncate().length());
    // The level is as if the noise were 0, or below.
    let thickest = THICKEST * rim * smooth_step(0.46, 0.14, p.z - 0.15);
    if thickest <= 0.0 {
        return 0.0;
    }
    let torn = noise::octaves(p * dvec3(3.0, 3.0, 5.0) + dvec3(0.3, 7.7, 2.2), 2);
    let level = smooth_step(0.46, 0.14, p.z + 0.30 * (torn - 0.5));
    THICKEST * level * rim * smooth_step(0.28, 0.66, torn)
}

impl Field for Mist {
    fn frame(&self) -> &'static SceneSetup {
        &FRAME
    }

    fn probe(&self, p: DVec3) -> Probe {
        let d = distance(p);
        // Above the fog the hills alone bound the way.
        let above = (p.z - 0.62).max(p.truncate().length() - RADIUS);
        let bound = if above > 0.0 {
            d.min(above)
        } else {
            d.min(0.0)
        };
        let solid = Probe::solid(d, 0.55 * bound, FRAME.voxel);
        if solid.density >= THICKEST {
            return solid;
        }
        let hazy = solid.with_haze(fog(p), FRAME.voxel);
        let apart = 0.7 * d - FRAME.voxel;
        Probe {
            step: apart.clamp(hazy.step.min(FRAME.voxel / 8.0), FRAME.voxel / 2.0),
            ..hazy
        }
    }

    fn look(&self, p: DVec3) -> Appearance {
        let d = distance(p);
        let lit = smooth_step(-0.05, 0.45, p.z);
        let toward = 0.5 - 0.5 * p.truncate().dot(dvec2(0.9, 0.4)) / RADIUS;
        let shaded = dvec3(0.58, 0.64, 0.78);
        let bright = dvec3(1.0, 0.86, 0.72);
        let haze = shaded.lerp(bright, (0.30 + 0.5 * toward) * (0.45 + 0.55 * lit));
        if d > 2.0 * FRAME.voxel {
            return Appearance::matte(haze);
        }
        let (normal, light) = LIGHT.at(distance, p, FRAME.voxel);
        let up = smooth_step(0.45, 0.78, normal.z);
        let grain = noise::octaves(p * 9.0, 2);
        let rock = dvec3(0.46, 0.40, 0.37) * (0.75 + 0.5 * grain);
        let meadow =
            dvec3(0.30, 0.40, 0.20).lerp(dvec3(0.50, 0.48, 0.26), smooth_step(0.15, 0.5, p.z));
        let snow = smooth_step(0.42, 0.58, p.z + 0.12 * (grain - 0.5));
        let earth = dvec3(0.36, 0.27, 0.22);
        let side = smooth_step(RADIUS - 0.035, RADIUS - 0.015, p.truncate().length());
        let albedo = rock
            .lerp(meadow, up)
            .lerp(dvec3(0.92, 0.93, 0.96), snow)
            .lerp(earth, side);
        let solid = sdf_share(d);
        Appearance::matte(haze.lerp(albedo * light, solid))
    }
}

/// Weight of the solid in the colour: 1 up to a voxel outside it.
fn sdf_share(d: f64) -> f64 {
    smooth_step(2.0 * FRAME.voxel, FRAME.voxel, d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_held_land_is_the_land() {
        for i in 0..200_000 {
            // Points that fill the square evenly, off the grid.
            let turn = |by: f64| (f64::from(i) * by).fract() * 2.0 - 1.0;
            let at = dvec2(turn(0.754_877_666), turn(0.569_840_291)) * (RADIUS + FAR);
            let (height, slope) = land(at);
            let (held, tilt) = LAND.at(at).unwrap_or_default();
            assert!((held - height).abs() < 5e-6, "{at}: {held} for {height}");
            assert!((tilt - slope).length() < 2e-3, "{at}: {tilt} for {slope}");
        }
        assert!(LAND.at(dvec2(0.0, RADIUS + FAR + 0.02)).is_none());
        assert!(LAND.at(DVec2::NAN).is_none());
    }
}
