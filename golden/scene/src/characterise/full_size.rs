//! Tables of the size that an algorithm's authors use, in place of a smaller model's. The samples
//! are those of the model, the rows that they read are those of the larger tables. No read depends
//! on a value, so the tables need none.

use glam::DVec3;

use potamoi_fields::{Field, FieldError, Nodes, Size, Table, TableShape};

/// Tables that replace those of a field.
pub struct FullSize {
    tables: Vec<TableShape>,
    /// Scales from positions in the field's tables to positions in these.
    scales: Vec<DVec3>,
    parts: u32,
}

impl FullSize {
    /// Tables of a given size in place of a field's.
    ///
    /// # Errors
    /// The size is out of range for a table.
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
                Size::Cells { coarse, fine } => {
                    let made = TableShape::tree(nodes(field, coarse, fine), channels)?;
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

    /// The position in a table for a position in the field's table.
    #[must_use]
    pub fn place(&self, table: usize, own: DVec3) -> DVec3 {
        own * self.scales[table]
    }

    /// Number of samples that replace one of the field's.
    #[must_use]
    pub const fn parts(&self) -> u32 {
        self.parts
    }
}

/// A table with at most `most` entries, or with one a vertex if that is fewer.
///
/// # Errors
/// The size is out of range for a table.
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

/// The geometric mean of a scale over the axes that have several vertices.
fn mean(scale: DVec3, points: [usize; 3]) -> f64 {
    let along = scale.to_array().into_iter().zip(points);
    let along: Vec<f64> = along.filter(|(_, p)| *p > 1).map(|(s, _)| s).collect();
    along
        .iter()
        .product::<f64>()
        .powf(1.0 / along.len().max(1) as f64)
}

/// Nodes for the coarse cells whose middle is non-empty in the field.
fn nodes(field: &dyn Field, side: usize, fine: usize) -> Nodes {
    let [low, high] = field.sampling().bounds;
    Nodes::new([side; 3], fine, |cell| {
        let part = DVec3::from(cell.map(|i| (i as f64 + 0.5) / side as f64));
        field.holds(low + (high - low) * part)
    })
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
            ("cairn:ngp", Size::Entries(1 << 19)),
            ("cairn:ngp-mvoxel", Size::Entries(1 << 19)),
            (
                "cairn:efficientnerf",
                Size::Cells {
                    coarse: 96,
                    fine: 3,
                },
            ),
            ("cairn:tensorf", Size::Points(300)),
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
