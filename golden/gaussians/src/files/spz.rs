//! `.spz` files of Niantic, versions 1 to 4.
//!
//! Six arrays: centres (three 24-bit fixed-point numbers each; in version 1 three 16-bit floats),
//! opacities (a byte each, as are the following), colours, log scales, rotations, and the
//! coefficients above the constant, coefficient by coefficient. Axes are right, up, back unless an
//! extension changes them. The containers are in `unpack`. Sources: the format's readme and its
//! reader, nianticlabs/spz.

use std::f64::consts::SQRT_2;

use half::f16;

use super::error::{FileError, Origin};
use super::reader::{Reader, whole};
use super::spz_keys::{self, ANTIALIASED, AXES, EXTENDED};
use super::unpack::{Arrays, unpack};
use super::values;
use crate::Cloud;
use crate::axes::Axes;
use crate::file_content::{Facts, Loaded, Raw};
use potamoi_base::file_keys::Notes;

/// Colour codes for one unit of the constant coefficient, divided by 255.
const COLOUR_SCALE: f64 = 0.15;
/// The registry entry of the format.
pub(super) static READER: Reader = Reader {
    endings: &["spz"],
    formats: &[&spz_keys::FORMAT],
    read: |path, origin| raw(&whole(path)?, origin),
};

/// Reads a cloud; `origin` names the file in errors.
///
/// # Errors
/// The file is not a complete SPZ file of version 1 to 4 and degree 0 to 3, or the values do not
/// form a valid cloud.
pub fn parse(bytes: &[u8], origin: &str) -> Result<Loaded, FileError> {
    Ok(raw(bytes, origin)?.turned(None))
}

pub(super) fn raw(bytes: &[u8], origin: &str) -> Result<Raw, FileError> {
    let name = Origin(origin);
    let Arrays {
        header,
        bytes,
        mut record,
    } = unpack(bytes, name)?;
    let antialiased = record.take(ANTIALIASED).is_some();
    record.take(EXTENDED);
    let mut axes = None;
    while let Some(content) = record.take(AXES) {
        // What says nothing contradicts nothing.
        let Some(own) = coordinate_system(&content, name)? else {
            continue;
        };
        if axes.is_some_and(|before| before != own) {
            let said = "the axes of the same extension before it";
            return Err(name.field("coordinate system", "given twice", said));
        }
        axes = Some(own);
    }
    let mut notes = Notes::default();
    record.finish(&mut notes).map_err(|e| name.key(e))?;

    let [positions, alphas, colours, scales, rotations, rest] = bytes.each_ref().map(Vec::as_slice);
    let (halves, _) = positions.as_chunks::<6>();
    let (positions, _) = positions.as_chunks::<9>();
    let (colours, _) = colours.as_chunks::<3>();
    let (scales, _) = scales.as_chunks::<3>();
    let (first, _) = rotations.as_chunks::<3>();
    let (smallest, _) = rotations.as_chunks::<4>();
    let each = header.rest();
    let step = (-f64::from(header.fraction_bits)).exp2();
    let logits = values::logits();
    let count = header.count;
    let cloud = Cloud::new(
        header.degree,
        values::each(count, |i| match header.version {
            1 => half_position(&halves[i]),
            _ => position(&positions[i], step),
        }),
        values::each(count, |i| scales[i].map(|s| f32::from(s) / 16.0 - 10.0)),
        values::each(count, |i| match header.version {
            1 | 2 => from_first_three(first[i]),
            _ => from_smallest_three(u32::from_le_bytes(smallest[i])),
        }),
        values::each(count, |i| logits[usize::from(alphas[i])]),
        values::coefficients(count, header.degree, |i, out| {
            let constant = |c: u8| ((f64::from(c) / 255.0 - 0.5) / COLOUR_SCALE) as f32;
            out[0] = colours[i].map(constant);
            let (coefficients, _) = rest[i * each..(i + 1) * each].as_chunks::<3>();
            for (k, rgb) in coefficients.iter().enumerate() {
                out[k + 1] = rgb.map(|c| (i32::from(c) - 128) as f32 / 128.0);
            }
        }),
    )
    .map_err(|e| name.cloud(e))?;
    let mut facts = Facts::of(&spz_keys::FORMAT).version(header.version);
    if header.version > 1 {
        facts.say("fractional bits of centres", header.fraction_bits);
    }
    let ends = alphas
        .iter()
        .filter(|code| [0, 255].contains(*code))
        .count();
    facts.say("opacities of exactly 0 or 1", ends);
    Ok(Raw {
        axes,
        usual: Axes::RIGHT_UP_BACK,
        ..Raw::new(cloud.antialiased(antialiased), notes).with(facts)
    })
}

/// The axes that the extension names; `None` for code 0.
fn coordinate_system(content: &[u8], name: Origin<'_>) -> Result<Option<Axes>, FileError> {
    let Ok(word) = <[u8; 4]>::try_from(content) else {
        let field = "bytes of the coordinate system's extension";
        return Err(name.field(field, content.len(), "4"));
    };
    match u32::from_le_bytes(word) {
        0 => Ok(None),
        code => Axes::of_spz(code).map(Some).ok_or_else(|| {
            let expected = "0 to 8: none, or LDB, RDB, LUB, RUB, LDF, RDF, LUF, RUF";
            name.field("coordinate system", code, expected)
        }),
    }
}

fn position(bytes: &[u8; 9], step: f64) -> [f32; 3] {
    [0, 1, 2].map(|axis| {
        let b = &bytes[3 * axis..];
        // The code stands in the upper bytes, so that the shift extends its sign.
        let code = i32::from_le_bytes([0, b[0], b[1], b[2]]) >> 8;
        (f64::from(code) * step) as f32
    })
}

fn half_position(bytes: &[u8; 6]) -> [f32; 3] {
    [0, 2, 4].map(|at| f16::from_le_bytes([bytes[at], bytes[at + 1]]).to_f32())
}

/// Up to version 2: `x, y, z` in a byte each over -1 to 1; `w` is at least 0.
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
    use super::*;

    #[test]
    fn codes_of_positions_and_rotations_by_hand() {
        let bytes = [1, 0, 0, 255, 255, 255, 0, 0, 128];
        assert_eq!(position(&bytes, 0.25), [0.25, -0.25, -2_097_152.0]);
        assert_eq!(
            half_position(&[0, 0x3c, 0, 0xc0, 1, 0]),
            [1.0, -2.0, 2f32.powi(-24)]
        );
        assert_eq!(from_first_three([255, 0, 0]), [0.0, 1.0, -1.0, -1.0]);
        // y is largest; x = -1/sqrt(2), z = 0, w = 0.
        let q = from_smallest_three(1 << 30 | (512 | 511) << 20);
        let root = 0.5f32.sqrt();
        for (found, expected) in q.into_iter().zip([0.0, -root, root, 0.0]) {
            assert!((found - expected).abs() < 1e-6, "{q:?}");
        }
    }
}
