//! Accesses of fields that are sampled along rays.

use rayon::prelude::*;

use super::{Accesses, interleave};
use crate::camera::Camera;
use crate::fields::{Field, FieldError, samples_of};

/// Reads of a frame: every row of every sample that is gathered, a ray a lane,
/// rays of a picture row side by side. Vectors are the rows of the tables, one
/// table behind another, in two bytes a channel.
///
/// # Errors
/// As [`crate::fields::render_float`].
pub fn field_accesses(
    field: &dyn Field,
    camera: &Camera,
    lanes: usize,
) -> Result<Accesses, FieldError> {
    let mut first = 0u32;
    let mut firsts = vec![];
    for table in field.tables() {
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
                for ((table, place), first) in field.tables().iter().zip(places).zip(&firsts) {
                    table.corners(*place, |row, _| list.push(first + row as u32));
                }
            })?;
            Ok(list)
        })
        .collect();
    let channels = field
        .tables()
        .iter()
        .map(|t| t.channels())
        .max()
        .unwrap_or(0);
    Ok(interleave(
        &lists?,
        lanes,
        u64::from(first),
        2 * channels as u32,
    ))
}
