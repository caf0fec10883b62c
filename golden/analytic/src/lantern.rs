//! The built-in voxel scene: a paper lantern that glows on a round stone.
//!
//! An analytic field of signed distances, sampled in a vertex grid. Densities rise linearly
//! through each surface and are clamped to -4 outside, so that their interpolation is sharp while
//! far cells are empty. Colours are linear in the viewing direction: paper is brighter seen
//! head-on, stone has a broad sheen.

use glam::DVec3;

use potamoi_base::camera::Camera;
use potamoi_fields::voxels::{Grid, Layout};
use potamoi_march::MarchError;

/// Vertices along x, y, z; z points up.
pub const POINTS: [usize; 3] = [64, 64, 92];
/// Background, linear RGB; 12 fraction bits represent it exactly.
pub const BACKGROUND: [f32; 3] = [287.0 / 4096.0, 328.0 / 4096.0, 492.0 / 4096.0];

/// Edge of a voxel: the stone spans the 63 voxels across.
const VOXEL: f64 = 2.0 / 63.0;
/// Optical depth a voxel edge far outside a surface, before the ReLU.
const OUTSIDE: f64 = -4.0;
/// Position of the light inside.
const LAMP: DVec3 = DVec3::new(0.0, 0.0, 1.42);

/// Half the height of the paper, and its largest radius.
const HALF_HEIGHT: f64 = 0.86;
const RADIUS: f64 = 0.68;
/// Hoops under the paper.
const HOOPS: f64 = 11.0;

/// The material of a point.
#[derive(Clone, Copy, PartialEq)]
enum Material {
    Paper,
    Wood,
    Stone,
    Pebble(usize),
}

/// Position, radius and colour of the pebbles.
const PEBBLES: [(DVec3, f64, [f64; 3]); 4] = [
    (DVec3::new(0.60, -0.42, 0.40), 0.13, [0.55, 0.53, 0.50]),
    (DVec3::new(0.36, -0.68, 0.36), 0.09, [0.62, 0.50, 0.42]),
    (DVec3::new(-0.62, -0.44, 0.37), 0.10, [0.42, 0.47, 0.50]),
    (DVec3::new(-0.30, 0.72, 0.38), 0.11, [0.50, 0.52, 0.47]),
];

/// Samples the lantern.
///
/// # Errors
/// None in practice: size and values are valid by construction.
pub fn lantern() -> Result<Grid, MarchError> {
    let corner = DVec3::new(-1.0, -1.0, 0.0);
    Grid::bake(POINTS, corner, VOXEL, Layout::Linear, vertex)
}

/// The default camera for any picture size.
#[must_use]
pub fn camera(width: u32, height: u32) -> Camera {
    let eye = DVec3::new(1.9, -4.4, 2.75);
    let target = DVec3::new(0.0, 0.0, 1.27);
    // The smaller side sees the whole of it.
    let tall = f64::from(height) / f64::from(width.max(1));
    let fov = 2.0 * (0.31 * tall.max(1.0)).atan();
    Camera::look_at(eye, target, DVec3::Z, fov, width, height)
}

/// The channels of a vertex.
fn vertex(at: DVec3, out: &mut [f32]) {
    let (distance, material) = nearest(at);
    let depth = distance / VOXEL;
    let density = match material {
        // Thin, and translucent: a third of the light comes through.
        Material::Paper => (-1.1 * depth).clamp(OUTSIDE, 0.9),
        _ => (-3.0 * depth).clamp(OUTSIDE, 6.0),
    };
    out[0] = density as f32;
    if density > OUTSIDE {
        let normal = gradient(at, |p| nearest(p).0);
        let colours = shade(at, normal, material);
        for (terms, colour) in out[1..].chunks_exact_mut(4).zip(colours) {
            for (to, term) in terms.iter_mut().zip(colour) {
                *to = term as f32;
            }
        }
    }
}

/// Signed distance to the nearest surface, and its material.
fn nearest(p: DVec3) -> (f64, Material) {
    let mut best = (paper(p).abs() - 1.2 * VOXEL, Material::Paper);
    let mut offer = |distance: f64, material| {
        if distance < best.0 {
            best = (distance, material);
        }
    };
    offer(wood(p), Material::Wood);
    offer(
        disc(p - DVec3::new(0.0, 0.0, 0.17), 0.92, 0.13, 0.05),
        Material::Stone,
    );
    for (i, (centre, radius, _)) in PEBBLES.into_iter().enumerate() {
        // A little flattened.
        let d = (p - centre) * DVec3::new(1.0, 1.0, 1.35);
        offer(d.length() - radius, Material::Pebble(i));
    }
    best
}

/// Signed distance, to first order, to the paper's surface.
fn paper(p: DVec3) -> f64 {
    // The radius at a height, and what the height adds.
    let level = |z: f64| {
        let up = (z - LAMP.z) / HALF_HEIGHT;
        let hoop = (up * HOOPS * std::f64::consts::FRAC_PI_2).sin().abs();
        let radius = RADIUS * (0.965 + 0.045 * hoop.sqrt());
        (radius, up.abs().powf(2.6))
    };
    let implicit = |p: DVec3, (radius, added): (f64, f64)| {
        let across = p.truncate().length() / radius;
        across.powf(2.2) + added - 1.0
    };
    let e = 0.25 * VOXEL;
    let own = level(p.z);
    let [above, below] = [p + DVec3::Z * e, p - DVec3::Z * e];
    let slope = DVec3::new(
        implicit(p + DVec3::X * e, own) - implicit(p - DVec3::X * e, own),
        implicit(p + DVec3::Y * e, own) - implicit(p - DVec3::Y * e, own),
        implicit(above, level(above.z)) - implicit(below, level(below.z)),
    ) / (2.0 * e);
    implicit(p, own) / slope.length().max(1.0)
}

/// Rings at both ends of the paper, four feet and the handle.
fn wood(p: DVec3) -> f64 {
    let ring = |z: f64| disc(p - DVec3::new(0.0, 0.0, z), 0.33, 0.055, 0.025);
    let ends = ring(LAMP.z - 0.82).min(ring(LAMP.z + 0.82));
    let q = DVec3::new(p.x.abs() - 0.2, p.y.abs() - 0.2, p.z - 0.42);
    let foot = (q.truncate().length() - 0.055).max(q.z.abs() - 0.17);
    // A hoop that stands in the plane x-z.
    let h = p - DVec3::new(0.0, 0.0, LAMP.z + 0.95);
    let around = h.x.hypot(h.z * 0.85) - 0.27;
    let handle = (around.hypot(h.y) - 0.045).max(-h.z);
    ends.min(foot).min(handle)
}

/// A disc with a rounded rim around the z axis.
fn disc(p: DVec3, radius: f64, half: f64, round: f64) -> f64 {
    let across = p.truncate().length() - radius + round;
    let up = p.z.abs() - half + round;
    across.max(0.0).hypot(up.max(0.0)) + across.max(up).min(0.0) - round
}

fn gradient(p: DVec3, field: impl Fn(DVec3) -> f64) -> DVec3 {
    let e = 0.5 * VOXEL;
    let along = |axis: DVec3| field(p + axis * e) - field(p - axis * e);
    DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z)).normalize_or_zero()
}

/// Red, green, blue: a constant and the slopes along x, y, z of the viewing direction.
fn shade(p: DVec3, normal: DVec3, material: Material) -> [[f64; 4]; 3] {
    match material {
        Material::Paper => {
            // From its outside whichever side the vertex is on.
            let outward = gradient(p, paper);
            let up = (p.z - LAMP.z) / HALF_HEIGHT;
            let glow = (-1.7 * up * up).exp();
            let hoop = (up * HOOPS * std::f64::consts::FRAC_PI_2).sin().abs();
            let lit = 0.55 + 0.45 * hoop.sqrt();
            let hot = DVec3::new(1.02, 0.80, 0.44);
            let cool = DVec3::new(0.66, 0.19, 0.07);
            let colour = (cool + (hot - cool) * glow) * lit;
            linear(colour * 0.62, colour * 0.44, -outward)
        }
        Material::Wood => lit(p, normal, DVec3::new(0.16, 0.085, 0.055), 0.05),
        Material::Stone => {
            // Broad rings, as if turned.
            let ring = (p.truncate().length() * 26.0).sin();
            lit(
                p,
                normal,
                DVec3::new(0.40, 0.42, 0.46) * (1.0 + 0.07 * ring),
                0.16,
            )
        }
        Material::Pebble(i) => lit(p, normal, DVec3::from(PEBBLES[i].2), 0.08),
    }
}

/// A surface in the lantern's light and a little of the sky's, with a sheen.
fn lit(p: DVec3, normal: DVec3, albedo: DVec3, sheen: f64) -> [[f64; 4]; 3] {
    let warm = DVec3::new(1.0, 0.66, 0.34);
    let sky = DVec3::new(0.30, 0.36, 0.50);
    let to_lamp = LAMP - p;
    let light = to_lamp.normalize_or_zero();
    // Wrapped around: the lamp is as large as the paper.
    let facing = ((normal.dot(light) + 0.35) / 1.35).max(0.0);
    let near = 1.9 / (0.4 + to_lamp.length_squared());
    // Under the lantern the feet and the ring take the light.
    let shade = 1.0 - 0.45 * (-p.truncate().length_squared() / 0.12).exp();
    let diffuse = albedo * (warm * (facing * near * shade) + sky * (0.55 + 0.45 * normal.z));
    let mirror = light - 2.0 * light.dot(normal) * normal;
    linear(diffuse, warm * (sheen * facing), mirror)
}

/// `constant + slope (axis . d)` for each colour.
fn linear(constant: DVec3, slope: DVec3, axis: DVec3) -> [[f64; 4]; 3] {
    [0, 1, 2].map(|c| {
        let along = slope[c] * axis;
        [constant[c], along.x, along.y, along.z]
    })
}
