//! Grass, flowers, the tree, fallen petals and butterflies.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use super::island::{RADIUS, from_pond, on_ground};
use super::paint::{Painter, Stroke, facing};
use super::random::Random;

/// A ball of blossom.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ball {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

/// The balls of the tree's crown.
pub(super) fn crown(random: &mut Random) -> Vec<Ball> {
    let middle = DVec3::new(-0.22, 1.62, -0.12);
    let mut balls = vec![Ball {
        centre: middle + DVec3::Y * 0.14,
        radius: 0.46,
    }];
    for (ring, height, far) in [(7, -0.10, 0.62), (4, 0.34, 0.34)] {
        for i in 0..ring {
            let angle = TAU * (f64::from(i) + random.range(-0.25, 0.25)) / f64::from(ring);
            let (s, c) = angle.sin_cos();
            let far = far * random.range(0.85, 1.15);
            balls.push(Ball {
                centre: middle
                    + DVec3::new(far * c, height + random.range(-0.12, 0.12), far * s * 0.9),
                radius: random.range(0.28, 0.38),
            });
        }
    }
    balls
}

/// Centre of the trunk at a fraction of its height.
fn trunk_at(share: f64) -> DVec3 {
    let bend = 0.16 * (2.6 * share).sin();
    on_ground(-0.22, -0.12) + DVec3::new(bend - 0.08 * share, 1.22 * share, -0.06 * share)
}

fn trunk_radius(share: f64) -> f64 {
    0.085 - 0.045 * share + 0.07 * (-9.0 * share).exp()
}

/// Bark in strips, and branches to the balls of the crown.
pub(super) fn trunk(painter: &mut Painter, random: &mut Random, crown: &[Ball]) {
    let bark = DVec3::new(0.42, 0.29, 0.22);
    let (rows, columns) = (18, 9);
    for row in 0..rows {
        let share = (f64::from(row) + 0.5) / f64::from(rows);
        let along = (trunk_at(share + 0.01) - trunk_at(share - 0.01)).normalize();
        for column in 0..columns {
            let angle = TAU * (f64::from(column) + 0.5 * f64::from(row % 2)) / f64::from(columns);
            let out = facing(along, angle).x_axis;
            let at = trunk_at(share) + out * trunk_radius(share);
            painter.patch(
                at,
                DMat3::from_cols(along.cross(out), along, out),
                DVec3::new(0.020, 0.045, 0.012),
                bark * random.range(0.7, 1.25),
                0.0,
            );
        }
    }
    for ball in crown {
        let start = trunk_at(random.range(0.78, 1.0));
        let steps = 7;
        let mut from = start;
        for step in 1..=steps {
            let share = f64::from(step) / f64::from(steps);
            let sag = DVec3::Y * (0.10 * (share * std::f64::consts::PI).sin());
            let to = start.lerp(ball.centre, share) - sag * 0.5 + 0.012 * random.direction();
            let out = (painter.light.sun - DVec3::Y * 0.4).normalize();
            painter.needle(from, to, 0.024 - 0.013 * share, bark, out);
            from = to;
        }
    }
}

/// Petals over the crown's balls, pale outside and deep-coloured inside.
pub(super) fn blossom(painter: &mut Painter, random: &mut Random, crown: &[Ball]) {
    let pale = DVec3::new(1.0, 0.80, 0.86);
    let deep = DVec3::new(0.90, 0.40, 0.58);
    let leaf = DVec3::new(0.45, 0.52, 0.20);
    for ball in crown {
        let count = (1150.0 * ball.radius * ball.radius) as u32;
        for _ in 0..count {
            let out = random.direction();
            let share = random.range(0.5, 1.08);
            let at = ball.centre + out * (ball.radius * share) * DVec3::new(1.0, 0.86, 1.0);
            let mix = (1.6 * (share - 0.5)).clamp(0.0, 1.0);
            let mut albedo = deep.lerp(pale, mix * random.range(0.6, 1.0));
            if random.unit() < 0.07 {
                albedo = leaf;
            }
            let normal = out + 0.7 * random.direction() + DVec3::Y * 0.25;
            let size = random.range(0.026, 0.046);
            painter.patch(
                at,
                facing(normal, random.range(0.0, TAU)),
                DVec3::new(size, size * random.range(0.55, 0.8), 0.010),
                albedo * random.range(0.9, 1.05),
                0.16,
            );
        }
    }
}

/// A free place on the meadow.
fn place(random: &mut Random, reach: f64) -> DVec3 {
    loop {
        let r = reach * random.unit().sqrt();
        let (s, c) = random.range(0.0, TAU).sin_cos();
        let trunk = (r * c + 0.22).hypot(r * s + 0.12);
        if from_pond(r * c, r * s) > 0.09 && trunk > 0.16 {
            return on_ground(r * c, r * s);
        }
    }
}

/// Blades of two strokes, dark at the foot and light at the tip.
pub(super) fn grass(painter: &mut Painter, random: &mut Random) {
    for _ in 0..620 {
        let foot = place(random, RADIUS * 0.985);
        let lean = DVec3::new(random.range(-0.5, 0.5), 1.0, random.range(-0.5, 0.5)).normalize();
        let tall = random.range(0.06, 0.15);
        let middle = foot + lean * (0.55 * tall);
        let tip = middle + (lean + DVec3::new(0.35, -0.1, 0.2)).normalize() * (0.5 * tall);
        let green = DVec3::new(0.33, 0.52, 0.14).lerp(DVec3::new(0.55, 0.66, 0.22), random.unit());
        painter.needle(foot, middle, 0.0065, green * 0.85, DVec3::Y);
        painter.needle(middle, tip, 0.0045, green * 1.25, DVec3::Y);
    }
}

/// Stems with five or six petals around a yellow heart.
pub(super) fn flowers(painter: &mut Painter, random: &mut Random) {
    let kinds = [
        DVec3::new(0.92, 0.20, 0.16),
        DVec3::new(0.98, 0.78, 0.16),
        DVec3::new(0.58, 0.36, 0.86),
        DVec3::new(0.97, 0.95, 0.92),
        DVec3::new(0.98, 0.52, 0.18),
        DVec3::new(0.36, 0.50, 0.95),
    ];
    for _ in 0..84 {
        let foot = place(random, RADIUS * 0.93);
        let lean = DVec3::new(random.range(-0.25, 0.25), 1.0, random.range(-0.25, 0.25));
        let head = foot + lean.normalize() * random.range(0.11, 0.22);
        painter.needle(foot, head, 0.006, DVec3::new(0.30, 0.48, 0.16), DVec3::Y);
        let albedo = random.pick(&kinds) * random.range(0.9, 1.05);
        // Heads turn to the sun.
        let turn = random.range(0.0, TAU);
        let face = facing(
            DVec3::Y + 0.5 * painter.light.sun + 0.35 * random.direction(),
            turn,
        );
        let size = random.range(0.020, 0.029);
        let petals = 5 + (random.unit() * 2.0) as u32;
        for petal in 0..petals {
            let (s, c) = (TAU * f64::from(petal) / f64::from(petals)).sin_cos();
            let out = face.x_axis * c + face.y_axis * s;
            let normal = (face.z_axis - 0.35 * out).normalize();
            let side = normal.cross(out).normalize();
            painter.patch(
                head + out * (1.25 * size),
                DMat3::from_cols(side.cross(normal), side, normal),
                DVec3::new(size * 0.8, size * 0.5, 0.004),
                albedo,
                0.14,
            );
        }
        painter.patch(
            head + face.z_axis * 0.008,
            face,
            DVec3::new(size * 0.45, size * 0.45, 0.008),
            DVec3::new(0.95, 0.74, 0.18),
            0.0,
        );
    }
}

/// Fallen petals under the tree.
pub(super) fn fallen_petals(painter: &mut Painter, random: &mut Random) {
    for _ in 0..130 {
        let at = place(random, RADIUS * 0.75) + DVec3::Y * 0.016;
        painter.patch(
            at,
            facing(DVec3::Y + 0.4 * random.direction(), random.range(0.0, TAU)),
            DVec3::new(0.016, 0.011, 0.004),
            DVec3::new(1.0, 0.76, 0.83),
            0.0,
        );
    }
}

/// Three butterflies, four wings each.
pub(super) fn butterflies(painter: &mut Painter) {
    let places = [
        (
            DVec3::new(0.95, 0.62, 0.75),
            0.4,
            DVec3::new(0.98, 0.62, 0.14),
        ),
        (
            DVec3::new(0.35, 0.50, 1.45),
            2.1,
            DVec3::new(0.40, 0.56, 0.98),
        ),
        (
            DVec3::new(-1.15, 0.72, 0.70),
            -0.7,
            DVec3::new(0.98, 0.86, 0.30),
        ),
    ];
    for (at, heading, wing) in places {
        let (s, c) = f64::sin_cos(heading);
        let ahead = DVec3::new(c, 0.25, s).normalize();
        let right = ahead.cross(DVec3::Y).normalize();
        let up = right.cross(ahead);
        for side in [-1.0, 1.0] {
            let out = (right * side + up * 0.7).normalize();
            let normal = out.cross(ahead).normalize() * side;
            for (front, size) in [(0.5, 0.036), (-0.55, 0.027)] {
                let along = (out + ahead * front).normalize();
                painter.patch(
                    at + along * (1.3 * size),
                    DMat3::from_cols(along, normal.cross(along), normal),
                    DVec3::new(size, size * 0.62, 0.004),
                    wing,
                    0.2,
                );
            }
        }
        painter.add(Stroke {
            at,
            axes: facing(ahead, 0.0),
            sigma: DVec3::new(0.006, 0.006, 0.024),
            opacity: 0.95,
            colour: DVec3::splat(0.12),
            glow: DVec3::ZERO,
        });
    }
}
