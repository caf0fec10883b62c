//! The headers of a `.ksplat` file, and where its sections lie.

use super::super::bytes::{byte, f32, u16, u32};
use super::super::error::{FileError, Origin};
use super::keys::CENTRE;

/// Bytes of the header.
const HEADER: usize = 4096;
/// Bytes of a section's header.
const SECTION: usize = 1024;
/// Bytes of a bucket's middle.
const BUCKET: usize = 12;
/// Bytes of a row at the least.
const LEAST_ROW: usize = 24;
/// The default range of coefficients.
const COEFFICIENTS: f32 = 1.5;
/// The default range of centres.
const RANGE: u32 = 32767;
/// The largest degree of the format.
const DEGREE: u16 = 2;

/// The header of the file.
#[derive(Debug)]
pub(super) struct Header {
    /// The compression level, 0 to 2.
    pub(super) level: u16,
    /// Gaussians of all sections, at least one.
    pub(super) count: usize,
    /// Smallest and largest coefficient at level 2.
    pub(super) coefficients: [f32; 2],
    room: usize,
    written: usize,
}

/// A section of the file.
#[derive(Debug)]
pub(super) struct Section<'a> {
    /// Gaussians.
    pub(super) count: usize,
    /// Degree of the spherical harmonics, 0 to 2.
    pub(super) degree: usize,
    /// Rows, of `row` bytes each.
    pub(super) rows: &'a [u8],
    /// Bytes of a row.
    pub(super) row: usize,
    /// Length of a step of centres, and steps a half edge of a bucket.
    pub(super) step: f64,
    /// Codes a half edge of a bucket.
    pub(super) range: u32,
    middles: &'a [u8],
    full: usize,
    capacity: usize,
    /// The first Gaussian of each bucket that is not full.
    starts: Vec<usize>,
}

/// Bytes of a row's parts at a level: of a centre's, size's or rotation's component, and of a coefficient.
pub(super) const fn widths(level: u16) -> [usize; 2] {
    match level {
        0 => [4, 4],
        1 => [2, 2],
        _ => [2, 1],
    }
}

impl Header {
    /// Reads the header, and adds what it says beside it to `beside`.
    pub(super) fn read(
        bytes: &[u8],
        beside: &mut Vec<String>,
        name: Origin<'_>,
    ) -> Result<Self, FileError> {
        let Some(head) = bytes.get(..HEADER) else {
            let expected = format!("at least the {HEADER} of a header");
            return Err(name.field("length in bytes", bytes.len(), expected));
        };
        if head[..2] != [0, 1] {
            let value = format!("{}.{}", head[0], head[1]);
            return Err(name.field("version", value, "0.1, of GaussianSplats3D"));
        }
        let [room, written, places, count] = [4, 8, 12, 16].map(|at| u32(head, at) as usize);
        let most = (bytes.len() - HEADER) / SECTION;
        if room == 0 {
            return Err(name.field("number of sections", room, "1 or more"));
        }
        if room > most {
            let needed = HEADER as u64 + room as u64 * SECTION as u64;
            let expected = format!(
                "fewer, or a whole file: their headers end at byte {needed}, and the file has {} bytes; \
                 it is cut off or damaged",
                bytes.len()
            );
            return Err(name.field("number of sections", room, expected));
        }
        if written > room {
            let expected = format!("at most {room}, for which there is room");
            return Err(name.field("number of written sections", written, expected));
        }
        // Some writers leave these counts at 0, which other readers do not look at.
        let written = if written == 0 { room } else { written };
        let places = if places == 0 {
            bytes.len() / LEAST_ROW
        } else {
            places
        };
        if count == 0 {
            return Err(name.field("number of Gaussians", count, "1 or more"));
        }
        if count > places {
            let expected = format!(
                "at most {places}, for which there is room; the file of {} bytes is cut off or damaged",
                bytes.len()
            );
            return Err(name.field("number of Gaussians", count, expected));
        }
        let level = u16(head, 20);
        if level > 2 {
            return Err(name.field("compression level", level, "0, 1 or 2"));
        }
        let ends = [(36, -COEFFICIENTS), (40, COEFFICIENTS)];
        let coefficients = ends.map(|(at, default)| match f32(head, at) {
            0.0 => default,
            other => other,
        });
        let is_range =
            coefficients[0] <= coefficients[1] && coefficients.iter().all(|v| v.is_finite());
        if level == 2 && !is_range {
            let value = format!("{} to {}", coefficients[0], coefficients[1]);
            return Err(name.field(
                "range of coefficients",
                value,
                "finite numbers, the smaller first",
            ));
        }
        if (24..36).any(|at| byte(head, at) != 0) {
            let [x, y, z] = [24, 28, 32].map(|at| f32(head, at));
            beside.push(CENTRE.to_owned());
            if [x, y, z].iter().any(|v| !v.is_finite()) {
                return Err(name.field(CENTRE, format!("{x} {y} {z}"), "finite numbers"));
            }
        }
        if !is_zero(head, &[2..4, 22..24, 44..HEADER]) {
            beside.push("reserved bytes of the header".to_owned());
        }
        Ok(Self {
            level,
            count,
            coefficients,
            room,
            written,
        })
    }

    /// Finds all sections.
    pub(super) fn sections<'a>(
        &self,
        bytes: &'a [u8],
        beside: &mut Vec<String>,
        name: Origin<'_>,
    ) -> Result<Vec<Section<'a>>, FileError> {
        let (heads, mut rest) = bytes[HEADER..].split_at(self.room * SECTION);
        let mut all = vec![];
        for (index, head) in heads.chunks(SECTION).enumerate() {
            let section = self.section(index, head, &mut rest, beside, name)?;
            if index >= self.written && section.count > 0 {
                let field = format!("section {index}: number of Gaussians");
                let expected = format!("0: {} sections are written", self.written);
                return Err(name.field(field, section.count, expected));
            }
            all.push(section);
        }
        if !rest.is_empty() {
            beside.push(format!("bytes after the sections ({})", rest.len()));
        }
        let found: usize = all.iter().map(|own| own.count).sum();
        if found != self.count {
            let expected = format!("{}, as the header says", self.count);
            return Err(name.field("number of Gaussians of all sections", found, expected));
        }
        Ok(all)
    }

    fn section<'a>(
        &self,
        index: usize,
        head: &[u8],
        rest: &mut &'a [u8],
        beside: &mut Vec<String>,
        name: Origin<'_>,
    ) -> Result<Section<'a>, FileError> {
        let wrong = |what: &str, value: String, expected: String| {
            name.field(format!("section {index}: {what}"), value, expected)
        };
        let [count, room, capacity, buckets] = [0, 4, 8, 12].map(|at| u32(head, at) as usize);
        let (edge, stored, range) = (f32(head, 16), usize::from(u16(head, 20)), u32(head, 24));
        let [bytes, full, others] = [28, 32, 36].map(|at| u32(head, at) as usize);
        let degree = u16(head, 40);
        if count > room {
            let expected = format!("at most {room}, for which there is room");
            return Err(wrong("number of Gaussians", count.to_string(), expected));
        }
        if degree > DEGREE {
            return Err(wrong(
                "degree",
                degree.to_string(),
                format!("0 to {DEGREE}"),
            ));
        }
        if buckets > 0 && stored != BUCKET {
            return Err(wrong(
                "bytes of a bucket",
                stored.to_string(),
                BUCKET.to_string(),
            ));
        }
        let [float, coefficient] = widths(self.level);
        let row = 10 * float + 4 + [0, 9, 24][usize::from(degree)] * coefficient;
        let needed =
            room as u128 * row as u128 + buckets as u128 * BUCKET as u128 + others as u128 * 4;
        if needed > rest.len() as u128 {
            let expected = format!("{needed} for its Gaussians and buckets; the file is cut off");
            return Err(wrong(
                "bytes that are left of the file",
                rest.len().to_string(),
                expected,
            ));
        }
        if bytes != 0 && bytes as u128 != needed {
            let expected = format!("{needed}, for its Gaussians and buckets");
            return Err(wrong("bytes", bytes.to_string(), expected));
        }
        let (lengths, after) = rest.split_at(others * 4);
        let (middles, after) = after.split_at(buckets * BUCKET);
        let (rows, after) = after.split_at(room * row);
        *rest = after;
        let range = if range == 0 { RANGE } else { range };
        let mut section = Section {
            count,
            degree: usize::from(degree),
            rows,
            row,
            step: f64::from(edge) / 2.0 / f64::from(range),
            range,
            middles,
            full,
            capacity,
            starts: vec![],
        };
        if self.level > 0 && count > 0 {
            if !(0.0..f32::INFINITY).contains(&edge) {
                return Err(wrong(
                    "edge of a bucket",
                    edge.to_string(),
                    "0 or more".to_owned(),
                ));
            }
            if range > 65535 {
                return Err(wrong(
                    "range of centres",
                    range.to_string(),
                    "1 to 65535".to_owned(),
                ));
            }
            section.starts = starts(lengths, full.saturating_mul(capacity));
            let held = section.starts.last().copied().unwrap_or_default();
            if full.saturating_add(others) > buckets || held < count {
                let value = format!("{buckets} ({full} of them full), which hold {held}");
                return Err(wrong(
                    "buckets",
                    value,
                    format!("room for {count} Gaussians"),
                ));
            }
            let number = |at| f32(middles, 4 * at);
            if let Some(at) = (0..3 * buckets).find(|at| !number(*at).is_finite()) {
                let what = format!("middle of bucket {}", at / 3);
                return Err(wrong(
                    &what,
                    number(at).to_string(),
                    "finite numbers".to_owned(),
                ));
            }
        }
        if room > count {
            beside.push(format!("section {index}: room for {} more", room - count));
        }
        if !is_zero(head, &[22..24, 42..SECTION]) {
            beside.push(format!("reserved bytes of section {index}"));
        }
        Ok(section)
    }
}

impl Section<'_> {
    /// The middle of the bucket of a Gaussian of the section.
    pub(super) fn middle(&self, index: usize) -> [f64; 3] {
        let bucket = match index.checked_div(self.capacity) {
            Some(bucket) if bucket < self.full => bucket,
            _ => {
                let before = self.starts.partition_point(|start| *start <= index);
                self.full + before.saturating_sub(1)
            }
        };
        [0, 4, 8].map(|at| f64::from(f32(self.middles, bucket * BUCKET + at)))
    }
}

/// The first Gaussian of each bucket that is not full, and the end of the last.
fn starts(lengths: &[u8], first: usize) -> Vec<usize> {
    let mut at = first;
    let mut all = vec![first];
    for length in lengths.as_chunks::<4>().0 {
        at = at.saturating_add(u32::from_le_bytes(*length) as usize);
        all.push(at);
    }
    all
}

fn is_zero(bytes: &[u8], ranges: &[std::ops::Range<usize>]) -> bool {
    let mut all = ranges.iter().cloned().flatten();
    all.all(|at| byte(bytes, at) == 0)
}
