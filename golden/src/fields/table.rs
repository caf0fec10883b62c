//! Tables of features at the vertices of a line, a plane or a volume, or of a
//! volume whose vertices share entries by a hash, or of the fine cells of a tree.

use glam::DVec3;
use serde::Deserialize;

use super::{FieldError, Nodes};

/// The most vertices along an axis.
const MAX_POINTS: usize = 1 << 14;
/// The most vertices along an axis of a hashed table, whose size does not
/// depend on them.
const MAX_HASHED_POINTS: usize = 1 << 20;
/// What the parts of a vertex are multiplied by in its hash (Teschner et al.
/// 2003; the first is 1 in Instant-NGP).
const PRIMES: [u32; 3] = [1, 2_654_435_761, 805_459_861];
/// The most values of a table.
const MAX_VALUES: usize = 1 << 30;

/// A table. Lines have one axis of more than one vertex, planes two, volumes
/// three.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    points: [usize; 3],
    channels: usize,
    layout: Layout,
    values: Vec<f32>,
}

/// What has an entry of its own in a hashed table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HashUnit {
    /// A vertex, as Instant-NGP has it.
    #[default]
    Vertex,
    /// A block of 8 x 8 x 8 vertices, x fastest: an MVoxel. Which vertices
    /// collide is another matter then, so that a model must be fitted so.
    MVoxel,
}

impl HashUnit {
    /// Vertices an edge of a block.
    pub const BLOCK: usize = 8;
    /// Rows of a block.
    pub const BLOCK_ROWS: usize = Self::BLOCK.pow(3);

    /// Its name in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::MVoxel => "mvoxel",
        }
    }

    /// Rows that have an entry together.
    const fn rows(self) -> usize {
        match self {
            Self::Vertex => 1,
            Self::MVoxel => Self::BLOCK_ROWS,
        }
    }
}

/// Where vertices have their rows.
#[derive(Debug, Clone, PartialEq)]
enum Layout {
    /// One each, x fastest.
    Dense,
    /// Any of so many, by a hash of what has entries.
    Hashed(usize, HashUnit),
    /// In the node of their coarse cell.
    Nodes(Nodes),
}

impl Layout {
    fn rows(&self, points: [usize; 3]) -> usize {
        match self {
            // At most 2^60.
            Self::Dense => points.iter().product(),
            Self::Hashed(rows, _) => *rows,
            Self::Nodes(nodes) => nodes.rows(),
        }
    }

    /// What a row belongs to.
    const fn owner(&self) -> &'static str {
        match self {
            Self::Dense => "vertex",
            Self::Hashed(..) => "entry",
            Self::Nodes(_) => "fine cell",
        }
    }
}

impl Table {
    /// A table of `points` vertices along each axis, x fastest, `channels`
    /// values a vertex.
    ///
    /// # Errors
    /// Sizes out of range, another number of values, or one that is not finite.
    pub fn new(points: [usize; 3], channels: usize, values: Vec<f32>) -> Result<Self, FieldError> {
        Self::checked(points, Layout::Dense, channels, values)
    }

    /// A volume of `points` vertices along each axis that share `entries` of
    /// `channels` values by the hash of Instant-NGP (Müller et al. 2022):
    /// the parts of a vertex times a prime each, modulo 2^32, their exclusive
    /// or modulo the entries.
    ///
    /// # Errors
    /// Sizes out of range, another number of values, or one that is not finite.
    pub fn hashed(
        points: [usize; 3],
        entries: usize,
        channels: usize,
        values: Vec<f32>,
    ) -> Result<Self, FieldError> {
        Self::hashed_by(HashUnit::Vertex, points, entries, channels, values)
    }

    /// A volume of `points` vertices along each axis that share `rows` of
    /// `channels` values: a whole number of entries of `unit`. A block's entry is
    /// that hash of its number along each axis.
    ///
    /// # Errors
    /// As [`Table::hashed`].
    pub fn hashed_by(
        unit: HashUnit,
        points: [usize; 3],
        rows: usize,
        channels: usize,
        values: Vec<f32>,
    ) -> Result<Self, FieldError> {
        if !rows.is_multiple_of(unit.rows()) {
            return Err(FieldError::Part {
                part: "table.rows",
                found: rows.to_string(),
                expected: format!("a multiple of {}, the rows of an entry", unit.rows()),
            });
        }
        Self::checked(points, Layout::Hashed(rows, unit), channels, values)
    }

    /// A two-level tree, a row a fine cell, whose value is that everywhere in
    /// the cell: nothing is interpolated.
    ///
    /// # Errors
    /// Sizes out of range, another number of values, or one that is not finite.
    pub fn tree(nodes: Nodes, channels: usize, values: Vec<f32>) -> Result<Self, FieldError> {
        Self::checked(nodes.points(), Layout::Nodes(nodes), channels, values)
    }

    fn checked(
        points: [usize; 3],
        layout: Layout,
        channels: usize,
        values: Vec<f32>,
    ) -> Result<Self, FieldError> {
        let refuse = |part, found: String, expected: String| {
            Err(FieldError::Part {
                part,
                found,
                expected,
            })
        };
        let most = match layout {
            Layout::Hashed(..) => MAX_HASHED_POINTS,
            Layout::Dense | Layout::Nodes(_) => MAX_POINTS,
        };
        if points.iter().any(|p| !(1..=most).contains(p)) {
            let expected = format!("1 to {most} vertices along each axis");
            return refuse("table.points", format!("{points:?}"), expected);
        }
        let count = layout.rows(points).checked_mul(channels);
        let Some(count) = count.filter(|n| (1..=MAX_VALUES).contains(n)) else {
            let expected = format!("1 to {MAX_VALUES} values");
            return refuse("table", format!("{points:?} x {channels}"), expected);
        };
        if values.len() != count {
            let expected = format!("{count}, one for each {} and channel", layout.owner());
            return refuse("table.values.len()", values.len().to_string(), expected);
        }
        if let Some(at) = values.iter().position(|v| !v.is_finite()) {
            let found = format!(
                "{} at {} {}, channel {}",
                values[at],
                layout.owner(),
                at / channels,
                at % channels
            );
            return refuse("table.values", found, "finite numbers".to_owned());
        }
        Ok(Self {
            points,
            channels,
            layout,
            values,
        })
    }

    /// Whether vertices share entries.
    #[must_use]
    pub const fn is_hashed(&self) -> bool {
        matches!(self.layout, Layout::Hashed(..))
    }

    /// What vertices share entries by, where they do.
    #[must_use]
    pub const fn hash_unit(&self) -> Option<HashUnit> {
        match self.layout {
            Layout::Hashed(_, unit) => Some(unit),
            _ => None,
        }
    }

    /// The nodes of a tree.
    pub(super) const fn nodes(&self) -> Option<&Nodes> {
        match &self.layout {
            Layout::Nodes(nodes) => Some(nodes),
            _ => None,
        }
    }

    /// Rows of values.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.len() / self.channels
    }

    /// The row of a vertex in a hashed table of so many rows.
    pub(super) fn hashed_row(unit: HashUnit, vertex: [usize; 3], rows: usize) -> usize {
        match unit {
            HashUnit::Vertex => hash(vertex) as usize % rows,
            HashUnit::MVoxel => {
                let edge = HashUnit::BLOCK;
                let entries = rows / HashUnit::BLOCK_ROWS;
                let entry = hash(vertex.map(|v| v / edge)) as usize % entries;
                let [x, y, z] = vertex.map(|v| v % edge);
                entry * HashUnit::BLOCK_ROWS + x + edge * (y + edge * z)
            }
        }
    }

    /// The row of values of a vertex, of a dense or hashed table.
    fn row(&self, vertex: [usize; 3]) -> usize {
        match self.layout {
            Layout::Hashed(rows, unit) => Self::hashed_row(unit, vertex, rows),
            _ => vertex[0] + self.points[0] * (vertex[1] + self.points[1] * vertex[2]),
        }
    }

    /// Vertices along each axis.
    #[must_use]
    pub const fn points(&self) -> [usize; 3] {
        self.points
    }

    /// Values a vertex.
    #[must_use]
    pub const fn channels(&self) -> usize {
        self.channels
    }

    /// All values, channels fastest, then x, y, z, or entries.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Vertices that a sample reads: 2, 4 or 8, or the only one.
    #[must_use]
    pub fn vertices(&self) -> usize {
        if self.nodes().is_some() {
            return 1;
        }
        1 << self.points.iter().filter(|p| **p > 1).count()
    }

    /// Gathering: the multilinear interpolation at a place in vertices, held
    /// within the table, one value a channel.
    pub fn gather(&self, place: DVec3, out: &mut [f64]) {
        out.fill(0.0);
        self.corners(place, |vertex, weight| {
            let row = &self.values[vertex * self.channels..][..self.channels];
            for (sum, value) in out.iter_mut().zip(row) {
                *sum += weight * f64::from(*value);
            }
        });
    }

    /// Tells each row that a sample at a place reads, and its weight.
    pub fn corners(&self, place: DVec3, mut read: impl FnMut(usize, f64)) {
        if let Some(nodes) = self.nodes() {
            if let Some(row) = nodes.row(nodes.cell(place)) {
                read(row, 1.0);
            }
            return;
        }
        let mut cell = [0usize; 3];
        let mut fraction = [0f64; 3];
        for axis in 0..3 {
            let last = self.points[axis] - 1;
            let held = place[axis].clamp(0.0, last as f64);
            cell[axis] = (held as usize).min(last.saturating_sub(1));
            fraction[axis] = held - cell[axis] as f64;
        }
        let flat = self.points.map(|points| points == 1);
        for corner in 0..8usize {
            let far = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
            if (0..3).any(|axis| far[axis] && flat[axis]) {
                continue;
            }
            let mut weight = 1.0;
            let mut index = [0; 3];
            for axis in 0..3 {
                index[axis] = cell[axis] + usize::from(far[axis]);
                weight *= match (flat[axis], far[axis]) {
                    (true, _) => 1.0,
                    (false, true) => fraction[axis],
                    (false, false) => 1.0 - fraction[axis],
                };
            }
            read(self.row(index), weight);
        }
    }
}

/// The hash of a vertex, before it is brought within a table.
fn hash(vertex: [usize; 3]) -> u32 {
    let products = vertex.iter().zip(PRIMES);
    products.fold(0, |hash, (part, prime)| {
        hash ^ (*part as u32).wrapping_mul(prime)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A multilinear function is its own interpolation, on lines, planes and
    /// volumes.
    #[test]
    fn a_linear_field_comes_back() {
        for points in [[5, 1, 1], [1, 4, 3], [3, 1, 6], [4, 5, 6]] {
            let at = |x: f64, y: f64, z: f64| 1.0 + 2.0 * x - 3.0 * y + 0.5 * z + 0.25 * x * y;
            let mut values = vec![];
            for z in 0..points[2] {
                for y in 0..points[1] {
                    for x in 0..points[0] {
                        let value = at(x as f64, y as f64, z as f64);
                        values.extend([value as f32, -value as f32]);
                    }
                }
            }
            let table = Table::new(points, 2, values).unwrap();
            let axes = points.iter().filter(|p| **p > 1).count();
            assert_eq!(table.vertices(), 1 << axes);
            let mut out = [0.0; 2];
            for i in 0..200 {
                let place = [0, 1, 2].map(|axis| {
                    let last = (points[axis] - 1) as f64;
                    last * f64::from(i * (axis as i32 * 37 + 11) % 100) / 99.0
                });
                let held = [0, 1, 2].map(|a: usize| place[a].clamp(0.0, (points[a] - 1) as f64));
                table.gather(DVec3::from(place), &mut out);
                let exact = at(held[0], held[1], held[2]);
                assert!(
                    (out[0] - exact).abs() < 1e-9 && out[1] == -out[0],
                    "{place:?}"
                );
            }
            // Outside, the nearest place of the table.
            table.gather(DVec3::splat(-3.0), &mut out);
            assert_eq!(out[0], 1.0);
        }
    }

    /// By hand: 3, 5 and 7 times their primes modulo 2^32.
    #[test]
    fn vertices_hash_as_computed_by_hand() {
        assert_eq!(hash([0, 0, 0]), 0);
        assert_eq!(hash([9, 0, 0]), 9);
        assert_eq!(hash([0, 1, 0]), 0x9e37_79b1);
        assert_eq!(hash([0, 0, 1]), 0x3002_5795);
        // 5 x 0x9e3779b1 = 0x3_1715_6075, 7 x 0x30025795 = 0x1_5010_6513.
        assert_eq!(hash([3, 5, 7]), 3 ^ 0x1715_6075 ^ 0x5010_6513);
        let table = Table::hashed([99; 3], 256, 1, vec![0.0; 256]).unwrap();
        assert_eq!(table.row([3, 5, 7]), 3 ^ 0x75 ^ 0x13);
        assert!(table.is_hashed());
    }

    /// By hand: the blocks of vertices (3, 41, 58) and (10, 0, 7) are (0, 5, 7) and
    /// (1, 0, 0).
    #[test]
    fn blocks_hash_as_one() {
        let rows = 4 * HashUnit::BLOCK_ROWS;
        let by = |rows| Table::hashed_by(HashUnit::MVoxel, [99; 3], rows, 1, vec![0.0; rows]);
        let table = by(rows).unwrap();
        assert_eq!(table.hash_unit(), Some(HashUnit::MVoxel));
        // 5 x ..b1 and 7 x ..95 modulo 4: 1 and 3.
        let entry = 1 ^ 3;
        assert_eq!(table.row([3, 41, 58]), 512 * entry + 3 + 8 * (1 + 8 * 2));
        assert_eq!(table.row([10, 0, 7]), 512 + 2 + 8 * (8 * 7));
        let error = by(rows + 8).unwrap_err().to_string();
        assert!(error.contains("a multiple of 512"), "{error}");
    }

    /// In a table of one entry all vertices collide: the interpolation is
    /// that entry everywhere. In one of two, the weights of the even and of
    /// the odd vertices (all primes are odd).
    #[test]
    fn colliding_vertices_share_their_entry() {
        let one = Table::hashed([1000; 3], 1, 2, vec![3.0, -1.0]).unwrap();
        let two = Table::hashed([1000; 3], 2, 1, vec![0.0, 1.0]).unwrap();
        let mut out = [0.0; 2];
        for place in [[0.5, 900.25, 3.125], [998.9, 0.0, 1.0]] {
            one.gather(place.into(), &mut out);
            assert!((out[0] - 3.0).abs() < 1e-12 && (out[1] + 1.0).abs() < 1e-12);
            two.gather(place.into(), &mut out[..1]);
            // Each axis moves between even and odd; 1 - 2 odd is a product.
            let along = |v: f64| {
                (1.0 - 2.0 * v.fract())
                    * if (v as u32).is_multiple_of(2) {
                        1.0
                    } else {
                        -1.0
                    }
            };
            let odd = (1.0 - place.iter().map(|v| along(*v)).product::<f64>()) / 2.0;
            assert!((out[0] - odd).abs() < 1e-9, "{place:?}: {} {odd}", out[0]);
        }
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let error = |points, channels, values: Vec<f32>| {
            Table::new(points, channels, values)
                .unwrap_err()
                .to_string()
        };
        assert!(error([0, 1, 1], 1, vec![]).contains("vertices along each axis"));
        assert!(error([2, 1, 1], 0, vec![]).contains("table"));
        assert!(error([2, 1, 1], 1, vec![1.0]).contains("2, one for each vertex"));
        assert!(error([2, 1, 1], 2, vec![0.0, 0.0, 0.0, f32::NAN]).contains("vertex 1, channel 1"));
        assert!(error([1 << 14; 3], 4, vec![]).contains("values"));
        let error = |points, entries, values| {
            let made = Table::hashed([points; 3], entries, 1, values);
            made.unwrap_err().to_string()
        };
        assert!(error(9, 0, vec![]).contains("values"));
        assert!(error(9, 2, vec![1.0]).contains("2, one for each entry"));
        assert!(error(9, 1, vec![f32::INFINITY]).contains("entry 0"));
        assert!(error(1 << 21, 1, vec![1.0]).contains("1048576 vertices"));
    }
}
