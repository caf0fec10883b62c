//! Memory traffic of the memory-centric order, in bytes by stream.

use potamoi_formats::config::{Config, EntryKind, RitPath};
use potamoi_formats::record::RECORD_CHANNELS;
use potamoi_formats::rit::Vertices;
use schemars::JsonSchema;
use serde::Serialize;

use potamoi_reference::GatherTask;

/// Bytes of a feature code.
const CODE: u64 = 2;
/// Bytes of an unrounded sum.
const SUM: u64 = 4;
/// Bytes of a compact entry.
const COMPACT: u64 = 8;
/// Bytes of a record.
const RECORD: u64 = RECORD_CHANNELS as u64 * CODE;
/// Bytes of a tile's number in its ray group, and of a record's number of tiles less one: both are
/// at most 65,535.
const TILE: u64 = 2;

/// Bytes of a frame by stream.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Streams {
    /// Records of Gaussians, each written once by the GPU.
    pub records_written: u64,
    /// Rows loaded into the MVoxel feature table: each MVoxel up to the last row used, or only the
    /// used rows if they are fetched one by one.
    pub mvoxels_read: u64,
    /// The ray index table, written by the GPU; 0 if entries come straight from their producer
    /// (`rit.path`).
    pub rit_written: u64,
    /// The ray index table, read by the gathering unit: [`UnitStreams`].
    pub rit_read: u64,
    /// Features that the gathering unit writes, 16 bits a channel, or 32 if it does not round.
    pub features: u64,
    /// Unrounded sums of samples that several MVoxels share, 32 bits a channel.
    pub partial_sums: u64,
    /// Records that exceed the on-chip reorder buffer, with the numbers of their tiles, written
    /// and read back.
    pub spills: u64,
}

/// Traffic between memory and one MVoxel for one ray group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Visit {
    /// Vertices an entry.
    pub vertices: Vertices,
    /// Channels a row.
    pub channels: usize,
    /// Rows loaded.
    pub rows: u64,
    /// Entries with all their vertices in this MVoxel.
    pub whole: u64,
    /// Entries that lack some vertices.
    pub split: u64,
}

impl std::ops::Add for Streams {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            records_written: self.records_written + other.records_written,
            mvoxels_read: self.mvoxels_read + other.mvoxels_read,
            rit_written: self.rit_written + other.rit_written,
            rit_read: self.rit_read + other.rit_read,
            features: self.features + other.features,
            partial_sums: self.partial_sums + other.partial_sums,
            spills: self.spills + other.spills,
        }
    }
}

impl Visit {
    /// The visit of a task whose entries have all their vertices.
    pub fn of(task: &GatherTask) -> Self {
        Self {
            vertices: task.vertices,
            channels: task.channels,
            rows: (task.rows.len() / task.channels.max(1)) as u64,
            whole: task.entries.len() as u64,
            split: 0,
        }
    }
}

impl Streams {
    /// Sum of all streams.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.records_written
            + self.mvoxels_read
            + self.rit_written
            + self.rit_read
            + self.features
            + self.partial_sums
            + self.spills
    }

    /// Counts records written by the GPU.
    pub fn records(&mut self, written: u64) {
        self.records_written += written * RECORD;
    }

    /// Counts `records` written to memory and read back, each with its number of tiles, and the
    /// `tiles` numbers themselves.
    pub fn spills(&mut self, records: u64, tiles: u64) {
        let bytes = records * (RECORD + TILE) + tiles * TILE;
        self.spills += 2 * bytes;
    }

    /// Adds the bytes of one visit.
    pub fn visit(&mut self, visit: &Visit, reads: UnitStreams) {
        let channels = visit.channels as u64;
        let entries = visit.whole + visit.split;
        let table = entries * reads.entry_bytes(visit.vertices);
        self.mvoxels_read += visit.rows * channels * CODE;
        if !reads.direct {
            self.rit_written += table;
            self.rit_read += table * reads.passes(visit.vertices, visit.channels, entries);
        }
        self.features += visit.whole * channels * reads.feature;
        self.partial_sums += visit.split * channels * SUM;
    }
}

/// Sizes and passes of the gathering unit's streams: bytes of a feature and of a RIT entry, and
/// how often it reads the entries. They are read once, and once more for each further segment of
/// channels if an MVoxel's entries exceed both halves of the buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitStreams {
    /// Channels a segment.
    lanes: usize,
    /// Bytes of a half of the RIT buffer.
    half: u64,
    /// Whether structured entries are compact.
    compact: bool,
    /// Whether the table bypasses memory.
    direct: bool,
    /// Bytes of a feature channel.
    feature: u64,
}

impl UnitStreams {
    /// The streams of the paper's unit.
    pub const PAPER: Self = Self {
        lanes: 32,
        half: 128 * Vertices::Eight.entry_bytes() as u64,
        compact: false,
        direct: false,
        feature: CODE,
    };

    /// The streams of the unit that `config` describes.
    #[must_use]
    pub fn of(config: &Config) -> Self {
        Self {
            lanes: config.lanes_a_port().max(1) as usize,
            half: u64::from(config.rit.entries) * Vertices::Eight.entry_bytes() as u64,
            compact: config.rit.entry == EntryKind::Compact,
            direct: config.rit.path == RitPath::Direct,
            feature: u64::from(config.feature_lane_bits()) / 8,
        }
    }

    /// Bytes an entry.
    #[must_use]
    pub const fn entry_bytes(self, vertices: Vertices) -> u64 {
        if self.compact && vertices.is_structured() {
            COMPACT
        } else {
            vertices.entry_bytes() as u64
        }
    }

    /// Bytes moved for an entry that is read once.
    #[must_use]
    pub const fn moved_bytes(self, vertices: Vertices) -> u64 {
        if self.direct {
            0
        } else {
            2 * self.entry_bytes(vertices)
        }
    }

    /// Number of times that `entries` of one MVoxel are read.
    #[must_use]
    pub fn passes(self, vertices: Vertices, channels: usize, entries: u64) -> u64 {
        let fits = entries * self.entry_bytes(vertices) <= 2 * self.half;
        if fits {
            1
        } else {
            channels.div_ceil(self.lanes).max(1) as u64
        }
    }
}

impl Default for UnitStreams {
    fn default() -> Self {
        Self::PAPER
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Halves of 128 structured entries and of 1,536 single ids; 32 banks.
    #[test]
    fn the_table_is_read_again_for_each_segment_where_it_exceeds_both_halves() {
        let reads = UnitStreams::of(&Config::paper());
        assert_eq!(reads, UnitStreams::default());
        for (vertices, held) in [
            (Vertices::Eight, 256),
            (Vertices::Four, 512),
            (Vertices::Two, 1024),
            (Vertices::One, 3072),
        ] {
            assert_eq!(reads.passes(vertices, 33, held), 1);
            assert_eq!(reads.passes(vertices, 33, held + 1), 2);
            assert_eq!(reads.passes(vertices, 32, held + 1), 1);
            assert_eq!(reads.passes(vertices, 128, held + 1), 4);
        }
        let mut streams = Streams::default();
        let visit = Visit {
            vertices: Vertices::Eight,
            channels: 40,
            rows: 10,
            whole: 200,
            split: 57,
        };
        streams.visit(&visit, reads);
        let expected = Streams {
            mvoxels_read: 800,
            rit_written: 48 * 257,
            rit_read: 2 * 48 * 257,
            features: 80 * 200,
            partial_sums: 160 * 57,
            ..Streams::default()
        };
        assert_eq!(streams, expected);
        assert_eq!(streams.total(), 800 + 3 * 48 * 257 + 16_000 + 9_120);

        // Compact entries fit; what comes straight moves no bytes.
        let of = |text: &str| {
            let config = Config::from_toml(text, "test");
            let reads = config.map(|config| UnitStreams::of(&config));
            let mut streams = Streams::default();
            reads.map(|reads| streams.visit(&visit, reads)).ok();
            (streams.rit_written, streams.rit_read, streams.features)
        };
        let compact = of("[rit]\nentry = \"compact\"");
        assert_eq!(compact, (8 * 257, 8 * 257, 16_000));
        assert_eq!(of("[rit]\npath = \"direct\""), (0, 0, 16_000));
    }
}
