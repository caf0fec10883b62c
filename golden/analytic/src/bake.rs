//! Sampling of analytic fields to grids.

use std::sync::LazyLock;

use glam::{DMat4, DVec3, DVec4, Vec3Swizzles, Vec4Swizzles};
use rayon::prelude::*;

use super::appearance::Appearance;
use super::field::{Field, INSIDE, OUTSIDE};
use potamoi_fields::voxels::{Grid, Layout};
use potamoi_march::MarchError;

/// Number of directions over which colours are fitted.
const COUNT: usize = 200;
static DIRECTIONS: LazyLock<[DVec3; COUNT]> = LazyLock::new(directions);

/// Diagonal of a cell in voxel edges, rounded up.
const DIAGONAL: f64 = 1.733;

/// Samples a field at the vertices of its grid: densities directly, colours as the nearest linear
/// functions of the direction.
pub(super) fn bake(field: &dyn Field) -> Result<Grid, MarchError> {
    let frame = field.frame();
    sample(field, frame.points, frame.voxel)
}

/// The same at about `count` vertices in the box of its grid.
pub(super) fn bake_of(field: &dyn Field, count: usize) -> Result<Grid, MarchError> {
    let frame = field.frame();
    let own = frame.points.map(|p| (p - 1) as f64);
    let finer = (count as f64 / own.iter().product::<f64>()).cbrt();
    let points = own.map(|edges| (edges * finer).round() as usize);
    sample(field, points, frame.voxel / finer)
}

fn sample(field: &dyn Field, points: [usize; 3], voxel: f64) -> Result<Grid, MarchError> {
    let frame = field.frame();
    let [nx, ny, _] = points;
    let channels = frame.layout.channels();
    let mut features = vec![0f32; points.iter().product::<usize>() * channels];
    let rows = features.par_chunks_exact_mut(nx * channels);
    rows.enumerate().for_each(|(row, values)| {
        let (y, z) = (row % ny, row / ny);
        for (x, vertex) in values.chunks_exact_mut(channels).enumerate() {
            let at = frame.corner + voxel * DVec3::new(x as f64, y as f64, z as f64);
            let probe = field.probe(at);
            vertex[0] = (probe.density * voxel).max(OUTSIDE) as f32;
            // No light gets to colours deep inside, and none from cells with no
            // corner inside.
            let deep = probe.density * frame.voxel >= INSIDE;
            if probe.clearance <= DIAGONAL * voxel && !deep {
                colours(
                    &field.look(at),
                    frame.layout,
                    &*DIRECTIONS,
                    &mut vertex[1..],
                );
            }
        }
    });
    Grid::new(points, frame.corner, voxel, frame.layout, features)
}

/// The linear colour of one point, independent of a layout.
pub(super) fn linear(look: &Appearance) -> [[f32; 4]; 3] {
    let mut out = [[0.0; 4]; 3];
    colours(look, Layout::Linear, &*DIRECTIONS, out.as_flattened_mut());
    out
}

/// Directions spread evenly over the sphere, on a golden-angle spiral.
pub(super) fn directions() -> [DVec3; COUNT] {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    std::array::from_fn(|i| {
        let z = 1.0 - (2 * i + 1) as f64 / COUNT as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * cos, across * sin, z)
    })
}

/// Sums over weighted directions (x, y, z): the 4 x 4 matrix of products of 1, x, y and z.
#[derive(Default)]
struct Moments {
    /// Sums of 1, x, y, z.
    first: DVec4,
    /// Sums of xx, yy, zz.
    squares: DVec3,
    /// Sums of xy, yz, zx.
    mixed: DVec3,
}

impl Moments {
    fn matrix(&self) -> DMat4 {
        let (f, s, m) = (self.first, self.squares, self.mixed);
        DMat4::from_cols(
            f,
            DVec4::new(f.y, s.x, m.x, m.z),
            DVec4::new(f.z, m.x, s.y, m.y),
            DVec4::new(f.w, m.z, m.y, s.z),
        )
    }
}

/// Least squares over the directions that see the front, weighted by the projected area.
fn colours(look: &Appearance, layout: Layout, directions: &[DVec3], out: &mut [f32]) {
    let terms = layout.coefficients();
    if layout == Layout::Constant || look.is_matte() || look.normal() == DVec3::ZERO {
        let colour = look.along(-look.normal());
        for (to, v) in out.chunks_exact_mut(terms).zip(colour.to_array()) {
            to[0] = v as f32;
        }
        return;
    }
    let mut normal = Moments::default();
    let mut right = [DVec4::ZERO; 3];
    for d in directions {
        let weight = -d.dot(look.normal());
        if weight <= 0.0 {
            continue;
        }
        let heavy = DVec4::new(1.0, d.x, d.y, d.z) * weight;
        normal.first += heavy;
        normal.squares += *d * heavy.yzw();
        normal.mixed += d.yzx() * heavy.yzw();
        let seen = look.along(*d);
        for (sum, v) in right.iter_mut().zip(seen.to_array()) {
            *sum += heavy * v;
        }
    }
    // Positive definite: a normal has a hemisphere of directions that face it.
    let inverse = normal.matrix().inverse();
    for (to, sum) in out.chunks_exact_mut(terms).zip(right) {
        for (to, v) in to.iter_mut().zip((inverse * sum).to_array()) {
            *to = v as f32;
        }
    }
}
