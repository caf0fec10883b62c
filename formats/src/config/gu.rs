//! Configuration of the gathering unit.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::rit::{MAX_VERTICES, Vertices};

/// The MVoxel (macro voxel).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MvoxelConfig {
    /// Rows of the MVoxel feature table (MFT): vertices or records of an MVoxel.
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
    /// `None` where the rows do not hold a cube of two.
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
    /// `None` where its rows do not hold a cell.
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

/// Content of a structured RIT entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EntryKind {
    /// An id and a weight for every vertex: 6 V bytes.
    #[default]
    Paper,
    /// Slot, row of the first vertex, and three fractions: 8 bytes. The unit computes rows and
    /// weights.
    Compact,
}

/// Path of the RIT to the unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RitPath {
    /// Through memory: the GPU writes it, and the unit reads it.
    #[default]
    Dram,
    /// Directly from its producer, without memory traffic.
    Direct,
}

/// The (tile, Gaussian) pairs of splats that the table lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RitPairs {
    /// All pairs of the profile.
    #[default]
    All,
    /// Those in whose tile a pixel may count, by a test of the GPU for each pair. No bit of the
    /// picture depends on the others.
    ThatMayCount,
}

/// The ray index table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RitConfig {
    /// Eight-vertex entries in one half of the double buffer. A half has 48 times as many bytes,
    /// which smaller entries share.
    pub entries: u32,
    /// Width of the RIT stream in bits; 64 for each port by default.
    pub stream_bits: Option<u32>,
    /// Bits of the slot that are returned with the features, 16 or 32.
    pub slot_bits: u32,
    /// Content of a structured entry.
    pub entry: EntryKind,
    /// Path of the table to the unit.
    pub path: RitPath,
    /// The (tile, Gaussian) pairs of splats that the GPU lists and sorts. No hardware depends on it.
    pub pairs: RitPairs,
}

impl Default for RitConfig {
    fn default() -> Self {
        Self {
            entries: 128,
            stream_bits: None,
            slot_bits: 16,
            entry: EntryKind::Paper,
            path: RitPath::Dram,
            pairs: RitPairs::All,
        }
    }
}

/// Kinds of entry that the unit supports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Modes {
    /// Weighted entries of several vertices.
    Structured,
    /// Single ids, without reducers.
    Unstructured,
    /// Both, selected by `cfg_vertices`.
    Both,
}

/// Assumption about an entry's weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WeightTrust {
    /// They sum to exactly 1: a narrow accumulator, and a sticky flag on violation.
    Trusted,
    /// Any codes: the accumulator holds eight products of any size.
    Any,
}

/// Organisation of features in the banks of the MFT.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Organisation {
    /// Chosen by the channel count.
    ///
    /// [`Config::organisation`](super::Config::organisation) chooses.
    #[default]
    Auto,
    /// Bank `b` holds channel `b` of every row: no bank conflicts.
    ChannelMajor,
    /// Vertices are distributed by the parity of x, y and z over eight groups of banks. A cell has
    /// one vertex in each, so that `C <= B / 8` channels of all eight are read at once.
    Parity,
    /// Each bank holds whole rows, row `r` in bank `r mod B`: concurrent ray samples have bank
    /// conflicts.
    FeatureMajor,
}

/// Output of the reducers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sums {
    /// Features: the sum, rounded once, in 16-bit lanes.
    #[default]
    Rounded,
    /// The unrounded sum in units of 2^-W, in 32-bit lanes. Sums of entries that share a sample add
    /// up exactly, and are rounded once outside the unit.
    Exact,
}

/// How more than two ports read a bank of the MFT.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ExtraPorts {
    /// From copies of the bank with equal contents: no port ever waits.
    #[default]
    Copies,
    /// From `M / 2` parts of the bank, selected by the row's low bits. Each part reads two rows at
    /// once; ports that need a third row of a part wait for a turn.
    Split,
}

/// The gathering unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GuConfig {
    /// Organisation of features in the banks.
    pub organisation: Organisation,
    /// Channels `C` of the features, if known; `organisation = "auto"` chooses by them.
    pub channels: Option<u32>,
    /// Banks `B`: channels read in a cycle.
    pub banks: u32,
    /// Ports `M`: entries processed in parallel.
    pub ports: u32,
    /// How more than two ports read a bank.
    pub extra_ports: ExtraPorts,
    /// Lanes `R` of the feature-major organisation: ray samples processed in parallel.
    pub lanes: u32,
    /// Kinds of entry supported.
    pub modes: Modes,
    /// Sizes of structured entries supported.
    pub vertices: Vec<Vertices>,
    /// Width of a feature code in bits.
    pub feature_bits: u32,
    /// Fraction bits `W` of a weight, U1.W.
    pub weight_bits: u32,
    /// Assumption about weights.
    pub weights: WeightTrust,
    /// Output of the reducers.
    pub sums: Sums,
    /// Records of at most `B / 2` channels in a row of the MFT, where entries are single ids: 1 or
    /// 2.
    pub records_a_row: u32,
    /// Largest number of channel segments of an MVoxel.
    pub segments: u32,
    /// Capacity of the feature FIFO in beats; by default the smallest that stalls nothing with a
    /// ready sink.
    pub fifo_depth: Option<u32>,
    /// Whether multipliers of the reducers and the path from the RIT to the MFT's address are
    /// pipelined: a higher clock and latency at the same throughput.
    pub pipelined: bool,
    /// Width of the cycle and stall counters in bits; they saturate.
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
            fifo_depth: None,
            pipelined: false,
            counter_bits: 32,
        }
    }
}
