//! The size that the authors of an algorithm use, for a model that is smaller:
//! which samples there are is the model's, which rows they read is of tables as
//! large as theirs. No read depends on what a row holds, so that the values may
//! be any.

use glam::DVec3;

use potamoi_fields::{Field, FieldError, Nodes, Size, Table, TableShape};

/// Tables that stand in for a field's.
pub struct FullSize {
    tables: Vec<TableShape>,
    /// From a place in vertices of the field's table to one of this.
    scales: Vec<DVec3>,
    parts: u32,
}

impl FullSize {
    /// Tables of a size in place of a field's.
    ///
    /// # Errors
    /// A size that no table has.
    pub fn new(field: &dyn Field, size: Size) -> Result<Self, FieldError> {
        let mut made = Self {
            tables: vec![],
            scales: vec![],
            parts: 1,
        };
        let mut finest = 1f64;
        for table in field.tables() {
            let (points, channels) = (table.points(), table.channels());
            let cells = |p: [usize; 3]| DVec3::from(p.map(|p| p.max(2) as f64 - 1.0));
            let (stand_in, scale) = match size {
                Size::Points(side) => {
                    let full = points.map(|p| if p > 1 { side } else { 1 });
                    let scale = cells(full) / cells(points);
                    finest = finest.max(mean(scale, points));
                    (TableShape::dense(full, channels)?, scale)
                }
                Size::Entries(most) => (with_entries(table, most)?, DVec3::ONE),
                Size::Cells(side) => {
                    let made = TableShape::tree(nodes(field, side), channels)?;
                    let ratio = DVec3::from(made.points().map(|p| p as f64));
                    let scale = ratio / DVec3::from(points.map(|p| p as f64));
                    finest = finest.max(mean(scale, points));
                    (made, scale)
                }
            };
            made.tables.push(stand_in);
            made.scales.push(scale);
        }
        made.parts = finest.round() as u32;
        Ok(made)
    }

    /// The tables.
    #[must_use]
    pub fn tables(&self) -> &[TableShape] {
        &self.tables
    }

    /// The place in a table, of that in the field's.
    #[must_use]
    pub fn place(&self, table: usize, own: DVec3) -> DVec3 {
        own * self.scales[table]
    }

    /// Samples in the place of one of the field's, a whole number.
    #[must_use]
    pub const fn parts(&self) -> u32 {
        self.parts
    }
}

/// A table with so many entries, or with one a vertex if those are fewer.
///
/// # Errors
/// A size that no table has.
pub(super) fn with_entries(table: &Table, most: usize) -> Result<TableShape, FieldError> {
    let (points, channels) = (table.points(), table.channels());
    let vertices = points.iter().map(|p| *p as u128).product::<u128>();
    if vertices > most as u128 {
        let unit = table.hash_unit().unwrap_or_default();
        TableShape::hashed_by(unit, points, most, channels)
    } else {
        TableShape::dense(points, channels)
    }
}

/// The geometric mean of a scale over the axes that have more than one vertex.
fn mean(scale: DVec3, points: [usize; 3]) -> f64 {
    let along = scale.to_array().into_iter().zip(points);
    let along: Vec<f64> = along.filter(|(_, p)| *p > 1).map(|(s, _)| s).collect();
    along
        .iter()
        .product::<f64>()
        .powf(1.0 / along.len().max(1) as f64)
}

/// A node where the field has something in the middle of its coarse cell.
fn nodes(field: &dyn Field, side: usize) -> Nodes {
    let [low, high] = field.sampling().bounds;
    Nodes::new(
        [side; 3],
        potamoi_fields::algorithms::efficient::FINE,
        |cell| {
            let part = DVec3::from(cell.map(|i| (i as f64 + 0.5) / side as f64));
            field.holds(low + (high - low) * part)
        },
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;
    use crate::Model;

    /// Corners stay corners, and as much is read of a sample.
    #[test]
    fn places_keep_their_share_of_a_table() {
        for (name, size) in [
            ("moons:ngp", Size::Entries(1 << 19)),
            ("cairn:ngp-mvoxel", Size::Entries(1 << 19)),
            ("moons:efficientnerf", Size::Cells(96)),
            ("moons:tensorf", Size::Points(300)),
        ] {
            let scene = crate::tests::opened(name);
            let field: &dyn Field = match scene.model() {
                Model::Field(field) => &**field,
                _ => panic!("a field"),
            };
            let full = FullSize::new(field, size).unwrap();
            let [low, high] = field.sampling().bounds;
            let mut places = vec![DVec3::ZERO; field.tables().len()];
            let mut read = 0;
            for k in 0..500 {
                let t = f64::from(k) / 499.0;
                let at = low + (high - low) * DVec3::new(t, 1.0 - t, (7.0 * t).fract());
                field.place(at, &mut places);
                for (i, (own, other)) in field.tables().iter().zip(full.tables()).enumerate() {
                    let place = full.place(i, places[i]);
                    let last = DVec3::from(other.points().map(|p| p as f64));
                    assert!(place.cmple(last + 1e-9).all(), "{name} {place} {last}");
                    assert_eq!(own.vertices(), other.vertices());
                    if other.is_hashed() {
                        assert_eq!(own.hash_unit(), other.hash_unit());
                    }
                    other.corners(place, |row, _| {
                        assert!(row < other.rows());
                        read += 1;
                    });
                }
            }
            assert!(read > 0, "{name}");
            let full_rows: usize = full.tables().iter().map(TableShape::rows).sum();
            let rows: usize = field.tables().iter().map(|t| t.rows()).sum();
            assert!(full_rows > 2 * rows, "{name}");
            let hashed = matches!(size, Size::Entries(_));
            assert_eq!(full.parts() == 1, hashed, "{name}");
        }
    }
}
