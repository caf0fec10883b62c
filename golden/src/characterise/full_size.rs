//! The size that the authors of an algorithm use, for a model that is smaller:
//! which samples there are is the model's, which rows they read is of tables as
//! large as theirs. No read depends on what a row holds, so that the values may
//! be any.

use glam::DVec3;

use crate::fields::{Field, FieldError, Nodes, Table};

/// Tables that stand in for a field's.
pub struct FullSize {
    tables: Vec<Table>,
    /// From a place in vertices of the field's table to one of this.
    scales: Vec<DVec3>,
}

/// Tables of another size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// Vertices along each axis that has more than one; channels stay.
    Points(usize),
    /// Entries of hashed tables, and of dense ones no more.
    Entries(usize),
    /// Coarse cells along each axis of a tree.
    Cells(usize),
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
        };
        for table in field.tables() {
            let points = table.points();
            let cells = |p: [usize; 3]| DVec3::from(p.map(|p| p.max(2) as f64 - 1.0));
            let (stand_in, scale) = match size {
                Size::Points(side) => {
                    let full = points.map(|p| if p > 1 { side } else { 1 });
                    let rows: usize = full.iter().product();
                    let values = vec![0.0; rows * table.channels()];
                    let made = Table::new(full, table.channels(), values)?;
                    (made, cells(full) / cells(points))
                }
                Size::Entries(most) => {
                    let vertices = points.iter().map(|p| *p as u128).product::<u128>();
                    let channels = table.channels();
                    let made = if vertices > most as u128 {
                        Table::hashed(points, most, channels, vec![0.0; most * channels])?
                    } else {
                        let values = vec![0.0; vertices as usize * channels];
                        Table::new(points, channels, values)?
                    };
                    (made, DVec3::ONE)
                }
                Size::Cells(side) => {
                    let made = tree(field, table, side)?;
                    let ratio = DVec3::from(made.points().map(|p| p as f64));
                    (made, ratio / DVec3::from(points.map(|p| p as f64)))
                }
            };
            made.tables.push(stand_in);
            made.scales.push(scale);
        }
        Ok(made)
    }

    /// The tables.
    #[must_use]
    pub fn tables(&self) -> &[Table] {
        &self.tables
    }

    /// The place in a table, of that in the field's.
    #[must_use]
    pub fn place(&self, table: usize, own: DVec3) -> DVec3 {
        own * self.scales[table]
    }
}

/// A tree with a node where the field has something in the middle of its coarse
/// cell.
fn tree(field: &dyn Field, table: &Table, side: usize) -> Result<Table, FieldError> {
    let [low, high] = field.sampling().bounds;
    let fine = crate::fields::efficient::FINE;
    let nodes = Nodes::new([side; 3], fine, |cell| {
        let part = DVec3::from(cell.map(|i| (i as f64 + 0.5) / side as f64));
        field.holds(low + (high - low) * part)
    });
    let values = vec![0.0; nodes.rows() * table.channels()];
    Table::tree(nodes, table.channels(), values)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;
    use crate::scene::{Model, Scene};

    /// Corners stay corners, and as much is read of a sample.
    #[test]
    fn places_keep_their_share_of_a_table() {
        for (name, size) in [
            ("moons:ngp", Size::Entries(1 << 19)),
            ("moons:efficientnerf", Size::Cells(96)),
            ("moons:tensorf", Size::Points(300)),
        ] {
            let scene = Scene::open(name).unwrap();
            let field: &dyn Field = match scene.model() {
                Model::Field(field) => &**field,
                Model::Tensorf(field) => &**field,
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
                    other.corners(place, |row, _| {
                        assert!(row < other.rows());
                        read += 1;
                    });
                }
            }
            assert!(read > 0, "{name}");
            let rows = |tables: &[Table]| tables.iter().map(Table::rows).sum::<usize>();
            assert!(rows(full.tables()) > 2 * rows(field.tables()), "{name}");
        }
    }
}
