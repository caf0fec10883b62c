//! The gathering unit's part of the configuration.

use serde::{Deserialize, Serialize};

use crate::rit::{MAX_VERTICES, Vertices};

/// The macro voxel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MvoxelConfig {
    /// Rows of the MVoxel feature table: vertices, or records, an MVoxel holds.
    pub rows: u32,
}

impl Default for MvoxelConfig {
    fn default() -> Self {
        Self { rows: 512 }
    }
}

impl MvoxelConfig {
    /// Vertices along each axis of a full MVoxel: of a line all rows; of a plane
    /// a rectangle of twice as many along the first axis or as many (32 x 16 with
    /// 512 rows); of a volume a cube (8 with 512 rows), of at most 40 an edge.
    /// Nothing where the rows do not hold a cube of two.
    #[must_use]
    pub fn edges(&self, axes: u32) -> Option<[usize; 3]> {
        // A row number has 16 bits.
        let rows = (self.rows as usize).min(1 << 16);
        Some(match axes {
            0 | 1 => [rows, 1, 1],
            2 => {
                let high = 1 << rows.isqrt().max(1).ilog2();
                [1 << (rows / high).max(1).ilog2(), high, 1]
            }
            _ => [(2..=40).take_while(|e| e * e * e <= rows).last()?; 3],
        })
    }

    /// Rows from a cell's first vertex to its other ones, in the order of a RIT
    /// entry (bit 0 of a vertex is x), in an MVoxel of [`MvoxelConfig::edges`].
    /// Nothing where its rows do not hold a cell.
    #[must_use]
    pub fn offsets(&self, vertices: Vertices) -> Option<[u16; MAX_VERTICES]> {
        let [x, y, z] = self.edges(vertices.log2())?;
        if x * y * z < vertices.count() || vertices == Vertices::Four && y == 1 {
            return None;
        }
        let mut offsets = [0; MAX_VERTICES];
        for (v, offset) in offsets.iter_mut().enumerate().take(vertices.count()) {
            let rows = (v & 1) + (v >> 1 & 1) * x + (v >> 2) * x * y;
            *offset = u16::try_from(rows).ok()?;
        }
        Some(offsets)
    }
}

/// What a structured RIT entry says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EntryKind {
    /// An id and a weight for every vertex: 6 V bytes.
    #[default]
    Paper,
    /// Slot, row of the first vertex, three fractions: 8 bytes. The unit makes
    /// rows and weights.
    Compact,
}

/// How the RIT comes to the unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RitPath {
    /// The GPU writes it to memory, the unit reads it from there.
    #[default]
    Dram,
    /// Straight from what makes it: no bytes in memory.
    Direct,
}

/// The ray index table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RitConfig {
    /// Eight-vertex entries in one half of the double buffer. A half has 48
    /// times as many bytes; smaller entries fill the same bytes.
    pub entries: u32,
    /// Bits of the RIT stream; 64 a port unless given.
    pub stream_bits: Option<u32>,
    /// Bits of the slot that come back with the features, 16 or 32.
    pub slot_bits: u32,
    /// What a structured entry says.
    pub entry: EntryKind,
    /// How the table comes to the unit.
    pub path: RitPath,
}

impl Default for RitConfig {
    fn default() -> Self {
        Self {
            entries: 128,
            stream_bits: None,
            slot_bits: 16,
            entry: EntryKind::Paper,
            path: RitPath::Dram,
        }
    }
}

/// Which kinds of entry the unit is built for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Modes {
    /// Weighted entries of several vertices only.
    Structured,
    /// Single ids only: no reducers.
    Unstructured,
    /// Both, chosen by `cfg_vertices`.
    Both,
}

/// What may be assumed of an entry's weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WeightTrust {
    /// They sum to exactly 1: the narrow accumulator, and a sticky flag if not.
    Trusted,
    /// Any codes: the accumulator holds eight products of any size.
    Any,
}

/// How features lie in the banks of the MVoxel feature table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Organisation {
    /// By the channel count: [`Config::organisation`](super::Config::organisation).
    #[default]
    Auto,
    /// Bank `b` holds channel `b` of every row: no two reads meet in a bank.
    ChannelMajor,
    /// Vertices by the parity of x, y and z in eight groups of banks: a cell has
    /// one in each, so that `C <= B / 8` channels of all eight are read at once.
    Parity,
    /// A bank holds whole rows, row `r` in bank `r mod B`: concurrent ray
    /// samples meet in banks, and wait for one another.
    FeatureMajor,
}

/// What comes out of the reducers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sums {
    /// Features: the sum rounded once, in 16-bit lanes.
    #[default]
    Rounded,
    /// The sum as it is, in units of 2^-W, in 32-bit lanes: sums of entries that
    /// share a sample add up to it, to be rounded once behind the unit.
    Exact,
}

/// How more than two ports read a bank of the MVoxel feature table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExtraPorts {
    /// From copies of the bank, written alike: no port ever waits.
    #[default]
    Copies,
    /// From `M / 2` parts of the bank, by the row's low bits. Each reads two rows at
    /// once; ports that want a third row of a part wait for a turn.
    Split,
}

/// The gathering unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GuConfig {
    /// How features lie in the banks.
    pub organisation: Organisation,
    /// Channels `C` of the features that the unit is for, if they are known:
    /// what `organisation = "auto"` chooses by.
    pub channels: Option<u32>,
    /// Banks `B`: channels read in one cycle.
    pub banks: u32,
    /// Ports `M`: entries processed side by side.
    pub ports: u32,
    /// How more than two of them read a bank.
    pub extra_ports: ExtraPorts,
    /// Lanes `R` of the feature-major organisation: ray samples processed
    /// side by side.
    pub lanes: u32,
    /// Kinds of entry.
    pub modes: Modes,
    /// Entry sizes of the structured kind that the unit supports.
    pub vertices: Vec<Vertices>,
    /// Bits of a feature code.
    pub feature_bits: u32,
    /// Fraction bits `W` of a weight, U1.W.
    pub weight_bits: u32,
    /// What may be assumed of weights.
    pub weights: WeightTrust,
    /// What comes out.
    pub sums: Sums,
    /// Records of at most `B / 2` channels that share a row of the MFT where
    /// entries are single ids: 1 or 2.
    pub records_a_row: u32,
    /// The most channel segments an MVoxel is gathered in.
    pub segments: u32,
    /// Beats the feature FIFO holds.
    pub fifo_depth: u32,
    /// Registers in the reducers' multipliers and from the RIT to the MFT's
    /// address: a higher clock, later results, as many of them.
    pub pipelined: bool,
    /// Bits of the cycle and stall counters, which stop at their maximum.
    pub counter_bits: u32,
}

impl Default for GuConfig {
    fn default() -> Self {
        Self {
            organisation: Organisation::Auto,
            channels: None,
            banks: 32,
            ports: 2,
            extra_ports: ExtraPorts::Copies,
            lanes: 16,
            modes: Modes::Both,
            vertices: vec![Vertices::Eight, Vertices::Four, Vertices::Two],
            feature_bits: 16,
            weight_bits: 15,
            weights: WeightTrust::Trusted,
            sums: Sums::Rounded,
            records_a_row: 1,
            segments: 8,
            fifo_depth: 8,
            pipelined: false,
            counter_bits: 32,
        }
    }
}
