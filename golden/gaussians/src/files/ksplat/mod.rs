//! `.ksplat` files of mkkellogg's GaussianSplats3D, version 0.1, of all three compression levels.
//!
//! A header of 4096 bytes is followed by a header of 1024 bytes for each section, and by the sections:
//! Gaussians of the buckets that are not full, middles of buckets, and a row for each Gaussian. At level 0
//! rows hold floats; at levels 1 and 2 centres are codes of 16 bits about the middle of the Gaussian's
//! bucket, sizes and quaternions floats of 16 bits, and coefficients floats of 16 bits or bytes over the
//! file's range. Axes are those of the file that was packed, usually right, down, front. Sources: the
//! format's writer and reader, `SplatBuffer` of GaussianSplats3D 0.4.7, and the reader of splat-transform.

mod keys;
mod layout;

use super::bytes::{byte, f32, half};
use super::error::{FileError, Origin};
use super::reader::{Reader, whole};
use super::values;
use crate::Cloud;
use crate::file_content::{Facts, Loaded, Raw};
pub use keys::FORMAT;
use layout::{Header, Section, widths};
use potamoi_base::file_keys::{FileKeys, Notes};
use potamoi_base::sh;

/// The registry entry of the format.
pub(super) static READER: Reader = Reader {
    endings: &["ksplat"],
    formats: &[&FORMAT],
    read: |path, origin| raw(&whole(path)?, origin),
};

/// Reads a cloud; `origin` names the file in errors. A size of 0, to which a small one rounds, becomes the
/// smallest normal float.
///
/// # Errors
/// The file is not a complete one of version 0.1, or the values do not form a valid cloud.
pub fn parse(bytes: &[u8], origin: &str) -> Result<Loaded, FileError> {
    Ok(raw(bytes, origin)?.turned(None))
}

pub(super) fn raw(bytes: &[u8], origin: &str) -> Result<Raw, FileError> {
    let name = Origin(origin);
    let mut beside = vec![];
    let header = Header::read(bytes, &mut beside, name)?;
    let sections = header.sections(bytes, &mut beside, name)?;
    let mut notes = Notes::default();
    let record = FileKeys::new(&FORMAT, beside.into_iter().map(|key| (key, ())));
    record.finish(&mut notes).map_err(|e| name.key(e))?;

    let rows: Vec<Row<'_>> = (sections.iter())
        .flat_map(|section| {
            (0..section.count).map(|index| Row {
                section,
                index,
                level: header.level,
                coefficients: header.coefficients,
            })
        })
        .collect();
    let mut raised = 0u64;
    for (index, row) in rows.iter().enumerate() {
        for (axis, size) in row.sizes().into_iter().enumerate() {
            if !(0.0..f32::INFINITY).contains(&size) {
                let field = format!("Gaussian {index}: scale[{axis}]");
                return Err(name.field(field, size, "a finite number of at least 0"));
            }
            raised += u64::from(size < f32::MIN_POSITIVE);
        }
    }
    let degree = sections.iter().map(|own| own.degree).max().unwrap_or(0);
    let logits = values::logits();
    let count = rows.len();
    let cloud = Cloud::new(
        degree,
        values::each(count, |i| rows[i].centre()),
        values::each(count, |i| {
            rows[i].sizes().map(|size| size.max(f32::MIN_POSITIVE).ln())
        }),
        values::each(count, |i| rows[i].rotation()),
        values::each(count, |i| logits[usize::from(rows[i].colour(3))]),
        values::coefficients(count, degree, |i, out| rows[i].fill(out)),
    );
    let mut facts = Facts::of(&FORMAT).version("0.1");
    facts.say("compression level", header.level);
    facts.say("sections", sections.len());
    facts.clamp("sizes of 0, raised to the smallest normal float", raised);
    Ok(Raw::new(cloud.map_err(|e| name.cloud(e))?, notes).with(facts))
}

/// A row of a section.
struct Row<'a> {
    section: &'a Section<'a>,
    index: usize,
    level: u16,
    coefficients: [f32; 2],
}

impl Row<'_> {
    fn bytes(&self) -> &[u8] {
        &self.section.rows[self.index * self.section.row..][..self.section.row]
    }

    /// The float with this number: three of the centre, three sizes, four of the rotation.
    fn float(&self, number: usize) -> f32 {
        match self.level {
            0 => f32(self.bytes(), 4 * number),
            _ => half(self.bytes(), 2 * number),
        }
    }

    fn centre(&self) -> [f32; 3] {
        if self.level == 0 {
            return [0, 1, 2].map(|axis| self.float(axis));
        }
        let middle = self.section.middle(self.index);
        [0, 1, 2].map(|axis| {
            let code = f64::from(super::bytes::u16(self.bytes(), 2 * axis));
            let steps = code - f64::from(self.section.range);
            (steps * self.section.step + middle[axis]) as f32
        })
    }

    fn sizes(&self) -> [f32; 3] {
        [3, 4, 5].map(|number| self.float(number))
    }

    fn rotation(&self) -> [f32; 4] {
        [6, 7, 8, 9].map(|number| self.float(number))
    }

    fn colour(&self, channel: usize) -> u8 {
        byte(self.bytes(), 10 * widths(self.level)[0] + channel)
    }

    /// The coefficients above the constant: band by band, in each channel by channel.
    fn fill(&self, out: &mut [[f32; 3]]) {
        out[0] = [0, 1, 2].map(|c| values::constant(f64::from(self.colour(c)) / 255.0));
        let mut number = 0;
        for band in 1..=self.section.degree {
            for channel in 0..3 {
                for own in &mut out[sh::coefficients(band - 1)..sh::coefficients(band)] {
                    own[channel] = self.coefficient(number);
                    number += 1;
                }
            }
        }
    }

    fn coefficient(&self, number: usize) -> f32 {
        let [float, width] = widths(self.level);
        let at = 10 * float + 4 + width * number;
        match width {
            4 => f32(self.bytes(), at),
            2 => half(self.bytes(), at),
            _ => {
                let [low, high] = self.coefficients.map(f64::from);
                let part = f64::from(byte(self.bytes(), at)) / 255.0;
                (part * (high - low) + low) as f32
            }
        }
    }
}
