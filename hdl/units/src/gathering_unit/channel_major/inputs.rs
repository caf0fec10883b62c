//! Inputs of the unit.

use potamoi_formats::config::Config;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use crate::gathering_unit::shared::ports::Ports;
use crate::gathering_unit::shared::streams::{Named, rit_stream};

/// Settings and input streams.
pub(super) struct Inputs {
    pub(super) io: Ports,
    /// Whether two records share a row, where built.
    pub(super) two_records: Option<Signal>,
    pub(super) rit: Vec<Named>,
    pub(super) mft: [Named; 3],
}

impl Inputs {
    pub(super) fn declare(m: &mut ModuleBuilder, config: &Config) -> Self {
        let gu = &config.gu;
        let bit = Ty::bit();
        let vertices = m.input(
            "cfg_vertices",
            Ty::u(2),
            "log2 of the vertices an entry; 0 is a single id",
        );
        let segments = m.input("cfg_segments", Ty::u(7), "channel segments, 1 and up");
        let clear = m.input("cfg_clear", bit, "clears counters and flags");
        let two_records = (gu.records_a_row == 2).then(|| {
            m.input(
                "cfg_two_records",
                bit,
                "two records of B / 2 channels share a row; the id's bit above the row says which",
            )
        });
        let rit = rit_stream(m, config);
        let mft = [
            ("s_axis_mft_tvalid", bit, "MVoxel features, a row a beat"),
            ("s_axis_mft_tdata", Ty::u(16 * gu.banks), ""),
            (
                "s_axis_mft_tlast",
                bit,
                "ends the MVoxel's rows of this segment",
            ),
        ]
        .map(|(name, ty, doc)| (name, m.input(name, ty, doc)));
        let ready = m.input("m_axis_feat_tready", bit, "");
        Self {
            io: Ports {
                vertices,
                segments,
                clear,
                ready,
            },
            two_records,
            rit,
            mft,
        }
    }
}
