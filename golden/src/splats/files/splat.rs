//! `.splat` files: 32 bytes a Gaussian, without a header.
//!
//! Little-endian: centre as three floats, standard deviations as three floats,
//! colour and opacity as four bytes of 1/255, and the quaternion `w, x, y, z`
//! as four bytes `128 + 128 q`. No spherical harmonics above the constant.
//! After the converter of antimatter15/splat, whose format it is.

use super::error::{FileError, Origin};
use super::values;
use crate::splats::Cloud;

/// Bytes of a Gaussian.
const ROW: usize = 32;

/// Reads a cloud; `origin` names the file in errors. A standard deviation of
/// 0, to which a small one rounds, is read as the smallest normal float.
///
/// # Errors
/// No whole number of Gaussians, or values that make no cloud.
pub fn parse(bytes: &[u8], origin: &str) -> Result<Cloud, FileError> {
    let name = Origin(origin);
    let (rows, rest) = bytes.as_chunks::<ROW>();
    if !rest.is_empty() {
        let expected = format!("a multiple of {ROW}, the bytes of a Gaussian");
        return Err(name.field("length in bytes", bytes.len(), expected));
    }
    let float = |row: &[u8; ROW], i: usize| {
        f32::from_le_bytes([row[4 * i], row[4 * i + 1], row[4 * i + 2], row[4 * i + 3]])
    };
    for (index, row) in rows.iter().enumerate() {
        for axis in 0..3 {
            let scale = float(row, 3 + axis);
            if !(0.0..f32::INFINITY).contains(&scale) {
                let field = format!("Gaussian {index}: scale[{axis}]");
                return Err(name.field(field, scale, "a finite number of at least 0"));
            }
        }
    }
    let logits = values::logits();
    let count = rows.len();
    Cloud::new(
        0,
        values::each(count, |i| [0, 1, 2].map(|k| float(&rows[i], k))),
        values::each(count, |i| {
            [3, 4, 5].map(|k| float(&rows[i], k).max(f32::MIN_POSITIVE).ln())
        }),
        values::each(count, |i| {
            [28, 29, 30, 31].map(|k| (f32::from(rows[i][k]) - 128.0) / 128.0)
        }),
        values::each(count, |i| logits[usize::from(rows[i][27])]),
        values::coefficients(count, 0, |i, out| {
            out[0] = [24, 25, 26].map(|k| values::constant(f64::from(rows[i][k]) / 255.0));
        }),
    )
    .map_err(|e| name.cloud(e))
}
