//! Derived sizes of the gathering unit: widths, capacities and pipeline stages, shared by generator
//! and oracle.

use super::{Config, EntryKind, ExtraPorts, Modes, Organisation, Sums, WeightTrust};
use crate::rit::{MAX_VERTICES, Vertices, WORD_BYTES};
use crate::timing::{GatherStage, Pipeline, ReducerStage, RitStage};

/// Bytes of a compact entry.
const COMPACT_BYTES: usize = 8;
/// Vertices of a cell, and bank groups of the parity organisation.
const CORNERS: u32 = 8;

impl Config {
    /// The organisation of the banks, and the reason for it.
    #[must_use]
    pub fn organisation(&self) -> (Organisation, String) {
        let gu = &self.gu;
        let eight_only = gu.modes == Modes::Structured && gu.vertices == [Vertices::Eight];
        match (gu.organisation, gu.channels) {
            (Organisation::Auto, None) => (
                Organisation::ChannelMajor,
                "gu.channels is not given: one row of B channels a port and cycle".to_owned(),
            ),
            (Organisation::Auto, Some(c)) if c.saturating_mul(CORNERS) > gu.banks => (
                Organisation::ChannelMajor,
                format!(
                    "8 C = {} channels of a cell exceed B = {} banks: one vertex a cycle",
                    c.saturating_mul(CORNERS),
                    gu.banks
                ),
            ),
            (Organisation::Auto, Some(_)) if !eight_only => (
                Organisation::ChannelMajor,
                "gu.vertices has counts other than 8: one vertex per cycle".to_owned(),
            ),
            (Organisation::Auto, Some(c)) => (
                Organisation::Parity,
                format!(
                    "8 C = {} channels of a cell fit B = {} banks: eight vertices a cycle",
                    c.saturating_mul(CORNERS),
                    gu.banks
                ),
            ),
            (given, _) => (given, "gu.organisation selects it".to_owned()),
        }
    }

    /// Whether all eight vertices of a cell are read in one cycle.
    #[must_use]
    pub fn is_parity(&self) -> bool {
        self.organisation().0 == Organisation::Parity
    }

    /// Channels of a segment, which are a port's lanes of a feature beat: `B`, or `B / 8` where
    /// eight vertices are read at once.
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

    /// Issue cycles of a group of M entries: one for each vertex, or one for all eight.
    #[must_use]
    pub fn issue_cycles(&self, vertices: Vertices) -> u32 {
        if self.is_parity() {
            1
        } else {
            vertices.count() as u32
        }
    }

    /// Vertices of a row of the MFT, and of a beat of its stream.
    #[must_use]
    pub fn vertices_a_row(&self) -> u32 {
        if self.is_parity() { CORNERS } else { 1 }
    }

    /// Rows of one half of the MFT.
    #[must_use]
    pub fn mft_rows(&self) -> u32 {
        self.mvoxel.rows.div_ceil(self.vertices_a_row())
    }

    /// Parts of a bank of the MFT, selected by the low bits of the row: `M / 2` where more than two
    /// ports take turns, otherwise 1.
    #[must_use]
    pub fn table_parts(&self) -> u32 {
        match self.gu.extra_ports {
            ExtraPorts::Copies => 1,
            ExtraPorts::Split => (self.gu.ports / 2).max(1),
        }
    }

    /// Width of a channel on the feature stream, in bits.
    #[must_use]
    pub fn feature_lane_bits(&self) -> u32 {
        match self.gu.sums {
            Sums::Rounded => 16,
            Sums::Exact => 32,
        }
    }

    /// Records that share a row of the MFT, for entries of `vertices` vertices and features of
    /// `channels` channels.
    #[must_use]
    pub fn records_a_row(&self, vertices: Vertices, channels: usize) -> u32 {
        let fits = !vertices.is_structured() && 2 * channels <= self.gu.banks as usize;
        if fits { self.gu.records_a_row } else { 1 }
    }

    /// Capacity of an MVoxel in vertices or records.
    #[must_use]
    pub fn mvoxel_capacity(&self, vertices: Vertices, channels: usize) -> u32 {
        self.mvoxel
            .rows
            .saturating_mul(self.records_a_row(vertices, channels))
    }

    /// Width of a row address of the MFT, in bits. Where two records share a row, the next bit of
    /// an id selects one.
    #[must_use]
    pub fn row_bits(&self) -> u32 {
        (self.mft_rows().max(2) - 1).ilog2() + 1
    }

    /// Pipeline stages from the output of the RIT banks to the MFT's address.
    #[must_use]
    pub fn rit_pipeline(&self) -> Pipeline<RitStage> {
        Pipeline::rit(self.rit.entry == EntryKind::Compact, self.gu.pipelined)
    }

    /// Pipeline stages of a reducer.
    #[must_use]
    pub fn reducer_pipeline(&self) -> Pipeline<ReducerStage> {
        Pipeline::reducer(self.gu.pipelined, self.is_parity())
    }

    /// Pipeline stages from the issue of a group's last vertex to its offer, in the channel-major
    /// and the parity organisation.
    #[must_use]
    pub fn gather_pipeline(&self) -> Pipeline<GatherStage> {
        Pipeline::gather(&self.reducer_pipeline(), self.gu.pipelined)
    }

    /// Fewest beats of the feature FIFO with which a beat can leave in every cycle: the latency
    /// from a group's last issue to its offer, and one, since a beat counts until the cycle after
    /// the sink takes it.
    #[must_use]
    pub fn least_feature_fifo_depth(&self) -> u32 {
        let latency = match self.gu.organisation {
            Organisation::FeatureMajor => Pipeline::crossbar().cycles(),
            _ => self.gather_pipeline().cycles(),
        };
        latency + 1
    }

    /// Capacity of the feature FIFO in beats, as given or the least one.
    #[must_use]
    pub fn feature_fifo_depth(&self) -> u32 {
        let least = || self.least_feature_fifo_depth();
        self.gu.fifo_depth.unwrap_or_else(least)
    }

    /// Width of the RIT stream, in bits.
    #[must_use]
    pub fn rit_stream_bits(&self) -> u32 {
        self.rit
            .stream_bits
            .unwrap_or(self.gu.ports.saturating_mul(64))
    }

    /// Width of a RIT row in bits: `M` eight-vertex entries.
    #[must_use]
    pub fn rit_row_bits(&self) -> u32 {
        // Rules ask before they refuse too many ports.
        self.gu
            .ports
            .saturating_mul((MAX_VERTICES * WORD_BYTES * 8) as u32)
    }

    /// Rows of one RIT half.
    #[must_use]
    pub fn rit_rows(&self) -> u32 {
        self.rit.entries / self.gu.ports
    }

    /// Capacity of one RIT half in entries.
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

    /// Segments for `channels`: `ceil(channels / B)`, or over `B / 8` where eight vertices are read
    /// at once.
    #[must_use]
    pub fn segments(&self, channels: usize) -> usize {
        channels.div_ceil(self.lanes_a_port().max(1) as usize)
    }

    /// Width of the reducers' accumulators, in bits.
    #[must_use]
    pub fn accumulator_bits(&self) -> u32 {
        let exact = self.gu.feature_bits.saturating_add(self.gu.weight_bits);
        // What trusted weights spare is not seen of registered products.
        let whole = !self.reducer_pipeline().has(ReducerStage::Product);
        match self.gu.weights {
            WeightTrust::Trusted if whole => exact,
            // Eight codes below 2^(W+1) add four bits.
            _ => exact.saturating_add(4),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::config::MvoxelConfig;

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
    fn stages_are_as_documented() {
        let of = |text: &str| {
            let config: Config = toml::from_str(text).unwrap();
            (
                config.rit_pipeline().cycles(),
                config.gather_pipeline().cycles(),
            )
        };
        assert_eq!(of(""), (2, 3));
        assert_eq!(of("[gu]\npipelined = true\n"), (3, 7));
        let compact = "[rit]\nentry = \"compact\"\n";
        assert_eq!(of(compact), (4, 3));
        assert_eq!(of(&format!("{compact}[gu]\npipelined = true\n")), (6, 7));
        let parity = "[gu]\norganisation = \"parity\"\nmodes = \"structured\"\nvertices = [8]\n";
        assert_eq!(of(parity), (2, 4));
        assert_eq!(of(&format!("{parity}pipelined = true\n")), (3, 7));
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
                "selects it",
            ),
        ] {
            let (found, reason) = of(text);
            assert_eq!(found, chosen, "{text}");
            assert!(reason.contains(why), "{reason}");
        }
    }
}
