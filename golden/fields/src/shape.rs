//! The layout of a table, independent of its values.

use glam::DVec3;

use super::{FieldError, HashUnit, Nodes};

/// Maximum number of vertices along an axis.
const MAX_POINTS: usize = 1 << 14;
/// Maximum number of vertices along an axis of a hashed table, whose size does not depend on them.
const MAX_HASHED_POINTS: usize = 1 << 20;
/// Maximum number of rows times channels.
const MAX_CODES: usize = 1 << 36;

/// A table without its values.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct TableShape {
    points: [usize; 3],
    channels: usize,
    layout: Layout,
}

/// The mapping from vertices to rows.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
enum Layout {
    /// A row for each vertex, x fastest.
    Dense,
    /// One of this many rows, by a hash of the unit.
    Hashed(usize, HashUnit),
    /// A row in the node of the coarse cell.
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

impl TableShape {
    /// A row for each of `points` vertices along each axis, x fastest.
    ///
    /// # Errors
    /// A size is out of range.
    pub fn dense(points: [usize; 3], channels: usize) -> Result<Self, FieldError> {
        Self::checked(points, Layout::Dense, channels)
    }

    /// `points` vertices along each axis that share `rows` by a hash. `rows` must be a whole
    /// number of entries of `unit`.
    ///
    /// # Errors
    /// A size is out of range, or an entry is incomplete.
    pub fn hashed_by(
        unit: HashUnit,
        points: [usize; 3],
        rows: usize,
        channels: usize,
    ) -> Result<Self, FieldError> {
        if !rows.is_multiple_of(unit.rows()) {
            return Err(FieldError::Part {
                part: "table.rows",
                found: rows.to_string(),
                expected: format!("a multiple of {}, the rows of an entry", unit.rows()),
            });
        }
        Self::checked(points, Layout::Hashed(rows, unit), channels)
    }

    /// A row for each fine cell of a tree.
    ///
    /// # Errors
    /// A size is out of range.
    pub fn tree(nodes: Nodes, channels: usize) -> Result<Self, FieldError> {
        Self::checked(nodes.points(), Layout::Nodes(nodes), channels)
    }

    fn checked(points: [usize; 3], layout: Layout, channels: usize) -> Result<Self, FieldError> {
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
        if !count.is_some_and(|n| (1..=MAX_CODES).contains(&n)) {
            let expected = format!("1 to {MAX_CODES} values");
            return refuse("table", format!("{points:?} x {channels}"), expected);
        }
        Ok(Self {
            points,
            channels,
            layout,
        })
    }

    /// Whether vertices share rows.
    #[must_use]
    pub const fn is_hashed(&self) -> bool {
        matches!(self.layout, Layout::Hashed(..))
    }

    /// The unit that shares rows, for hashed tables.
    #[must_use]
    pub const fn hash_unit(&self) -> Option<HashUnit> {
        match self.layout {
            Layout::Hashed(_, unit) => Some(unit),
            _ => None,
        }
    }

    /// The nodes, for trees.
    pub(super) const fn nodes(&self) -> Option<&Nodes> {
        match &self.layout {
            Layout::Nodes(nodes) => Some(nodes),
            _ => None,
        }
    }

    /// Name of the owner of a row, for messages.
    pub(super) const fn owner(&self) -> &'static str {
        self.layout.owner()
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.layout.rows(self.points)
    }

    /// Number of vertices along each axis.
    #[must_use]
    pub const fn points(&self) -> [usize; 3] {
        self.points
    }

    /// Number of values in a row.
    #[must_use]
    pub const fn channels(&self) -> usize {
        self.channels
    }

    /// Number of vertices that a sample reads: 2, 4 or 8, or 1 without interpolation.
    #[must_use]
    pub fn vertices(&self) -> usize {
        if self.nodes().is_some() {
            return 1;
        }
        1 << self.points.iter().filter(|p| **p > 1).count()
    }

    /// Calls `read` with each row that a sample at a position reads, and its weight.
    pub fn corners(&self, place: DVec3, mut read: impl FnMut(usize, f64)) {
        for (row, weight) in self.corners_at(place).all() {
            read(row, weight);
        }
    }

    /// The rows that a sample at a position reads, with their weights.
    #[inline(always)]
    pub(super) fn corners_at(&self, place: DVec3) -> Corners {
        let mut corners = Corners::default();
        if let Layout::Nodes(nodes) = &self.layout {
            if let Some(row) = nodes.row(nodes.cell(place)) {
                corners.add(row, 1.0);
            }
            return corners;
        }
        let (mut cell, mut weights) = ([0usize; 3], [[1.0; 2]; 3]);
        for axis in 0..3 {
            let last = self.points[axis] - 1;
            let held = place[axis].clamp(0.0, last as f64);
            cell[axis] = (held as usize).min(last.saturating_sub(1));
            if last > 0 {
                let fraction = held - cell[axis] as f64;
                weights[axis] = [1.0 - fraction, fraction];
            }
        }
        let near = self.points.map(|points| points.min(2));
        match self.layout {
            Layout::Hashed(rows, unit) => {
                let along = [0, 1, 2].map(|axis| {
                    [cell[axis], cell[axis] + 1].map(|coordinate| unit.along(axis, coordinate))
                });
                corners.fill(near, weights, |[x, y, z]| {
                    unit.joined([along[0][x], along[1][y], along[2][z]], rows)
                });
            }
            _ => {
                let [wide, plane] = [self.points[0], self.points[0] * self.points[1]];
                let first = cell[0] + wide * cell[1] + plane * cell[2];
                corners.fill(near, weights, |[x, y, z]| first + x + wide * y + plane * z);
            }
        }
        corners
    }
}

/// The rows that a sample reads, with their weights: at most one a corner of a cell.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Corners {
    rows: [usize; 8],
    weights: [f64; 8],
    count: usize,
}

impl Corners {
    #[inline(always)]
    fn add(&mut self, row: usize, weight: f64) {
        self.rows[self.count] = row;
        self.weights[self.count] = weight;
        self.count += 1;
    }

    /// Adds the corners of a cell, of as many vertices along each axis, x fastest.
    #[inline(always)]
    fn fill(
        &mut self,
        near: [usize; 3],
        weights: [[f64; 2]; 3],
        row: impl Fn([usize; 3]) -> usize,
    ) {
        for z in 0..near[2] {
            for y in 0..near[1] {
                for x in 0..near[0] {
                    let weight = weights[0][x] * weights[1][y] * weights[2][z];
                    self.add(row([x, y, z]), weight);
                }
            }
        }
    }

    /// Each row and its weight.
    #[inline(always)]
    pub(super) fn all(&self) -> impl Iterator<Item = (usize, f64)> {
        let weights = self.weights.iter().copied();
        self.rows.iter().copied().zip(weights).take(self.count)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Rows are read by the hash of the shape's own unit.
    #[test]
    fn hashed_rows_are_those_of_the_unit() {
        let rows = 4 * HashUnit::BLOCK_ROWS;
        for unit in [HashUnit::Vertex, HashUnit::MVoxel] {
            let shape = TableShape::hashed_by(unit, [99; 3], rows, 2).unwrap();
            assert_eq!((shape.hash_unit(), shape.rows()), (Some(unit), rows));
            assert!(shape.is_hashed());
            let mut read = vec![];
            shape.corners(DVec3::new(7.5, 40.25, 58.0), |row, _| read.push(row));
            let vertex = |c: usize| [7 + (c & 1), 40 + (c >> 1 & 1), 58 + (c >> 2)];
            let expected: Vec<usize> = (0..8).map(|c| unit.row(vertex(c), rows)).collect();
            assert_eq!(read, expected, "{unit:?}");
        }
        assert_eq!(TableShape::dense([2; 3], 1).unwrap().hash_unit(), None);
    }

    #[test]
    fn a_part_of_an_entry_is_refused() {
        let rows = 4 * HashUnit::BLOCK_ROWS + 8;
        let error = TableShape::hashed_by(HashUnit::MVoxel, [99; 3], rows, 1).unwrap_err();
        assert!(error.to_string().contains("a multiple of 512"), "{error}");
        assert!(TableShape::hashed_by(HashUnit::Vertex, [99; 3], rows, 1).is_ok());
    }
}
