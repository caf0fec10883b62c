//! Marching cubes: the surface at which a density crosses a level.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec3, dvec3};
use rayon::prelude::*;

use super::cases::{CASES, ends};
use super::{Mesh, MeshError};

/// Maximum number of cells along an axis.
pub const MAX_CELLS: u32 = 1024;
/// Maximum number of triangles in a surface: 600 MB with their vertices.
pub const MAX_TRIANGLES: usize = 1 << 25;

/// Layers of cells that are marched together. Densities between two groups are sampled twice.
const LAYERS: usize = 16;
/// Accuracy of a vertex on an edge, relative to a cell's edge, if [`Density::at`] is available.
const NEAR: f64 = 1.0 / 512.0;
/// Maximum number of density samples for a vertex.
const TRIES: usize = 8;

/// A density at every point of a box.
pub trait Density: Sync {
    /// Samples a plane of points, x fastest, then y. A density is an optical depth per unit of
    /// length, and may be negative in empty space.
    fn plane(&self, lattice: &Lattice, z: usize, out: &mut [f32]);

    /// The density at a point of the box, if that is cheap. Vertices are then placed where the
    /// level is crossed; otherwise the density is assumed to be linear between points.
    fn at(&self, p: DVec3) -> Option<f64>;
}

/// A density that is sampled point by point.
pub(super) struct Points<F>(pub(super) F);

impl<F: Fn(DVec3) -> f64 + Sync> Density for Points<F> {
    fn plane(&self, lattice: &Lattice, z: usize, out: &mut [f32]) {
        let [width, ..] = lattice.points();
        for (i, value) in out.iter_mut().enumerate() {
            *value = (self.0)(lattice.point([i % width, i / width, z])) as f32;
        }
    }

    fn at(&self, p: DVec3) -> Option<f64> {
        Some((self.0)(p))
    }
}

/// A lattice of points in a box, at the corners of cubic cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lattice {
    bounds: [DVec3; 2],
    cell: f64,
    points: [usize; 3],
}

impl Lattice {
    /// The lattice of the box between two corners, with `cells` cells along its longest side.
    /// Along the other sides, the last cell may extend beyond the box.
    ///
    /// # Errors
    /// `cells` is 0 or above [`MAX_CELLS`], or the box has no volume.
    pub fn new(bounds: [DVec3; 2], cells: u32) -> Result<Self, MeshError> {
        let refuse = |field: &str, value: String, expected: String| {
            Err(MeshError::Value {
                field: field.to_owned(),
                value,
                expected,
            })
        };
        if !(1..=MAX_CELLS).contains(&cells) {
            let expected = format!("1 to {MAX_CELLS} along the longest side");
            return refuse("cells", cells.to_string(), expected);
        }
        let [low, high] = bounds;
        let size = high - low;
        let cell = size.max_element() / f64::from(cells);
        // Not a number is not above another.
        let is_box = size.min_element() > 0.0 && size.is_finite() && low.is_finite();
        // Points differ from their neighbours in 32 bits.
        let reach = low.abs().max(high.abs()).max_element();
        if !(is_box && cell > reach * f64::from(f32::EPSILON)) {
            let expected = "corners of a box, the first below the second, not too far from 0";
            return refuse("bounds", format!("{low} to {high}"), expected.to_owned());
        }
        // Rounding takes no point from the far side.
        let points = (size / cell + 1e-6).to_array().map(|n| n as usize + 1);
        Ok(Self {
            bounds,
            cell,
            points,
        })
    }

    /// Corners of the box.
    #[must_use]
    pub const fn bounds(&self) -> [DVec3; 2] {
        self.bounds
    }

    /// Edge length of a cell.
    #[must_use]
    pub const fn cell(&self) -> f64 {
        self.cell
    }

    /// Number of points along x, y, z.
    #[must_use]
    pub const fn points(&self) -> [usize; 3] {
        self.points
    }

    /// Position of a point.
    #[must_use]
    pub fn point(&self, [x, y, z]: [usize; 3]) -> DVec3 {
        let at = self.bounds[0] + self.cell * dvec3(x as f64, y as f64, z as f64);
        at.min(self.bounds[1])
    }

    /// Position of a point, counted from one point beyond the box.
    fn wide_point(&self, at: [usize; 3]) -> DVec3 {
        self.bounds[0] + self.cell * (DVec3::from(at.map(|i| i as f64)) - 1.0)
    }
}

impl Mesh {
    /// The surface at which a density, an optical depth per unit of length, crosses a level, in
    /// the box between two corners, with `cells` cells along its longest side. The space outside
    /// the box is empty, so the surface is closed: every edge has two triangles. The result does
    /// not depend on the number of threads.
    ///
    /// # Errors
    /// Those of [`Lattice::new`] and [`Mesh::of_surface`].
    pub fn of_density(
        bounds: [DVec3; 2],
        cells: u32,
        level: f64,
        density: impl Fn(DVec3) -> f64 + Sync,
    ) -> Result<Self, MeshError> {
        Self::of_surface(&Points(density), &Lattice::new(bounds, cells)?, level)
    }

    /// As [`Mesh::of_density`], for densities that are sampled plane by plane.
    ///
    /// # Errors
    /// The level is not finite, or the surface has more than [`MAX_TRIANGLES`] triangles.
    pub fn of_surface(
        density: &dyn Density,
        lattice: &Lattice,
        level: f64,
    ) -> Result<Self, MeshError> {
        let refuse = |field: &str, value: String, expected: String| {
            Err(MeshError::Value {
                field: field.to_owned(),
                value,
                expected,
            })
        };
        if !(level as f32).is_finite() {
            let expected = "an optical depth a unit of length".to_owned();
            return refuse("level", level.to_string(), expected);
        }
        let layers = lattice.points[2] + 1;
        let count = AtomicUsize::new(0);
        let slabs: Vec<Slab> = (0..layers.div_ceil(LAYERS))
            .into_par_iter()
            .map(|i| {
                let mut slab = Marcher::new(density, lattice, level as f32);
                slab.march(i * LAYERS, ((i + 1) * LAYERS).min(layers), layers, &count);
                slab.made
            })
            .collect();
        let count = count.into_inner();
        if count > MAX_TRIANGLES {
            let [x, y, z] = lattice.points;
            let value = format!("more than {MAX_TRIANGLES} at {x} x {y} x {z} points");
            let expected = format!("at most {MAX_TRIANGLES}: choose fewer cells");
            return refuse("number of triangles", value, expected);
        }
        let mut vertices = Vec::with_capacity(slabs.iter().map(|s| s.vertices.len()).sum());
        let mut triangles = Vec::with_capacity(count);
        for slab in slabs {
            // Vertices of a slab's last plane are the first of the next slab.
            let base = vertices.len() as u32;
            triangles.extend(slab.triangles.iter().map(|t| t.map(|v| v + base)));
            vertices.extend(slab.vertices);
        }
        Self::new(vertices, triangles)
    }
}

/// The vertices of some layers and of the planes below them, and the triangles.
#[derive(Default)]
struct Slab {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// A plane of points, with one more on each side: densities, and numbers of the vertices on the
/// edges to the next point along x and along y.
struct Plane {
    values: Vec<f32>,
    along: [Vec<u32>; 2],
}

/// Marks an edge without a vertex.
const NONE: u32 = u32::MAX;

struct Marcher<'a> {
    density: &'a dyn Density,
    lattice: &'a Lattice,
    level: f32,
    /// Number of points along x, y, z, including those beyond the box.
    wide: [usize; 3],
    /// Buffer for sampled densities.
    row: Vec<f32>,
    planes: [Plane; 2],
    /// Numbers of the vertices between the planes.
    upright: Vec<u32>,
    /// Number of vertices so far, including those that belong to the next slab.
    count: u32,
    made: Slab,
}

impl<'a> Marcher<'a> {
    fn new(density: &'a dyn Density, lattice: &'a Lattice, level: f32) -> Self {
        let wide = lattice.points.map(|p| p + 2);
        let size = wide[0] * wide[1];
        let plane = || Plane {
            values: vec![f32::NEG_INFINITY; size],
            along: [vec![NONE; size], vec![NONE; size]],
        };
        Self {
            density,
            lattice,
            level,
            wide,
            row: vec![0.0; lattice.points[0] * lattice.points[1]],
            planes: [plane(), plane()],
            upright: vec![NONE; size],
            count: 0,
            made: Slab::default(),
        }
    }

    /// Marches layers `from` to `to` of `all`. Vertices are numbered plane by plane, upwards;
    /// those of the last plane belong to the next slab, if there is one.
    fn march(&mut self, from: usize, to: usize, all: usize, count: &AtomicUsize) {
        self.load(1, from);
        self.number_plane(from, true);
        for z in from..to {
            self.planes.swap(0, 1);
            self.load(1, z + 1);
            self.number_upright(z);
            self.number_plane(z + 1, z + 1 < to || to == all);
            let before = self.made.triangles.len();
            self.fill();
            let new = self.made.triangles.len() - before;
            if count.fetch_add(new, Ordering::Relaxed) + new > MAX_TRIANGLES {
                self.made = Slab::default();
                return;
            }
        }
    }

    fn load(&mut self, plane: usize, z: usize) {
        let values = &mut self.planes[plane].values;
        values.fill(f32::NEG_INFINITY);
        let [width, height, depth] = self.lattice.points;
        if !(1..=depth).contains(&z) {
            return;
        }
        self.density.plane(self.lattice, z - 1, &mut self.row);
        for y in 0..height {
            let to = 1 + self.wide[0] * (y + 1);
            values[to..to + width].copy_from_slice(&self.row[y * width..][..width]);
        }
    }

    /// Numbers the vertices on the edges within the upper plane; `own` if they belong to this
    /// slab.
    fn number_plane(&mut self, z: usize, own: bool) {
        let [width, height, _] = self.wide;
        for along in &mut self.planes[1].along {
            along.fill(NONE);
        }
        for i in 0..width * height {
            let (x, y) = (i % width, i / width);
            for (axis, last, next) in [(0, x + 1 == width, i + 1), (1, y + 1 == height, i + width)]
            {
                if last {
                    continue;
                }
                let values = &self.planes[1].values;
                let ends = [values[i], values[next]];
                if self.is_cut(ends) {
                    if own {
                        self.add([x, y, z], axis, ends);
                    }
                    self.planes[1].along[axis][i] = self.count;
                    self.count += 1;
                }
            }
        }
    }

    /// Numbers the vertices on the edges between the planes.
    fn number_upright(&mut self, z: usize) {
        let width = self.wide[0];
        self.upright.fill(NONE);
        for i in 0..self.upright.len() {
            let ends = [0, 1].map(|p: usize| self.planes[p].values[i]);
            if self.is_cut(ends) {
                self.add([i % width, i / width, z], 2, ends);
                self.upright[i] = self.count;
                self.count += 1;
            }
        }
    }

    fn is_cut(&self, [a, b]: [f32; 2]) -> bool {
        (a > self.level) != (b > self.level)
    }

    fn add(&mut self, low: [usize; 3], axis: usize, ends: [f32; 2]) {
        let mut high = low;
        high[axis] += 1;
        let places = [low, high].map(|p| self.lattice.wide_point(p));
        let place = self.cut(places, ends.map(f64::from));
        self.made.vertices.push(place.to_array().map(|v| v as f32));
    }

    /// The point at which an edge crosses the level.
    fn cut(&self, places: [DVec3; 2], values: [f64; 2]) -> DVec3 {
        let level = f64::from(self.level);
        let [low, high] = self.lattice.bounds;
        let [mut a, mut b] = places.map(|p| p.clamp(low, high));
        let [mut above, mut below] = values.map(|v| v - level);
        if above <= 0.0 || above.is_nan() {
            (a, b, above, below) = (b, a, below, above);
        }
        if below == f64::NEG_INFINITY {
            // Beyond the box, or of a density that is.
            match self.density.at(b) {
                Some(value) if value <= level && a != b => below = value - level,
                _ => return b,
            }
        }
        let split = |above: f64, below: f64| {
            let share = above / (above - below);
            if (0.0..=1.0).contains(&share) {
                share
            } else {
                0.5
            }
        };
        // False position, with the Illinois rule: of an end that stays, half.
        let (mut from, mut to) = (0.0, 1.0);
        let mut share = split(above, below);
        let mut kept = 0;
        for _ in 0..TRIES {
            let Some(value) = self.density.at(a.lerp(b, share)) else {
                break;
            };
            let value = value - level;
            if value > 0.0 {
                (from, above) = (share, value);
                if kept == 1 {
                    below /= 2.0;
                }
                kept = 1;
            } else {
                (to, below) = (share, value);
                if kept == -1 {
                    above /= 2.0;
                }
                kept = -1;
            }
            let next = from + (to - from) * split(above, below);
            let moved = (next - share).abs();
            share = next;
            if moved < NEAR || to - from < NEAR {
                break;
            }
        }
        a.lerp(b, share)
    }

    /// Adds the triangles of the cells between the planes.
    fn fill(&mut self) {
        let [width, height, _] = self.wide;
        let cases = &*CASES;
        for y in 0..height - 1 {
            for x in 0..width - 1 {
                let i = x + width * y;
                let mut case = 0;
                for corner in 0..8 {
                    let at = i + (corner & 1) + width * (corner >> 1 & 1);
                    let value = self.planes[corner >> 2].values[at];
                    case |= usize::from(value > self.level) << corner;
                }
                for edges in &cases[case] {
                    let triangle = edges.map(|edge| {
                        let low = usize::from(ends(edge)[0]);
                        let at = i + (low & 1) + width * (low >> 1 & 1);
                        match edge / 4 {
                            2 => self.upright[at],
                            axis => self.planes[low >> 2].along[usize::from(axis)][at],
                        }
                    });
                    self.made.triangles.push(triangle);
                }
            }
        }
    }
}
