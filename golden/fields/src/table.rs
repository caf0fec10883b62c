//! Tables of features: at the vertices of a line, plane or volume, at vertices that share entries
//! by a hash, or in the fine cells of a tree.

use fearless_simd::{Level, dispatch};
use glam::DVec3;

use super::shape::{Corners, TableShape};
use super::{FieldError, HashUnit, Nodes};

/// Maximum number of values in a table.
const MAX_VALUES: usize = 1 << 30;

/// A table with its values. Lines have one axis of several vertices, planes two, volumes three.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Table {
    shape: TableShape,
    values: Vec<f32>,
}

impl Table {
    /// A dense table of `points` vertices along each axis, x fastest, with `channels` values a
    /// vertex.
    ///
    /// # Errors
    /// A size is out of range, the number of values is wrong, or a value is not finite.
    pub fn new(points: [usize; 3], channels: usize, values: Vec<f32>) -> Result<Self, FieldError> {
        Self::checked(TableShape::dense(points, channels)?, values)
    }

    /// A volume of `points` vertices along each axis that share `entries` of `channels` values by
    /// the hash of Instant-NGP (Müller et al. 2022): the exclusive or of a vertex's coordinates,
    /// each times a prime modulo 2^32, modulo the number of entries.
    ///
    /// # Errors
    /// A size is out of range, the number of values is wrong, or a value is not finite.
    pub fn hashed(
        points: [usize; 3],
        entries: usize,
        channels: usize,
        values: Vec<f32>,
    ) -> Result<Self, FieldError> {
        Self::hashed_by(HashUnit::Vertex, points, entries, channels, values)
    }

    /// A volume of `points` vertices along each axis that share `rows` of `channels` values.
    /// `rows` must be a whole number of entries of `unit`. The entry of a block is the hash of its
    /// index along each axis.
    ///
    /// # Errors
    /// Those of [`Table::hashed`].
    pub fn hashed_by(
        unit: HashUnit,
        points: [usize; 3],
        rows: usize,
        channels: usize,
        values: Vec<f32>,
    ) -> Result<Self, FieldError> {
        let shape = TableShape::hashed_by(unit, points, rows, channels)?;
        Self::checked(shape, values)
    }

    /// A two-level tree with a row for each fine cell. Values are constant within a cell: there is
    /// no interpolation.
    ///
    /// # Errors
    /// A size is out of range, the number of values is wrong, or a value is not finite.
    pub fn tree(nodes: Nodes, channels: usize, values: Vec<f32>) -> Result<Self, FieldError> {
        Self::checked(TableShape::tree(nodes, channels)?, values)
    }

    fn checked(shape: TableShape, values: Vec<f32>) -> Result<Self, FieldError> {
        let refuse = |part, found: String, expected: String| {
            Err(FieldError::Part {
                part,
                found,
                expected,
            })
        };
        let (points, channels) = (shape.points(), shape.channels());
        let count = shape.rows() * channels;
        if count > MAX_VALUES {
            let expected = format!("1 to {MAX_VALUES} values");
            return refuse("table", format!("{points:?} x {channels}"), expected);
        }
        if values.len() != count {
            let expected = format!("{count}, one for each {} and channel", shape.owner());
            return refuse("table.values.len()", values.len().to_string(), expected);
        }
        if let Some(at) = values.iter().position(|v| !v.is_finite()) {
            let found = format!(
                "{} at {} {}, channel {}",
                values[at],
                shape.owner(),
                at / channels,
                at % channels
            );
            return refuse("table.values", found, "finite numbers".to_owned());
        }
        Ok(Self { shape, values })
    }

    /// The layout of its vertices.
    #[must_use]
    pub const fn shape(&self) -> &TableShape {
        &self.shape
    }

    /// Whether vertices share entries.
    #[must_use]
    pub const fn is_hashed(&self) -> bool {
        self.shape.is_hashed()
    }

    /// The unit that shares entries, for hashed tables.
    #[must_use]
    pub const fn hash_unit(&self) -> Option<HashUnit> {
        self.shape.hash_unit()
    }

    /// The nodes, for trees.
    pub(super) const fn nodes(&self) -> Option<&Nodes> {
        self.shape.nodes()
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.shape.rows()
    }

    /// Number of vertices along each axis.
    #[must_use]
    pub const fn points(&self) -> [usize; 3] {
        self.shape.points()
    }

    /// Number of values a vertex.
    #[must_use]
    pub const fn channels(&self) -> usize {
        self.shape.channels()
    }

    /// All values: channels fastest, then x, y, z, or entries.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Number of vertices that a sample reads: 2, 4 or 8, or 1 without interpolation.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.shape.vertices()
    }

    /// Gathering: multilinear interpolation at a position in vertices, clamped to the table; one
    /// value a channel.
    pub fn gather(&self, place: DVec3, out: &mut [f64]) {
        self.interpolate(place, out);
    }

    /// [`Table::gather`], for the vectors of the function that calls it.
    #[inline(always)]
    fn interpolate(&self, place: DVec3, out: &mut [f64]) {
        let corners = self.shape.corners_at(place);
        let (sixteens, rest) = out.as_chunks_mut::<16>();
        for (part, out) in sixteens.iter_mut().enumerate() {
            self.sum(&corners, 16 * part, out);
        }
        let first = 16 * sixteens.len();
        let (fours, rest) = rest.as_chunks_mut::<4>();
        for (part, out) in fours.iter_mut().enumerate() {
            self.sum(&corners, first + 4 * part, out);
        }
        let first = first + 4 * fours.len();
        for (channel, out) in (first..).zip(rest) {
            self.sum(&corners, channel, std::array::from_mut(out));
        }
    }

    /// The weighted sums of some channels from `first` on, corner after corner. The loop over
    /// channels is by number, which the compiler turns into vectors as it stands.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    fn sum<const CHANNELS: usize>(
        &self,
        corners: &Corners,
        first: usize,
        out: &mut [f64; CHANNELS],
    ) {
        let mut sums = [0.0; CHANNELS];
        for (row, weight) in corners.all() {
            let values = &self.values[row * self.channels() + first..][..CHANNELS];
            for channel in 0..CHANNELS {
                sums[channel] += weight * f64::from(values[channel]);
            }
        }
        *out = sums;
    }

    /// Calls `read` with each row that a sample at a position reads, and its weight.
    pub fn corners(&self, place: DVec3, read: impl FnMut(usize, f64)) {
        self.shape.corners(place, read);
    }
}

/// Gathers samples from all tables of a field: `places` has the positions of each sample in every
/// table, `features` a row a sample, table after table.
pub(super) fn gather_all(tables: &[Table], places: &[DVec3], features: &mut [f64]) {
    gather_all_with(Level::new(), tables, places, features);
}

fn gather_all_with(level: Level, tables: &[Table], places: &[DVec3], features: &mut [f64]) {
    dispatch!(level, _ => interpolate_all(tables, places, features));
}

/// [`gather_all`] with the vectors of the function that calls it: of channels, so that neither a
/// product nor the order of additions depends on their width.
#[inline(always)]
fn interpolate_all(tables: &[Table], places: &[DVec3], features: &mut [f64]) {
    let channels = tables.iter().map(Table::channels).sum::<usize>();
    let places = places.chunks_exact(tables.len().max(1));
    let rows = features.chunks_exact_mut(channels.max(1));
    for (places, mut row) in places.zip(rows) {
        for (table, place) in tables.iter().zip(places) {
            let (own, rest) = row.split_at_mut(table.channels());
            table.interpolate(*place, own);
            row = rest;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_base::vectors::Vectors;

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

    /// Any number of channels has the sums corner by corner, to the last bit, and samples gathered
    /// together are those gathered one by one, with all vectors of the machine.
    #[test]
    fn gathered_rows_are_summed_corner_by_corner() {
        let value = |i: usize| ((i * 7919 + 13) % 4001) as f32 / 1000.0 - 2.0;
        let values = |count: usize| (0..count).map(value).collect::<Vec<_>>();
        let mut tables = vec![];
        for channels in [1, 3, 4, 5, 13, 16, 28, 37] {
            let dense = [([9, 1, 1], 9), ([5, 4, 1], 20), ([4, 3, 5], 60)];
            for (points, rows) in dense {
                tables.push(Table::new(points, channels, values(rows * channels)).unwrap());
            }
            for rows in [8, 24] {
                let hashed = Table::hashed([99; 3], rows, channels, values(rows * channels));
                tables.push(hashed.unwrap());
            }
        }
        let place = |i: usize| {
            let part = |prime: usize| (i * prime % 97) as f64 / 11.0 - 0.5;
            DVec3::new(part(31), part(53), part(71))
        };
        let places: Vec<DVec3> = (0..7 * tables.len()).map(place).collect();
        let channels: usize = tables.iter().map(Table::channels).sum();
        let mut each = vec![];
        let bits = |sums: &[f64]| sums.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        for places in places.chunks_exact(tables.len()) {
            for (table, place) in tables.iter().zip(places) {
                let mut expected = vec![0.0; table.channels()];
                table.corners(*place, |row, weight| {
                    let row = &table.values()[row * table.channels()..];
                    for (sum, value) in expected.iter_mut().zip(row) {
                        *sum += weight * f64::from(*value);
                    }
                });
                let mut own = vec![f64::NAN; table.channels()];
                table.gather(*place, &mut own);
                assert_eq!(bits(&own), bits(&expected), "{:?} {place}", table.shape());
                each.extend(own);
            }
        }
        for level in Vectors::here().filter_map(Vectors::level) {
            let mut together = vec![f64::NAN; 7 * channels];
            gather_all_with(level, &tables, &places, &mut together);
            assert_eq!(bits(&together), bits(&each), "{level:?}");
        }
    }
}
