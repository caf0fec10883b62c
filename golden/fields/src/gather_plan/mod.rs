//! Quantised tables, and the gathering of samples from them in the memory-centric order.
//!
//! Tables whose vertices have an entry each are cut into MVoxels ([`MVoxelTable`]), each of which
//! is loaded once for all samples of a batch. So are tables hashed by MVoxel ([`BlockTable`]), as
//! long as that saves traffic. Tables hashed by vertex keep the order of the samples
//! ([`ScatteredTable`]), since their vertices lie anywhere (paper, Sec. "Memory Optimizations",
//! hierarchical encodings).

mod blocks;
mod count;
mod mvoxels;
mod part;
mod scattered;
#[cfg(test)]
mod tests;
mod tree;
mod visit;

use glam::DVec3;
use potamoi_formats::config::{Config, EntryKind, Sums, presets_that};
use potamoi_formats::rit::{MAX_VERTICES, RitEntry, Vertices};

use super::quantisation::{finest, quantised};
use super::{FieldError, HashUnit, Table};
use potamoi_march::streams::UnitStreams;
use potamoi_march::tiling::Halo;
use potamoi_march::{FixedStats, MarchError, gather};
use potamoi_reference::gathering_unit::Reducer;
use potamoi_reference::{Units, weights};

pub use blocks::BlockTable;
pub use count::{BatchCount, Counted};
pub(crate) use count::{Tally, Touched};
pub use mvoxels::MVoxelTable;
pub(crate) use part::{Load, Part, Shape};
pub use scattered::ScatteredTable;
pub use tree::TreeTable;
pub use visit::Gathers;

/// A quantised table.
#[derive(Debug, Clone, PartialEq)]
pub struct CodedTable {
    order: Order,
    shape: Shape,
    unit_streams: UnitStreams,
    /// Maximum number of rows in an MVoxel, or in memory at a time.
    rows: usize,
}

/// The order in which samples are gathered from a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Order {
    /// MVoxel by MVoxel, each loaded once for all samples of a batch.
    Streaming(MVoxelTable),
    /// By hash entries, each an MVoxel loaded once, or by rows as samples need them.
    Blocks(BlockTable),
    /// By rows as samples need them.
    Scattered(ScatteredTable),
    /// By MVoxels of coarse cells whose nodes are consecutive.
    Tree(TreeTable),
}

/// A sample of a batch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// Slot of its ray in the group.
    pub slot: u32,
    /// Position in the table, in vertices.
    pub place: DVec3,
}

/// Refuses units that find the rows of an entry from its cell: vertices of a hashed table lie anywhere.
fn rows_anywhere(config: &Config) -> Result<(), FieldError> {
    let compact = |own: &Config| own.rit.entry == EntryKind::Compact;
    let able = presets_that(|own| !own.is_parity() && !compact(own));
    let expected = |what| format!("{what}: rows of a hashed table are no cell{able}");
    if compact(config) {
        let expected = expected("\"paper\", which names each row");
        return Err(part("rit.entry", "\"compact\"".to_owned(), &expected));
    }
    if config.is_parity() {
        let expected = expected("\"channel-major\"");
        return Err(part("gu.organisation", "\"parity\"".to_owned(), &expected));
    }
    Ok(())
}

impl CodedTable {
    /// Quantises a table with `frac_bits` fraction bits a channel, in MVoxels with a shared halo.
    ///
    /// # Errors
    /// The configuration's gathering unit does not support entries of the table's vertices, or has
    /// too few segments or rows.
    pub fn new(table: &Table, frac_bits: &[u32], config: &Config) -> Result<Self, FieldError> {
        Self::with_halo(table, frac_bits, config, Halo::Shared)
    }

    /// As [`CodedTable::new`], with a choice of halo. Tables hashed by MVoxel always split it, and
    /// trees have none.
    ///
    /// # Errors
    /// Those of [`CodedTable::new`].
    pub fn with_halo(
        table: &Table,
        frac_bits: &[u32],
        config: &Config,
        halo: Halo,
    ) -> Result<Self, FieldError> {
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
        if table.hash_unit() == Some(HashUnit::Vertex) {
            rows_anywhere(config)?;
        }
        let bits = config.gu.feature_bits;
        let values = table.values().chunks_exact(channels);
        let codes = values.flat_map(|row| row.iter().zip(frac_bits));
        let codes: Vec<i16> = codes.map(|(v, frac)| quantised(*v, bits, *frac)).collect();
        // A row number has 16 bits.
        let rows = config.mvoxel.rows.min(1 << 16);
        let held = rows as usize;
        let shape = Shape {
            channels,
            vertices,
            reducer: Reducer::new(config),
            exact_sums: config.gu.sums == Sums::Exact,
        };
        let order = match (table.nodes(), table.hash_unit()) {
            (Some(nodes), _) => Order::Tree(TreeTable::new(nodes, codes, shape, held)?),
            (_, None) => Order::Streaming(MVoxelTable::new(points, shape, &codes, rows, halo)?),
            (_, Some(HashUnit::MVoxel)) => {
                Order::Blocks(BlockTable::new(points, shape, codes, held)?)
            }
            (_, Some(unit @ HashUnit::Vertex)) => {
                let codes = codes.into();
                Order::Scattered(ScatteredTable::new(points, unit, shape, &codes, held)?)
            }
        };
        Ok(Self {
            order,
            shape,
            unit_streams: UnitStreams::of(config),
            rows: held.min(table.rows()),
        })
    }

    /// The order in which samples are gathered.
    #[must_use]
    pub const fn order(&self) -> &Order {
        &self.order
    }

    /// Channels a row.
    #[must_use]
    pub const fn channels(&self) -> usize {
        self.shape.channels
    }

    /// The tasks of a batch of samples, each ray's front to back, seen from `eye` in vertices.
    /// Every sample has an entry in each MVoxel that holds vertices of its cell; in a tree, every
    /// sample in a node has one.
    #[must_use]
    pub fn gathers(&self, eye: DVec3, samples: &[Located]) -> Gathers {
        let weight_bits = self.shape.reducer.weight_bits();
        match &self.order {
            Order::Streaming(table) => table.gathers(eye, samples),
            Order::Blocks(table) => table.gathers(eye, samples, weight_bits),
            Order::Scattered(table) => table.gathers(samples, weight_bits),
            Order::Tree(table) => table.gathers(eye, samples),
        }
    }

    /// Whether samples may be gathered MVoxel by MVoxel.
    const fn streams(&self) -> bool {
        match &self.order {
            Order::Streaming(_) | Order::Tree(_) => true,
            Order::Blocks(table) => table.streams(),
            Order::Scattered(_) => false,
        }
    }

    /// Bytes of a full MVoxel, or of the rows in memory at a time.
    #[must_use]
    pub const fn mvoxel_bytes(&self) -> u64 {
        2 * (self.rows * self.shape.channels) as u64
    }

    /// Bytes moved by a sample with one entry: the entry written and read, and its features.
    #[must_use]
    pub(crate) const fn sample_bytes(&self) -> u64 {
        self.unit_streams.moved_bytes(self.shape.vertices) + 2 * self.shape.channels as u64
    }

    /// Whether its MVoxels can share vertices.
    #[must_use]
    pub const fn has_halo(&self) -> bool {
        matches!(self.order, Order::Streaming(_))
    }

    /// Counts what a sample reads MVoxel by MVoxel.
    fn touch(&self, place: DVec3, tally: &mut Tally) {
        match &self.order {
            Order::Streaming(table) => table.touch(place, tally),
            Order::Blocks(table) => table.touch(place, tally),
            Order::Tree(table) => table.touch(place, tally),
            Order::Scattered(_) => {}
        }
    }

    /// The table in the order of samples, if it may be gathered so.
    const fn scattered(&self) -> Option<&ScatteredTable> {
        match &self.order {
            Order::Streaming(_) | Order::Tree(_) => None,
            Order::Blocks(table) => Some(table.scattered()),
            Order::Scattered(table) => Some(table),
        }
    }

    /// Executes the planned tasks of a batch, counts them, and passes on the codes of every sample
    /// that has an entry.
    pub(super) fn carry_out(
        &self,
        gathers: &Gathers,
        units: &mut dyn Units,
        stats: &mut FixedStats,
        mut put: impl FnMut(u32, &[i16]),
    ) -> Result<(), MarchError> {
        let width = self.channels();
        let parted = &gathers.parted;
        let mut sums = parted.sums.clone();
        let mut codes = vec![];
        if self.shape.exact_sums && !parted.samples.is_empty() {
            let mut exact = vec![];
            units
                .sums(&gathers.tasks, &mut exact)
                .map_err(MarchError::Unit)?;
            gathers.add_up(&exact, &mut sums, |sample, own| {
                codes.clear();
                codes.extend(
                    own.iter()
                        .map(|sum| self.shape.reducer.round((*sum).into())),
                );
                put(sample, &codes);
            });
        } else {
            gather(units, &gathers.tasks, &mut codes)?;
            for (sample, codes) in gathers.samples.iter().zip(codes.chunks_exact(width)) {
                put(*sample, codes);
            }
        }
        stats.count(&gathers.visits, self.unit_streams);
        if gathers.row_by_row {
            let rows: usize = gathers.tasks.iter().map(|t| t.rows.len()).sum();
            stats.scattered_bytes += 2 * rows as u64;
        }
        stats.waiting = stats.waiting.max(parted.waiting);
        for (sample, sums) in parted.samples.iter().zip(sums.chunks_exact(width)) {
            codes.clear();
            codes.extend(sums.iter().map(|sum| self.shape.reducer.round(*sum)));
            put(*sample, &codes);
        }
        Ok(())
    }
}

/// The largest number of fraction bits that holds every value of some channels of tables.
///
/// # Errors
/// A value fits no format.
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

/// An entry whose corners differ along the axes of several vertices.
fn entry(
    slot: u32,
    vertices: Vertices,
    fraction: [u16; 3],
    weight_bits: u32,
    rows: [u16; MAX_VERTICES],
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
    entry.rows[..count].copy_from_slice(&rows[..count]);
    entry
}
