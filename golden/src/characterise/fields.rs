//! Accesses of fields that are sampled along rays.

use rayon::prelude::*;

use super::{Accesses, FullSize, interleave};
use crate::camera::Camera;
use crate::fields::{Field, FieldError, samples_of};

/// Reads of a frame: every row of every sample that is gathered, a ray a lane,
/// rays of a picture row side by side. Vectors are the rows of the tables, one
/// table behind another, in two bytes a channel.
///
/// With `full`, rows are those of other tables in place of the field's.
///
/// # Errors
/// As [`crate::fields::render_float`].
pub fn field_accesses(
    field: &dyn Field,
    full: Option<&FullSize>,
    camera: &Camera,
    lanes: usize,
) -> Result<Accesses, FieldError> {
    let tables = full.map_or(field.tables(), FullSize::tables);
    let mut first = 0u32;
    let mut firsts = vec![];
    for table in tables {
        firsts.push(first);
        let rows = table.rows();
        first = u32::try_from(rows)
            .ok()
            .and_then(|n| first.checked_add(n))
            .ok_or_else(|| FieldError::Part {
                part: "tables",
                found: format!("{rows} rows and more"),
                expected: "below 2^32 rows".to_owned(),
            })?;
    }
    let pixels: Vec<[u32; 2]> = (0..camera.height)
        .flat_map(|y| (0..camera.width).map(move |x| [x, y]))
        .collect();
    let lists: Result<Vec<Vec<u32>>, FieldError> = pixels
        .par_iter()
        .map(|pixel| {
            let mut list = vec![];
            samples_of(field, camera, *pixel, |_, places| {
                for (number, (table, first)) in tables.iter().zip(&firsts).enumerate() {
                    let own = places[number];
                    let place = full.map_or(own, |full| full.place(number, own));
                    table.corners(place, |row, _| list.push(first + row as u32));
                }
            })?;
            Ok(list)
        })
        .collect();
    let channels = tables.iter().map(|t| t.channels()).max().unwrap_or(0);
    Ok(interleave(
        &lists?,
        lanes,
        u64::from(first),
        2 * channels as u32,
    ))
}
