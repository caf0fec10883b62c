//! Tables as codes, and the gathering of samples from them in the
//! memory-centric order.
//!
//! Tables whose vertices have an entry each are cut into MVoxels
//! ([`MVoxelTable`]), each loaded once for all samples of a batch. Hashed ones
//! keep the order of the samples ([`ScatteredTable`]): their vertices lie
//! anywhere (paper, Sec. "Memory Optimizations", hierarchical encodings).

mod count;
mod mvoxels;
mod scattered;
#[cfg(test)]
mod tests;
mod tree;

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::rit::{MAX_VERTICES, RitEntry, Vertices};

use super::codes::{finest, quantised};
use super::{FieldError, Table};
use crate::units::GatherTask;
use crate::units::weights::{self, FRACTION_BITS};

pub use count::{BatchCount, Counted};
pub(crate) use count::{Tally, Touched};
pub use mvoxels::MVoxelTable;
pub use scattered::ScatteredTable;
pub use tree::TreeTable;

/// A table as codes.
#[derive(Debug, Clone, PartialEq)]
pub enum CodedTable {
    /// Each MVoxel is loaded once for all samples of a batch.
    Streaming(MVoxelTable),
    /// Rows are loaded as samples need them.
    Scattered(ScatteredTable),
    /// MVoxels of coarse cells whose nodes follow one another.
    Tree(TreeTable),
}

/// A sample of a batch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// Of its ray in its group.
    pub slot: u32,
    /// In the table, in vertices.
    pub place: DVec3,
}

/// Gathering tasks of one table.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gathers {
    /// In the order in which they are carried out.
    pub tasks: Vec<GatherTask>,
    /// The sample of every entry of every task, in order.
    pub samples: Vec<u32>,
}

impl CodedTable {
    /// A table as codes of so many fraction bits, one number a channel.
    ///
    /// # Errors
    /// A configuration whose gathering unit has no entries of the table's
    /// vertices, too few segments or too few rows.
    pub fn new(table: &Table, frac_bits: &[u32], config: &Config) -> Result<Self, FieldError> {
        let points = table.points();
        if !points.is_sorted_by(|a, b| *a > 1 || *b == 1) {
            let expected = "axes of one vertex behind the others";
            return Err(part("table.points", format!("{points:?}"), expected));
        }
        let vertices = vertices(table);
        let built = config.supported_vertices();
        if !built.contains(&vertices) {
            let counts: Vec<_> = built.iter().map(|v| v.count()).collect();
            let expected = format!("{} among them", vertices.count());
            return Err(part("gu.vertices", format!("{counts:?}"), expected));
        }
        let channels = table.channels();
        let segments = config.segments(channels);
        if segments > config.gu.segments as usize {
            let found = config.gu.segments.to_string();
            let expected = format!("{segments} or more, for {channels} channels");
            return Err(part("gu.segments", found, expected));
        }
        let bits = config.gu.feature_bits;
        let values = table.values().chunks_exact(channels);
        let codes = values.flat_map(|row| row.iter().zip(frac_bits));
        let codes: Vec<i16> = codes.map(|(v, frac)| quantised(*v, bits, *frac)).collect();
        // A row number has 16 bits.
        let rows = (config.mvoxel.rows as usize).min(1 << 16);
        if let Some(nodes) = table.nodes() {
            return Ok(Self::Tree(TreeTable::new(nodes, codes, channels, rows)?));
        }
        Ok(if table.is_hashed() {
            Self::Scattered(ScatteredTable::new(table, codes, rows)?)
        } else {
            Self::Streaming(MVoxelTable::new(table, &codes, rows)?)
        })
    }

    /// Channels of a row.
    #[must_use]
    pub const fn channels(&self) -> usize {
        match self {
            Self::Streaming(table) => table.channels(),
            Self::Scattered(table) => table.channels(),
            Self::Tree(table) => table.channels(),
        }
    }

    /// Whether rows are loaded as samples need them.
    #[must_use]
    pub const fn is_scattered(&self) -> bool {
        matches!(self, Self::Scattered(_))
    }

    /// The tasks of a batch of samples, each ray's front to back, seen from
    /// `eye` in vertices. Every sample has one entry; in a tree, every sample in a
    /// node.
    #[must_use]
    pub fn gathers(&self, eye: DVec3, samples: &[Located], weight_bits: u32) -> Gathers {
        match self {
            Self::Streaming(table) => table.gathers(eye, samples, weight_bits),
            Self::Scattered(table) => table.gathers(samples, weight_bits),
            Self::Tree(table) => table.gathers(eye, samples),
        }
    }
}

/// The most fraction bits that hold every value of some channels of tables.
///
/// # Errors
/// Values that no format holds.
pub(super) fn finest_of<'a>(
    tables: impl IntoIterator<Item = &'a Table>,
    channels: impl Fn(usize) -> bool,
    config: &Config,
    part: &'static str,
) -> Result<u32, FieldError> {
    let rows = tables
        .into_iter()
        .flat_map(|table| table.values().chunks_exact(table.channels()));
    let picked = rows.flat_map(|row| row.iter().enumerate().filter(|(c, _)| channels(*c)));
    finest(picked.map(|(_, v)| v), config.gu.feature_bits, part)
}

fn part(part: &'static str, found: String, expected: impl Into<String>) -> FieldError {
    FieldError::Part {
        part,
        found,
        expected: expected.into(),
    }
}

/// Vertices an entry.
fn vertices(table: &Table) -> Vertices {
    match table.vertices() {
        1 => Vertices::One,
        2 => Vertices::Two,
        4 => Vertices::Four,
        _ => Vertices::Eight,
    }
}

/// A coordinate with 12 fraction bits, to nearest; monotone, and saturating.
pub(super) fn position_code(v: f64) -> i64 {
    (v * f64::from(1u32 << FRACTION_BITS)).round() as i64
}

/// The lowest vertex of the cell of a place, held within the table, and how far
/// through the cell it is: U1.12, 1 only on the upper faces.
pub(super) fn cell(points: [usize; 3], place: DVec3) -> ([usize; 3], [u16; 3]) {
    let (mut low, mut fraction) = ([0; 3], [0; 3]);
    for axis in 0..3 {
        let cells = points[axis] - 1;
        let code = position_code(place[axis]).max(0) as u64;
        let code = code.min((cells as u64) << FRACTION_BITS);
        low[axis] = ((code >> FRACTION_BITS) as usize).min(cells.saturating_sub(1));
        fraction[axis] = (code - ((low[axis] as u64) << FRACTION_BITS)) as u16;
    }
    (low, fraction)
}

/// An entry, its MVoxel, and how far that is from the camera's.
struct Placed {
    distance: u64,
    mvoxel: u32,
    sample: u32,
    entry: RitEntry,
}

/// Puts entries in the order of their MVoxels: the nearest first, and in each
/// that of the samples.
fn visit(mut placed: Vec<Placed>, task: impl Fn(&[Placed]) -> GatherTask) -> Gathers {
    placed.sort_unstable_by_key(|e| (e.distance, e.mvoxel, e.sample));
    let same = placed.chunk_by(|a, b| a.mvoxel == b.mvoxel);
    Gathers {
        tasks: same.map(task).collect(),
        samples: placed.iter().map(|e| e.sample).collect(),
    }
}

/// The index along an axis of what is `wide` vertices wide; far enough off, and
/// no sum of three overflows.
fn index_of(place: f64, wide: usize) -> i64 {
    position_code(place)
        .div_euclid((wide as i64) << FRACTION_BITS)
        .clamp(-(1 << 50), 1 << 50)
}

/// An entry whose corners lie along the axes that have more than one vertex.
fn entry(
    slot: u32,
    vertices: Vertices,
    fraction: [u16; 3],
    weight_bits: u32,
    row: impl FnMut(usize) -> u16,
) -> RitEntry {
    let mut entry = RitEntry {
        slot,
        rows: [0; MAX_VERTICES],
        weights: [0; MAX_VERTICES],
    };
    let [x, y, _] = fraction;
    match vertices {
        // An id alone.
        Vertices::One => {}
        Vertices::Two => entry.weights[..2].copy_from_slice(&weights::linear(x, weight_bits)),
        Vertices::Four => {
            entry.weights[..4].copy_from_slice(&weights::bilinear([x, y], weight_bits));
        }
        Vertices::Eight => entry.weights = weights::trilinear(fraction, weight_bits),
    }
    let count = vertices.count();
    for (to, row) in entry.rows[..count].iter_mut().zip((0..count).map(row)) {
        *to = row;
    }
    entry
}
