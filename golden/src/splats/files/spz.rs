//! `.spz` files of Niantic, versions 2 to 4.
//!
//! Six arrays: centres (three 24-bit fixed-point numbers each), opacities (a
//! byte each, as are the following), colours, log scales, rotations, and the
//! coefficients above the constant, coefficient by coefficient. Axes are right,
//! up, back; a cloud's are right, down, front, as PLY files have it, so that y
//! and z change their sign. The flag of antialiased training is not read: the
//! rendering profile decides. The containers are in `unpack`. After the format's
//! readme and its reader, nianticlabs/spz.

use std::f64::consts::SQRT_2;

use super::error::{FileError, Origin};
use super::unpack::{Arrays, unpack};
use super::values;
use crate::splats::Cloud;

/// Colour codes per unit of the constant coefficient, over 255.
const COLOUR_SCALE: f64 = 0.15;
/// Signs that the coefficients of degree 0 to 3 take when y and z change
/// theirs: that of `y^j z^k` in the polynomial of the basis function.
const SIGNS: [i32; 16] = [1, -1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1];
/// The same for a point.
const FLIP: [i32; 3] = [1, -1, -1];

/// Reads a cloud; `origin` names the file in errors.
///
/// # Errors
/// No complete SPZ file of version 2 to 4 and degree 0 to 3, or values that
/// make no cloud.
pub fn parse(bytes: &[u8], origin: &str) -> Result<Cloud, FileError> {
    let name = Origin(origin);
    let Arrays { header, bytes } = unpack(bytes, name)?;
    let [positions, alphas, colours, scales, rotations, rest] = bytes.each_ref().map(Vec::as_slice);
    let (positions, _) = positions.as_chunks::<9>();
    let (colours, _) = colours.as_chunks::<3>();
    let (scales, _) = scales.as_chunks::<3>();
    let (first, _) = rotations.as_chunks::<3>();
    let (smallest, _) = rotations.as_chunks::<4>();
    let each = header.rest();
    let step = (-f64::from(header.fraction_bits)).exp2();
    let logits = values::logits();
    let count = header.count;
    Cloud::new(
        header.degree,
        values::each(count, |i| position(&positions[i], step)),
        values::each(count, |i| scales[i].map(|s| f32::from(s) / 16.0 - 10.0)),
        values::each(count, |i| {
            let [w, x, y, z] = if header.version == 2 {
                from_first_three(first[i])
            } else {
                from_smallest_three(u32::from_le_bytes(smallest[i]))
            };
            // Half a turn about x, in the middle of which y and z change sign.
            [w, x, -y, -z]
        }),
        values::each(count, |i| logits[usize::from(alphas[i])]),
        values::coefficients(count, header.degree, |i, out| {
            let constant = |c: u8| ((f64::from(c) / 255.0 - 0.5) / COLOUR_SCALE) as f32;
            out[0] = colours[i].map(constant);
            let (coefficients, _) = rest[i * each..(i + 1) * each].as_chunks::<3>();
            for (k, rgb) in coefficients.iter().enumerate() {
                out[k + 1] = rgb.map(|c| (SIGNS[k + 1] * (i32::from(c) - 128)) as f32 / 128.0);
            }
        }),
    )
    .map_err(|e| name.cloud(e))
}

fn position(bytes: &[u8; 9], step: f64) -> [f32; 3] {
    [0, 1, 2].map(|axis| {
        let b = &bytes[3 * axis..];
        // The code stands in the upper bytes, so that the shift extends its sign.
        let code = i32::from_le_bytes([0, b[0], b[1], b[2]]) >> 8;
        (f64::from(FLIP[axis] * code) * step) as f32
    })
}

/// Version 2: `x, y, z` in a byte each over -1 to 1; `w` is not negative.
fn from_first_three(bytes: [u8; 3]) -> [f32; 4] {
    values::with_largest(0, bytes.map(|b| f64::from(b) / 127.5 - 1.0))
}

/// From version 3: the index of the largest of `x, y, z, w` in the upper 2
/// bits, then the others, each a sign and 9 bits over 1/sqrt(2).
fn from_smallest_three(word: u32) -> [f32; 4] {
    let others = [20, 10, 0].map(|low| {
        let magnitude = f64::from(word >> low & 511) / 511.0 / SQRT_2;
        if word >> low & 512 == 0 {
            magnitude
        } else {
            -magnitude
        }
    });
    let [x, y, z, w] = values::with_largest((word >> 30) as usize, others);
    [w, x, y, z]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use glam::DVec3;

    use super::*;
    use crate::splats::sh;

    #[test]
    fn signs_are_those_of_the_basis_under_the_flip() {
        let d = DVec3::new(0.36, 0.48, -0.8);
        let flipped = DVec3::from([0, 1, 2].map(|k| d[k] * f64::from(FLIP[k])));
        let (a, b) = (sh::basis(d), sh::basis(flipped));
        for k in 0..16 {
            assert!((a[k] - f64::from(SIGNS[k]) * b[k]).abs() < 1e-12, "{k}");
            assert!(a[k].abs() > 1e-3, "{k}: a direction that tells nothing");
        }
    }

    #[test]
    fn codes_of_positions_and_rotations_by_hand() {
        let bytes = [1, 0, 0, 255, 255, 255, 0, 0, 128];
        assert_eq!(position(&bytes, 0.25), [0.25, 0.25, 2_097_152.0]);
        assert_eq!(from_first_three([255, 0, 0]), [0.0, 1.0, -1.0, -1.0]);
        // y is largest; x = -1/sqrt(2), z = 0, w = 0.
        let q = from_smallest_three(1 << 30 | (512 | 511) << 20);
        let root = 0.5f32.sqrt();
        for (found, expected) in q.into_iter().zip([0.0, -root, root, 0.0]) {
            assert!((found - expected).abs() < 1e-6, "{q:?}");
        }
    }
}
