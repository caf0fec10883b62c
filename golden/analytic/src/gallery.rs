//! A room with pictures, seen from within: large flat walls, light from above.

use glam::{DVec3, dvec3};

use super::appearance::{Appearance, smooth_step, wheel};
use super::field::{Field, Motion, Probe, SceneSetup, colour};
use super::{noise, sdf};
use potamoi_fields::voxels::Layout;

pub(super) struct Gallery;

const FRAME: SceneSetup = SceneSetup {
    name: "gallery",
    asks: "large flat walls",
    points: [148, 180, 76],
    corner: dvec3(-2.2, -2.7, -0.1),
    voxel: 0.03,
    layout: Layout::Constant,
    background: colour(3300, 3300, 3300),
    eye: dvec3(1.25, -2.15, 1.18),
    target: dvec3(-0.35, 2.2, 0.86),
    fov: 62.0,
    motion: Motion::Pan(18.0),
};

/// Half the size of the room, which is centred.
const ROOM: DVec3 = dvec3(2.05, 2.55, 1.0);
const MIDDLE: DVec3 = dvec3(0.0, 0.0, 1.0);

/// A picture: its wall, position along it, half width and half height, and the number of its
/// painting.
const PICTURES: [(Wall, f64, f64, f64, f64); 7] = [
    (Wall::Back, -1.05, 0.46, 0.56, 0.0),
    (Wall::Back, 0.62, 0.82, 0.50, 1.0),
    (Wall::Left, -0.9, 0.72, 0.52, 2.0),
    (Wall::Left, 1.05, 0.50, 0.50, 3.0),
    (Wall::Right, -0.6, 0.60, 0.46, 4.0),
    (Wall::Right, 1.2, 0.62, 0.52, 5.0),
    (Wall::Front, 0.0, 0.80, 0.50, 6.0),
];
const HANG: f64 = 1.08;

#[derive(Clone, Copy, PartialEq)]
enum Wall {
    Back,
    Front,
    Left,
    Right,
}

impl Wall {
    /// Coordinates along the wall, up, and away from it.
    fn own(self, p: DVec3) -> DVec3 {
        match self {
            Self::Back => dvec3(p.x, p.z, ROOM.y - p.y),
            Self::Front => dvec3(-p.x, p.z, ROOM.y + p.y),
            Self::Left => dvec3(p.y, p.z, ROOM.x + p.x),
            Self::Right => dvec3(-p.y, p.z, ROOM.x - p.x),
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Part {
    Room,
    Picture(usize),
    Bench,
    Plinth,
    Ball,
}

fn nearest(p: DVec3) -> (f64, Part) {
    let q = (p - MIDDLE).abs() - ROOM;
    let mut best = (-q.max_element(), Part::Room);
    for (i, (wall, middle, wide, high, _)) in PICTURES.iter().enumerate() {
        let at = wall.own(p) - dvec3(*middle, HANG, 0.0);
        let d = sdf::cuboid(at, dvec3(*wide, *high, 0.065), 0.01);
        if d < best.0 {
            best = (d, Part::Picture(i));
        }
    }
    let mut offer = |d: f64, part| {
        if d < best.0 {
            best = (d, part);
        }
    };
    let bench = p - dvec3(0.0, 0.55, 0.0);
    let seat = sdf::cuboid(bench - DVec3::Z * 0.40, dvec3(0.85, 0.24, 0.05), 0.02);
    let legs = sdf::cuboid(
        dvec3(bench.x.abs() - 0.62, bench.y, bench.z - 0.17),
        dvec3(0.05, 0.20, 0.19),
        0.01,
    );
    offer(seat.min(legs), Part::Bench);
    let plinth = p - dvec3(-1.3, 1.45, 0.0);
    offer(
        sdf::cuboid(plinth - DVec3::Z * 0.30, dvec3(0.22, 0.22, 0.32), 0.015),
        Part::Plinth,
    );
    offer((plinth - DVec3::Z * 0.83).length() - 0.22, Part::Ball);
    best
}

/// The colour of a painting at a position of its canvas, whose sides are about 1.
fn painting(number: f64, x: f64, y: f64) -> DVec3 {
    let turn = 0.55 + 0.13 * number;
    let flow = noise::octaves(dvec3(x * 1.3, y * 1.3, number * 7.0), 3);
    let low = wheel(turn + 0.62) * 0.30 + DVec3::splat(0.14);
    let high = wheel(turn + 0.08) * 0.36 + DVec3::splat(0.46);
    let hills = smooth_step(-0.04, 0.04, y - 0.9 * (flow - 0.5) + 0.12);
    let sun = smooth_step(0.24, 0.19, (x - 0.25).hypot(y - 0.30));
    let far = high * (0.82 + 0.22 * y);
    let land = low.lerp(
        high,
        0.35 * smooth_step(
            0.35,
            0.65,
            noise::octaves(dvec3(x * 2.4, y * 5.0, number), 2),
        ),
    );
    land.lerp(far, hills)
        .lerp(dvec3(0.98, 0.90, 0.72), sun * hills)
}

impl Field for Gallery {
    fn frame(&self) -> &'static SceneSetup {
        &FRAME
    }

    fn probe(&self, p: DVec3) -> Probe {
        let d = nearest(p).0;
        Probe::solid(d, d, FRAME.voxel)
    }

    fn look(&self, p: DVec3) -> Appearance {
        let distance = |p: DVec3| nearest(p).0;
        let normal = sdf::normal(distance, p, 0.5 * FRAME.voxel);
        let part = nearest(p).1;
        let surface = p - normal * distance(p);
        // Corners are darker, and so is what stands close to something.
        let mut open = 1.0;
        for (away, share) in [(0.08, 0.20), (0.22, 0.20), (0.50, 0.16)] {
            open -= share * (1.0 - distance(surface + normal * away) / away).clamp(0.0, 1.0);
        }
        // A skylight along the middle of the ceiling.
        let lamp = dvec3(0.0, p.y.clamp(-1.7, 1.7), 1.9) - surface;
        let facing = (normal.dot(lamp.normalize_or_zero()) + 0.25).max(0.0) / 1.25;
        let light =
            dvec3(1.0, 0.96, 0.90) * (0.42 + 1.75 * facing / (0.9 + lamp.length_squared())) * open;
        let albedo = match part {
            Part::Room if normal.z > 0.7 => {
                let plank = (p.x / 0.24).floor();
                let grain = noise::octaves(
                    dvec3(plank * 3.7, p.y * 0.9, 0.5) + dvec3(p.x * 5.0, 0.0, 0.0),
                    2,
                );
                let seam =
                    smooth_step(0.0, 0.035, (p.x / 0.24 - (p.x / 0.24).round()).abs() * 0.24);
                dvec3(0.62, 0.43, 0.27) * (0.72 + 0.5 * grain) * (0.72 + 0.28 * seam)
            }
            Part::Room if normal.z < -0.7 => {
                let inside =
                    smooth_step(0.66, 0.58, p.x.abs()) * smooth_step(1.86, 1.78, p.y.abs());
                return Appearance::matte(
                    (dvec3(0.86, 0.85, 0.83) * 0.86 * open).lerp(dvec3(1.0, 0.99, 0.97), inside),
                );
            }
            Part::Room => {
                let skirting = smooth_step(0.14, 0.10, p.z);
                dvec3(0.84, 0.82, 0.77).lerp(dvec3(0.44, 0.40, 0.36), skirting)
            }
            Part::Picture(i) => {
                let (wall, middle, wide, high, number) = PICTURES[i];
                let at = wall.own(p) - dvec3(middle, HANG, 0.0);
                let edge = (wide - at.x.abs()).min(high - at.y.abs());
                let frame = smooth_step(0.085, 0.060, edge);
                let scale = 0.5 / high;
                painting(number, at.x * scale, at.y * scale).lerp(dvec3(0.20, 0.14, 0.09), frame)
            }
            Part::Bench => dvec3(0.30, 0.17, 0.10),
            Part::Plinth => dvec3(0.88, 0.87, 0.84),
            Part::Ball => dvec3(0.82, 0.33, 0.20),
        };
        Appearance::matte(albedo * light)
    }
}
