//! Splats of an analytic scene, placed without training: flat discs on the surfaces whose front is
//! visible from the scene's path, round blobs in fog.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec3, dvec3};
use rayon::prelude::*;

use potamoi_analytic::Analytic;
use potamoi_base::sh;
use potamoi_gaussians::{Cloud, CloudError};

/// Optical depth a voxel edge on which discs lie.
const LEVEL: f64 = 1.62;
/// Opacity of discs.
const OPACITY: f64 = 0.97;
/// Standard deviation of a disc, relative to the distance of its neighbours.
const WIDTH: f64 = 0.52;
/// Minimum fraction of that, where a surface bends away.
const NARROW: f64 = 0.5;
/// Thickness of a disc in voxel edges.
const THICKNESS: f64 = 0.05;
/// Maximum drop of the optical depth a voxel edge below that of the surface, under a disc at two
/// standard deviations.
const FALL: f64 = 0.2;
/// Approximate maximum number of fog blobs.
const BLOBS: f64 = 12_000.0;
/// Nearest and farthest distance of blobs, in voxel edges.
const FOG: [f64; 2] = [1.5, 4.0];
/// Standard deviation of a blob, relative to the distance of its neighbours.
const BLOB: f64 = 0.6;
/// Optical depth a voxel edge above which a position is not fog, and its maximum change within one
/// edge.
const THICK: f64 = 1.0;
const STEEP: f64 = 0.5;
/// Optical depth a voxel edge that solids reach within one voxel edge; other objects are thin.
const THIN: f64 = 2.2;
/// Distance of blobs in thin objects, in voxel edges.
const FINE: f64 = 0.5;
/// Opacity below which blobs are left out: no pixel would draw them.
const FAINT: f64 = 1.0 / 255.0;
/// Number of points of the path from which surfaces must be visible.
const EYES: u32 = 24;
/// Duration of the path in seconds: one turn.
const PATH: f64 = 10.0;

/// A Gaussian.
struct Splat {
    at: DVec3,
    /// The axes, as columns.
    axes: DMat3,
    sigma: DVec3,
    opacity: f64,
}

/// The splats of an analytic scene; with 90,000 discs those of `SCENE:splats`. There are at most
/// about `discs` discs on surfaces, farther apart and wider if they are fewer, at most about
/// 12,000 blobs in fog, and blobs in objects too thin for discs. Degree 1.
///
/// # Errors
/// No part of the scene is visible, for example without discs and fog.
pub fn cloud(scene: Analytic, discs: u32) -> Result<Cloud, CloudError> {
    let eyes: Vec<DVec3> = (0..EYES)
        .map(|k| PATH * f64::from(k) / f64::from(EYES))
        .map(|seconds| scene.camera(seconds, 8, 8).position())
        .collect();
    let coarse = 1.5 * scene.voxel();
    let count = surface(scene, &eyes, coarse).len() as f64;
    let spacing = (coarse * (count / f64::from(discs.max(1))).sqrt())
        .clamp(0.6 * scene.voxel(), coarse * 2.0);
    let places = surface(scene, &eyes, spacing);
    let discs = places.into_par_iter();
    let mut splats: Vec<Splat> = discs
        .map(|(at, normal)| disc(scene, at, normal, spacing))
        .collect();
    let coarse = FOG[1] * scene.voxel();
    let share = (fog(scene, coarse).len() as f64 / BLOBS).cbrt();
    let spacing = (coarse * share).clamp(FOG[0] * scene.voxel(), coarse);
    splats.extend(fog(scene, spacing));
    splats.extend(thin(scene));
    let colours: Vec<[[f32; 3]; 4]> = splats
        .par_iter()
        .map(|splat| harmonics(scene.linear_colour(splat.at)))
        .collect();
    let three = |v: DVec3| v.as_vec3().to_array();
    Cloud::new(
        1,
        splats.iter().map(|s| three(s.at)).collect(),
        splats.iter().map(|s| three(s.sigma.map(f64::ln))).collect(),
        splats
            .iter()
            .map(|s| {
                let q = DQuat::from_mat3(&s.axes).as_quat();
                [q.w, q.x, q.y, q.z]
            })
            .collect(),
        splats
            .iter()
            .map(|s| (s.opacity / (1.0 - s.opacity)).ln() as f32)
            .collect(),
        colours.into_iter().flatten().collect(),
    )
}

/// Depth below the surface of the discs, at most 0 outside.
fn inside(scene: Analytic, at: DVec3) -> f64 {
    scene.density(at) * scene.voxel() - LEVEL
}

/// Gradient of that depth, per voxel edge.
fn slope(scene: Analytic, at: DVec3) -> DVec3 {
    let e = 0.25 * scene.voxel();
    let along = |axis: DVec3| inside(scene, at + axis * e) - inside(scene, at - axis * e);
    2.0 * dvec3(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
}

/// A lattice over the scene: its first corner, and the number of corners along x, y and z. It is
/// oblique to the scene's own grid.
fn lattice(scene: Analytic, spacing: f64) -> (DVec3, [usize; 3]) {
    let [low, high] = scene.bounds();
    let corner = low - spacing * dvec3(0.37, 0.61, 0.83);
    let counts = ((high - corner) / spacing).ceil().to_array();
    (corner, counts.map(|c| c as usize + 1))
}

/// Lattice corners along a block's side.
const BLOCK: usize = 4;

/// Whether the scene may be non-empty in the lattice block of a corner, or in the cells of which
/// it is the first corner.
fn near(scene: Analytic, spacing: f64) -> impl Fn(usize) -> bool + Sync {
    let (corner, counts) = lattice(scene, spacing);
    let [nx, ny, _] = counts;
    let [bx, by, bz] = counts.map(|count| count.div_ceil(BLOCK));
    let side = BLOCK as f64 * spacing;
    let something: Vec<bool> = (0..bx * by * bz)
        .into_par_iter()
        .map(|i| {
            let v = [i % bx, i / bx % by, i / (bx * by)];
            let middle = corner + side * DVec3::from(v.map(|v| v as f64 + 0.5));
            scene.clearance(middle) < 0.5 * 3f64.sqrt() * side
        })
        .collect();
    move |i| {
        let [x, y, z] = [i % nx, i / nx % ny, i / (nx * ny)].map(|v| v / BLOCK);
        something[x + bx * (y + by * z)]
    }
}

/// Points of the surface, one a lattice cell that it crosses, with their normals; only those whose
/// front is visible.
fn surface(scene: Analytic, eyes: &[DVec3], spacing: f64) -> Vec<(DVec3, DVec3)> {
    let (corner, [nx, ny, nz]) = lattice(scene, spacing);
    let place = |i: usize| {
        let v = [i % nx, i / nx % ny, i / (nx * ny)];
        corner + spacing * DVec3::from(v.map(|v| v as f64))
    };
    let near = near(scene, spacing);
    let depths: Vec<f64> = (0..nx * ny * nz)
        .into_par_iter()
        .map(|i| match near(i) {
            true => inside(scene, place(i)),
            false => -LEVEL,
        })
        .collect();
    let cells = (0..nx * ny * nz).into_par_iter().filter(|i| {
        let v = [i % nx + 1, i / nx % ny + 1, i / (nx * ny) + 1];
        near(*i) && v[0] < nx && v[1] < ny && v[2] < nz
    });
    let found = cells.filter_map(|i| {
        let corners = |k: usize| i + (k & 1) + nx * ((k >> 1 & 1) + ny * (k >> 2));
        let depth: [f64; 8] = std::array::from_fn(|k| depths[corners(k)]);
        if depth.iter().all(|d| *d > 0.0) || depth.iter().all(|d| *d <= 0.0) {
            return None;
        }
        // The middle of where the surface crosses edges.
        let mut sum = DVec3::ZERO;
        let mut crossed = 0.0;
        for k in 0..8 {
            for axis in [1, 2, 4] {
                let (a, b) = (depth[k], depth[k | axis]);
                if k & axis == 0 && (a > 0.0) != (b > 0.0) {
                    let share = a / (a - b);
                    sum += place(corners(k)).lerp(place(corners(k | axis)), share);
                    crossed += 1.0;
                }
            }
        }
        let mut at = sum / crossed;
        for _ in 0..4 {
            let (depth, slope) = (inside(scene, at), slope(scene, at));
            let length = slope.length_squared().max(0.25);
            let step = slope * (-depth / length * scene.voxel());
            at += step.clamp_length_max(0.5 * scene.voxel());
        }
        let normal = -slope(scene, at).normalize_or_zero();
        let lies = inside(scene, at).abs() < 0.5 && normal != DVec3::ZERO;
        let seen = eyes.iter().any(|eye| normal.dot(*eye - at) > 0.0);
        (lies && seen && !is_thin(scene, at)).then_some((at, normal))
    });
    found.collect()
}

/// A disc along the directions of largest and smallest curvature, narrow where the curvature is
/// large.
fn disc(scene: Analytic, at: DVec3, normal: DVec3, spacing: f64) -> Splat {
    let voxel = scene.voxel();
    let [a, b] = <[DVec3; 2]>::from(normal.any_orthonormal_pair());
    let reach = 0.7 * voxel;
    let bend = |along: DVec3| {
        let [ahead, behind] = [1.0, -1.0].map(|sign| {
            let near = at + along * (sign * reach);
            -slope(scene, near).normalize_or(-normal)
        });
        (ahead - behind) / (2.0 * reach)
    };
    let (da, db) = (bend(a), bend(b));
    // The symmetric part of how the normal turns along both tangents.
    let (aa, bb, ab) = (da.dot(a), db.dot(b), 0.5 * (da.dot(b) + db.dot(a)));
    let turn = 0.5 * (2.0 * ab).atan2(aa - bb);
    let (sin, cos) = turn.sin_cos();
    let (first, second) = (a * cos + b * sin, b * cos - a * sin);
    // How far a disc may reach before the surface has fallen away below it.
    // Where it rises instead, what reaches into it is not seen.
    let most = 2.0 * WIDTH * spacing;
    let room = |along: DVec3| {
        let mut before = (0.0, 0.0f64);
        for k in 1..=4 {
            let t = most * f64::from(k) / 4.0;
            let fallen = -inside(scene, at + along * t);
            if fallen > FALL {
                let share = (FALL - before.1) / (fallen - before.1);
                return before.0 + share.clamp(0.0, 1.0) * (t - before.0);
            }
            before = (t, fallen);
        }
        most
    };
    let wide = |along: DVec3| {
        let most = 0.5 * room(along).min(room(-along));
        most.max(NARROW * WIDTH * spacing)
    };
    let sigma = dvec3(wide(first), wide(second), THICKNESS * voxel);
    Splat {
        at,
        axes: DMat3::from_cols(first, second, first.cross(second)),
        sigma,
        opacity: OPACITY,
    }
}

/// Blobs in objects too thin for a surface, whose density stays below that of the surface.
fn thin(scene: Analytic) -> Vec<Splat> {
    let voxel = scene.voxel();
    let spacing = FINE * voxel;
    let (corner, [nx, ny, nz]) = lattice(scene, spacing);
    let near = near(scene, spacing);
    let blobs = (0..nx * ny * nz).into_par_iter().filter(|i| near(*i));
    let blobs = blobs.filter_map(|i| {
        let v = [i % nx, i / nx % ny, i / (nx * ny)];
        let at = corner + spacing * DVec3::from(v.map(|v| v as f64 + 0.5));
        let density = scene.density(at);
        let is_part = density > 0.0
            && density * voxel < THIN
            // Before the other, which looks at six times as many places.
            && is_steep(scene, at, density)
            && is_thin(scene, at);
        if !is_part {
            return None;
        }
        blob(at, density, spacing)
    });
    blobs.collect()
}

/// Whether a position is in an object whose density nearby stays below that of solids.
fn is_thin(scene: Analytic, at: DVec3) -> bool {
    let voxel = scene.voxel();
    let up = |from: DVec3, far: f64| from + slope(scene, from).normalize_or_zero() * (far * voxel);
    let is_dense = |at: DVec3| scene.density(at) * voxel >= THIN;
    // Most are at a plain surface, where it rises as fast as it may.
    if is_dense(up(at, 0.75)) {
        return false;
    }
    let mut near = at;
    (0..5).all(|_| {
        near = up(near, 0.2);
        !is_dense(near)
    })
}

/// A blob whose central optical depth is that of its cell.
fn blob(at: DVec3, density: f64, spacing: f64) -> Option<Splat> {
    let depth = density * spacing / (TAU * BLOB * BLOB);
    let opacity = -(-depth).exp_m1();
    (opacity > FAINT).then(|| Splat {
        at,
        axes: DMat3::IDENTITY,
        sigma: DVec3::splat(BLOB * spacing),
        opacity,
    })
}

/// Whether a position is not fog.
fn is_steep(scene: Analytic, at: DVec3, density: f64) -> bool {
    let voxel = scene.voxel();
    // To both sides: outside, nothing is steep.
    let e = 0.5 * voxel;
    let next = |to: DVec3| (scene.density(at + to * e) - density).abs();
    let most = |axis: DVec3| next(axis).max(next(-axis));
    let steep = || dvec3(most(DVec3::X), most(DVec3::Y), most(DVec3::Z)).length() * 2.0 * voxel;
    density * voxel >= THICK || steep() >= STEEP
}

/// Blobs with the optical depth of the surrounding fog.
fn fog(scene: Analytic, spacing: f64) -> Vec<Splat> {
    let (corner, [nx, ny, nz]) = lattice(scene, spacing);
    let near = near(scene, spacing);
    let blobs = (0..nx * ny * nz).into_par_iter().filter(|i| near(*i));
    let blobs = blobs.filter_map(|i| {
        let v = [i % nx, i / nx % ny, i / (nx * ny)];
        let low = corner + spacing * DVec3::from(v.map(|v| v as f64));
        let mut sum = 0.0;
        let mut middle = DVec3::ZERO;
        for k in 0..27usize {
            let part = [k % 3, k / 3 % 3, k / 9].map(|v| (v as f64 + 0.5) / 3.0);
            let at = low + spacing * DVec3::from(part);
            let density = scene.density(at);
            if density > 0.0 && !is_steep(scene, at, density) {
                sum += density;
                middle += density * at;
            }
        }
        if sum <= 0.0 {
            return None;
        }
        blob(middle / sum, sum / 27.0, spacing)
    });
    blobs.collect()
}

/// Spherical harmonics of degree 1 for a colour that is linear in the direction.
fn harmonics(linear: [[f32; 4]; 3]) -> [[f32; 3]; 4] {
    let basis = sh::basis(DVec3::ONE);
    let term = |k: usize, axis: usize, offset: f32| {
        linear.map(|own| (own[axis] - offset) / basis[k] as f32)
    };
    [
        term(0, 0, 0.5),
        term(1, 2, 0.0),
        term(2, 3, 0.0),
        term(3, 1, 0.0),
    ]
}
