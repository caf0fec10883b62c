//! The gathering unit's part of the configuration.

use serde::{Deserialize, Serialize};

use super::Config;
use crate::rit::{MAX_VERTICES, Vertices, WORD_BYTES};

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
    /// By the channel count: [`Config::organisation`].
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

/// Bytes of a compact entry.
const COMPACT_BYTES: usize = 8;
/// Vertices of a cell, and groups of banks of the parity organisation.
const CORNERS: u32 = 8;

impl Config {
    /// The organisation of the banks, and why it is that one.
    #[must_use]
    pub fn organisation(&self) -> (Organisation, String) {
        let gu = &self.gu;
        let eight_only = gu.modes == Modes::Structured && gu.vertices == [Vertices::Eight];
        match (gu.organisation, gu.channels) {
            (Organisation::Auto, None) => (
                Organisation::ChannelMajor,
                "gu.channels is not given: one row of B channels a port and cycle".to_owned(),
            ),
            (Organisation::Auto, Some(c)) if CORNERS * c > gu.banks => (
                Organisation::ChannelMajor,
                format!(
                    "8 C = {} channels of a cell exceed B = {} banks: one vertex a cycle",
                    CORNERS * c,
                    gu.banks
                ),
            ),
            (Organisation::Auto, Some(_)) if !eight_only => (
                Organisation::ChannelMajor,
                "entries of other than 8 vertices are asked for: one vertex a cycle".to_owned(),
            ),
            (Organisation::Auto, Some(c)) => (
                Organisation::Parity,
                format!(
                    "8 C = {} channels of a cell fit B = {} banks: eight vertices a cycle",
                    CORNERS * c,
                    gu.banks
                ),
            ),
            (given, _) => (given, "gu.organisation says so".to_owned()),
        }
    }

    /// Whether a cell's eight vertices are read in one cycle.
    #[must_use]
    pub fn is_parity(&self) -> bool {
        self.organisation().0 == Organisation::Parity
    }

    /// Channels of a segment, hence of a port's part of a feature beat: `B`, or
    /// an eighth of it where eight vertices are read at once.
    #[must_use]
    pub fn lanes_a_port(&self) -> u32 {
        if self.is_parity() {
            self.gu.banks / CORNERS
        } else {
            self.gu.banks
        }
    }

    /// Bytes of one entry of the RIT stream.
    #[must_use]
    pub fn entry_bytes(&self, vertices: Vertices) -> usize {
        match self.rit.entry {
            EntryKind::Compact if vertices.is_structured() => COMPACT_BYTES,
            _ => vertices.entry_bytes(),
        }
    }

    /// Cycles in which a group of M entries is issued: one a vertex, or one for
    /// all eight.
    #[must_use]
    pub fn issue_cycles(&self, vertices: Vertices) -> u32 {
        if self.is_parity() {
            1
        } else {
            vertices.count() as u32
        }
    }

    /// Vertices of a row of the MFT, hence of a beat of its stream.
    #[must_use]
    pub fn vertices_a_row(&self) -> u32 {
        if self.is_parity() { CORNERS } else { 1 }
    }

    /// Rows of one half of the MFT.
    #[must_use]
    pub fn mft_rows(&self) -> u32 {
        self.mvoxel.rows.div_ceil(self.vertices_a_row())
    }

    /// Bits of a channel on the feature stream.
    #[must_use]
    pub fn feature_lane_bits(&self) -> u32 {
        match self.gu.sums {
            Sums::Rounded => 16,
            Sums::Exact => 32,
        }
    }

    /// Records that share a row of the MFT, of entries of `vertices` vertices and
    /// features of `channels` channels.
    #[must_use]
    pub fn records_a_row(&self, vertices: Vertices, channels: usize) -> u32 {
        let fits = !vertices.is_structured() && 2 * channels <= self.gu.banks as usize;
        if fits { self.gu.records_a_row } else { 1 }
    }

    /// Vertices or records that an MVoxel holds.
    #[must_use]
    pub fn mvoxel_capacity(&self, vertices: Vertices, channels: usize) -> u32 {
        self.mvoxel.rows * self.records_a_row(vertices, channels)
    }

    /// Bits that name a row of the MFT. The next one of an id says which half of
    /// the row, where two records share it.
    #[must_use]
    pub fn row_bits(&self) -> u32 {
        (self.mft_rows().max(2) - 1).ilog2() + 1
    }

    /// Register stages from the RIT banks' output to the MFT's address: the
    /// banks' own and the last; one more where pipelined; two more in which the
    /// weights of a compact entry are made, whose way is short enough as it is.
    #[must_use]
    pub fn rit_stages(&self) -> u32 {
        match self.rit.entry {
            EntryKind::Paper => 2 + u32::from(self.gu.pipelined),
            EntryKind::Compact => 4,
        }
    }

    /// Cycles from the issue of a group's last vertex to its offer: one each for
    /// the sum, the rounding and the FIFO, and those of the products.
    #[must_use]
    pub fn gather_latency(&self) -> u32 {
        3 + self.product_stages()
    }

    /// Register stages of a product before it is summed up: its two halves and
    /// itself where pipelined, itself where eight are summed up at once, none
    /// otherwise.
    #[must_use]
    pub fn product_stages(&self) -> u32 {
        match (self.gu.pipelined, self.is_parity()) {
            (true, _) => 2,
            (false, true) => 1,
            (false, false) => 0,
        }
    }

    /// Bits of the RIT stream.
    #[must_use]
    pub fn rit_stream_bits(&self) -> u32 {
        self.rit.stream_bits.unwrap_or(64 * self.gu.ports)
    }

    /// Bits of one RIT row: `M` eight-vertex entries.
    #[must_use]
    pub fn rit_row_bits(&self) -> u32 {
        self.gu.ports * (MAX_VERTICES * WORD_BYTES * 8) as u32
    }

    /// Rows of one RIT half.
    #[must_use]
    pub fn rit_rows(&self) -> u32 {
        self.rit.entries / self.gu.ports
    }

    /// Entries that one RIT half holds.
    #[must_use]
    pub fn rit_entries(&self, vertices: Vertices) -> u32 {
        (self.rit.entries as usize * MAX_VERTICES * WORD_BYTES / self.entry_bytes(vertices)) as u32
    }

    /// Entry sizes that the unit supports, fewest vertices first.
    #[must_use]
    pub fn supported_vertices(&self) -> Vec<Vertices> {
        let gu = &self.gu;
        Vertices::ALL
            .into_iter()
            .filter(|v| match gu.modes {
                Modes::Structured => gu.vertices.contains(v),
                Modes::Unstructured => !v.is_structured(),
                Modes::Both => !v.is_structured() || gu.vertices.contains(v),
            })
            .collect()
    }

    /// Segments that `channels` take: `ceil(channels / B)`, in eighths of B where
    /// eight vertices are read at once.
    #[must_use]
    pub fn segments(&self, channels: usize) -> usize {
        channels.div_ceil(self.lanes_a_port().max(1) as usize)
    }

    /// Bits of the reducers' accumulators.
    #[must_use]
    pub fn accumulator_bits(&self) -> u32 {
        let exact = self.gu.feature_bits + self.gu.weight_bits;
        // What trusted weights spare is not seen of products in parts.
        let whole = self.product_stages() == 0;
        match self.gu.weights {
            WeightTrust::Trusted if whole => exact,
            // Eight codes below 2^(W+1) add four bits.
            _ => exact + 4,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn cells_of_lines_planes_and_cubes_lie_at_fixed_distances() {
        let paper = MvoxelConfig::default();
        assert_eq!(paper.edges(2), Some([32, 16, 1]));
        assert_eq!(paper.edges(3), Some([8; 3]));
        let of = |v| paper.offsets(v).unwrap();
        assert_eq!(of(Vertices::Two)[..2], [0, 1]);
        assert_eq!(of(Vertices::Four)[..4], [0, 1, 32, 33]);
        assert_eq!(of(Vertices::Eight), [0, 1, 8, 9, 64, 65, 72, 73]);
        let few = MvoxelConfig { rows: 7 };
        assert_eq!(few.offsets(Vertices::Eight), None);
        assert_eq!(few.offsets(Vertices::Four), Some([0, 1, 2, 3, 0, 0, 0, 0]));
        assert_eq!(MvoxelConfig { rows: 3 }.offsets(Vertices::Four), None);
    }

    #[test]
    fn the_channel_count_chooses_the_organisation() {
        let of = |text: &str| {
            let config: Config = toml::from_str(text).unwrap();
            config.organisation()
        };
        let eight = "modes = \"structured\"\nvertices = [8]\n";
        for (text, chosen, why) in [
            ("", Organisation::ChannelMajor, "not given"),
            (
                "[gu]\nchannels = 4\n",
                Organisation::ChannelMajor,
                "other than 8",
            ),
            (
                &format!("[gu]\nchannels = 4\n{eight}"),
                Organisation::Parity,
                "8 C = 32",
            ),
            (
                &format!("[gu]\nchannels = 5\n{eight}"),
                Organisation::ChannelMajor,
                "exceed B = 32",
            ),
            (
                "[gu]\norganisation = \"feature-major\"\n",
                Organisation::FeatureMajor,
                "says so",
            ),
        ] {
            let (found, reason) = of(text);
            assert_eq!(found, chosen, "{text}");
            assert!(reason.contains(why), "{reason}");
        }
    }
}
