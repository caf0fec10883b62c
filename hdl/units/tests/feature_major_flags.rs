//! Flags of the feature-major unit that no work within its limits raises, by
//! hand.

use potamoi_formats::config::Config;
use potamoi_netlist::Interpreter;
use potamoi_units::gathering_unit::gathering_unit;

const ROW_NOT_LOADED: u64 = 1 << 0;
const ROW_DROPPED: u64 = 1 << 6;
const BAD_SETTING: u64 = 1 << 7;

/// Two banks of two lines each, one lane, single ids.
struct Unit(Interpreter);

impl Unit {
    fn new(channels: u64) -> Self {
        let text = "[gu]\norganisation = \"feature-major\"\nbanks = 2\nlanes = 1\nports = 1\n\
                    [rit]\nentries = 8\n[mvoxel]\nrows = 4\n";
        let config = Config::from_toml(text, "test").unwrap();
        let module = gathering_unit(&config).unwrap();
        let mut unit = Self(Interpreter::new(&module, 3));
        for port in module.ports().iter().filter(|p| !p.output) {
            unit.set(&port.name, 0);
        }
        unit.set("cfg_segments", 1);
        unit.set("cfg_channels", channels);
        unit.set("m_axis_feat_tready", 1);
        unit.0.clock().unwrap();
        unit.set("rst_n", 1);
        unit
    }

    fn set(&mut self, name: &str, value: u64) {
        let port = self.0.port(name).unwrap();
        self.0.set_u64(port, value).unwrap();
    }

    fn get(&mut self, name: &str) -> u64 {
        let port = self.0.port(name).unwrap();
        self.0.eval().unwrap();
        self.0.get_u64(port).unwrap()
    }

    /// Blocks of two rows of one channel; of the last one so many rows.
    fn load(&mut self, blocks: &[u64], rows_of_last: u64) {
        self.set("s_axis_mft_tvalid", 1);
        for (i, block) in blocks.iter().enumerate() {
            let last = i + 1 == blocks.len();
            let keep = if last {
                (1 << (2 * rows_of_last)) - 1
            } else {
                15
            };
            self.set("s_axis_mft_tdata", *block);
            self.set("s_axis_mft_tkeep", keep);
            self.set("s_axis_mft_tlast", u64::from(last));
            assert_eq!(self.get("s_axis_mft_tready"), 1);
            self.0.clock().unwrap();
        }
        self.set("s_axis_mft_tvalid", 0);
    }

    /// The features of two single ids.
    fn gather(&mut self, rows: [u64; 2]) -> Vec<u64> {
        self.set("s_axis_rit_tvalid", 1);
        self.set("s_axis_rit_tdata", rows[0] | rows[1] << 32);
        self.set("s_axis_rit_tkeep", 0xff);
        self.set("s_axis_rit_tlast", 1);
        self.0.clock().unwrap();
        self.set("s_axis_rit_tvalid", 0);
        let mut found = vec![];
        for _ in 0..30 {
            if self.get("m_axis_feat_tvalid") == 1 {
                found.push(self.get("m_axis_feat_tdata"));
            }
            self.0.clock().unwrap();
        }
        found
    }
}

#[test]
fn rows_that_are_not_there_count_as_nothing() {
    let mut unit = Unit::new(1);
    unit.load(&[0x2222_1111, 0x4444_3333], 1);
    assert_eq!(unit.gather([1, 2]), [0x2222, 0x3333]);
    assert_eq!(unit.get("stat_errors"), 0);
    unit.load(&[0x2222_1111, 0x4444_3333], 1);
    // Row 3 lies in a block that is loaded, and row 4 has the place of row 0.
    assert_eq!(unit.gather([3, 4]), [0, 0]);
    assert_eq!(unit.get("stat_errors"), ROW_NOT_LOADED);
    unit.set("cfg_clear", 1);
    unit.0.clock().unwrap();
    assert_eq!(unit.get("stat_errors"), 0);
    assert_eq!(unit.get("stat_busy"), 0);
}

#[test]
fn rows_past_the_mvoxels_are_dropped_and_flagged() {
    let mut unit = Unit::new(1);
    unit.load(&[0x2222_1111, 0x4444_3333, 0x6666_5555], 2);
    assert_eq!(unit.get("stat_errors"), ROW_DROPPED);
    assert_eq!(unit.gather([0, 3]), [0x1111, 0x4444]);
}

#[test]
fn channels_out_of_range_are_flagged() {
    for (channels, flags) in [(0, BAD_SETTING), (1, 0), (2, 0), (3, BAD_SETTING)] {
        let mut unit = Unit::new(channels);
        unit.gather([0, 0]);
        assert_eq!(unit.get("stat_errors"), flags, "{channels}");
    }
}

/// Blocks of two rows of two channels: what is no block raises a flag, and a beat
/// without rows is none, or the end behind a block.
#[test]
fn blocks_that_are_not_as_they_must_be_are_flagged() {
    const ROW: u64 = 0b0011;
    const BOTH: u64 = 0b1111;
    for (what, beats, flags) in [
        ("one block", &[(BOTH, 0), (BOTH, 1)][..], 0),
        (
            "a row in the last block",
            &[(BOTH, 0), (BOTH, 0), (ROW, 0), (ROW, 1)],
            0,
        ),
        (
            "null beats within",
            &[(0, 0), (BOTH, 0), (0, 0), (BOTH, 1)],
            0,
        ),
        ("a null end", &[(BOTH, 0), (BOTH, 0), (0, 1)], 0),
        ("a null end behind a row", &[(ROW, 0), (ROW, 0), (0, 1)], 0),
        (
            "a null end behind all rows",
            &[(BOTH, 0), (BOTH, 0), (BOTH, 0), (BOTH, 0), (0, 1)],
            0,
        ),
        ("an end within a block", &[(BOTH, 1)], ROW_DROPPED),
        (
            "a null end within a block",
            &[(BOTH, 0), (0, 1)],
            ROW_DROPPED,
        ),
        ("half a row", &[(0b0111, 0)], ROW_DROPPED),
        ("no first row", &[(0b1100, 0)], ROW_DROPPED),
        (
            "other rows with the second channel",
            &[(BOTH, 0), (ROW, 1)],
            ROW_DROPPED,
        ),
        (
            "a block behind a partial one",
            &[(ROW, 0), (ROW, 0), (ROW, 0)],
            ROW_DROPPED,
        ),
    ] {
        let mut unit = Unit::new(2);
        unit.set("s_axis_mft_tvalid", 1);
        for (keep, last) in beats {
            unit.set("s_axis_mft_tkeep", *keep);
            unit.set("s_axis_mft_tlast", *last);
            unit.0.clock().unwrap();
        }
        unit.set("s_axis_mft_tvalid", 0);
        assert_eq!(unit.get("stat_errors"), flags, "{what}");
    }
}

/// Features of two channels, of the rows that were loaded before the null beat.
#[test]
fn a_bare_last_beat_of_rows_loads_what_came_before() {
    let mut unit = Unit::new(1);
    unit.load(&[0x2222_1111, 0x4444_3333], 0);
    assert_eq!(unit.gather([0, 1]), [0x1111, 0x2222]);
    assert_eq!(unit.get("stat_errors"), 0);
    unit.load(&[0x2222_1111, 0x4444_3333], 0);
    assert_eq!(unit.gather([1, 2]), [0x2222, 0]);
    assert_eq!(unit.get("stat_errors"), ROW_NOT_LOADED);

    // Of the block before one row is there.
    let mut unit = Unit::new(1);
    unit.set("s_axis_mft_tvalid", 1);
    for (keep, last) in [(0b0011, 0), (0, 1)] {
        unit.set("s_axis_mft_tdata", 0x2222_1111);
        unit.set("s_axis_mft_tkeep", keep);
        unit.set("s_axis_mft_tlast", last);
        unit.0.clock().unwrap();
    }
    unit.set("s_axis_mft_tvalid", 0);
    assert_eq!(unit.gather([0, 1]), [0x1111, 0]);
    assert_eq!(unit.get("stat_errors"), ROW_NOT_LOADED);
}
