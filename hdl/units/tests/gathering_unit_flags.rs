//! The gathering unit's flags and counters, by hand: each broken promise of the
//! streams raises its own bit, `cfg_clear` takes it back, counters stop at
//! their ends.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{Change, Fault, Interpreter, Module};
use potamoi_units::gathering_unit::gathering_unit;

/// One bank and port; entries of eight vertices are six beats of four halfwords.
const UNIT: &str = "[gu]\nbanks = 1\nports = 1\nweight_bits = 8\nsegments = 2\nvertices = [8, 2]\n\
    counter_bits = 24\n[rit]\nentries = 8\n[mvoxel]\nrows = 4\n";
const FULL: u64 = 0xff;

struct Unit {
    run: Interpreter,
}

/// A beat of the RIT: data, keep, last.
type Beat = (u64, u64, bool);

impl Unit {
    fn new(module: &Arc<Module>, log2_vertices: u64, segments: u64) -> Self {
        let mut unit = Self {
            run: Interpreter::new(module, 3),
        };
        for port in module.ports().iter().filter(|p| !p.output) {
            let found = unit.run.port(&port.name).unwrap();
            let words = vec![0; port.ty.width.div_ceil(32) as usize];
            unit.run.set_words(found, &words).unwrap();
        }
        unit.set("cfg_vertices", log2_vertices);
        unit.set("cfg_segments", segments);
        unit.set("m_axis_feat_tready", 1);
        unit.set("rst_n", 0);
        unit.run.clock().unwrap();
        unit.set("rst_n", 1);
        unit
    }

    fn of(text: &str, log2_vertices: u64, segments: u64) -> Self {
        let config =
            Config::from_toml(&UNIT.replace("[gu]", &format!("[gu]\n{text}")), "test").unwrap();
        Self::new(&gathering_unit(&config).unwrap(), log2_vertices, segments)
    }

    fn set(&mut self, name: &str, value: u64) {
        let port = self.run.port(name).unwrap();
        self.run.set_u64(port, value).unwrap();
    }

    fn get(&mut self, name: &str) -> u64 {
        let port = self.run.port(name).unwrap();
        self.run.eval().unwrap();
        self.run.get_u64(port).unwrap()
    }

    fn rows(&mut self, rows: &[u64]) {
        self.set("s_axis_mft_tvalid", 1);
        for (i, row) in rows.iter().enumerate() {
            self.set("s_axis_mft_tdata", *row);
            self.set("s_axis_mft_tlast", u64::from(i + 1 == rows.len()));
            assert_eq!(self.get("s_axis_mft_tready"), 1);
            self.run.clock().unwrap();
        }
        self.set("s_axis_mft_tvalid", 0);
    }

    fn rit(&mut self, beats: &[Beat]) {
        self.set("s_axis_rit_tvalid", 1);
        for (data, keep, last) in beats {
            self.set("s_axis_rit_tdata", *data);
            self.set("s_axis_rit_tkeep", *keep);
            self.set("s_axis_rit_tlast", u64::from(*last));
            for _ in 0..40 {
                if self.get("s_axis_rit_tready") == 1 {
                    break;
                }
                self.run.clock().unwrap();
            }
            assert_eq!(self.get("s_axis_rit_tready"), 1);
            self.run.clock().unwrap();
        }
        self.set("s_axis_rit_tvalid", 0);
        for _ in 0..40 {
            self.run.clock().unwrap();
        }
    }

    /// Raised flags, which are then cleared.
    fn flags(&mut self) -> u64 {
        let raised = self.get("stat_errors");
        self.set("cfg_clear", 1);
        self.run.clock().unwrap();
        self.set("cfg_clear", 0);
        assert_eq!(self.get("stat_errors"), 0, "cleared");
        for name in ["busy", "stall_fifo", "stall_mft", "stall_rit", "entries"] {
            assert_eq!(self.get(&format!("stat_{name}")), 0, "{name} is cleared");
        }
        raised
    }
}

/// Beats of one entry of eight vertices {row, tag, weight}.
fn entry(vertices: [(u64, u64); 8]) -> Vec<Beat> {
    let halfwords: Vec<u64> = vertices.iter().flat_map(|(row, w)| [*row, 7, *w]).collect();
    let mut beats: Vec<Beat> = halfwords
        .chunks(4)
        .map(|c| {
            (
                c.iter().rev().fold(0, |word, h| word << 16 | h),
                FULL,
                false,
            )
        })
        .collect();
    beats.last_mut().unwrap().2 = true;
    beats
}

fn even() -> [(u64, u64); 8] {
    std::array::from_fn(|v| (v as u64 % 4, 32))
}

#[test]
fn what_is_right_raises_nothing() {
    let mut unit = Unit::of("", 3, 1);
    unit.rows(&[1, 2, 3, 4]);
    unit.rit(&entry(even()));
    assert_eq!(unit.get("stat_entries"), 1);
    assert_eq!(unit.get("stat_busy"), 8);
    assert_eq!(unit.flags(), 0);
}

#[test]
fn each_broken_promise_raises_its_own_flag() {
    let raised = |beats: &[Beat]| {
        let mut unit = Unit::of("", 3, 1);
        unit.rows(&[1, 2, 3, 4]);
        unit.rit(beats);
        unit.flags()
    };
    let mut vertices = even();
    vertices[5].0 = 4;
    assert_eq!(
        raised(&entry(vertices)),
        1 << 0,
        "a row that was not loaded"
    );
    let mut vertices = even();
    (vertices[2].1, vertices[3].1) = (32 | 1 << 9, 32);
    assert_eq!(raised(&entry(vertices)), 1 << 1, "a weight above bit W");
    let mut vertices = even();
    vertices[7].1 = 33;
    assert_eq!(raised(&entry(vertices)), 1 << 2, "weights off one");
    // Half an entry of two vertices is none of eight.
    let ragged = raised(&[(0, FULL, true)]);
    assert_eq!(ragged & !0b111, 1 << 3, "ragged entries");
    let mut gap = entry(even());
    gap[1].1 = 0x3f;
    assert_eq!(raised(&gap) & 1 << 4, 1 << 4, "a gap in a beat");

    let mut unit = Unit::of("", 3, 1);
    unit.rows(&[1, 2, 3, 4, 5]);
    assert_eq!(unit.flags(), 1 << 6, "a row past the table");

    for (log2, segments) in [(2, 1), (3, 3), (3, 0)] {
        let mut unit = Unit::of("", log2, segments);
        unit.rows(&[1, 2, 3, 4]);
        unit.rit(&entry(even()));
        assert_eq!(
            unit.flags() & 1 << 7,
            1 << 7,
            "{log2} {segments}: bad setting"
        );
    }
}

/// What a unit goes through before.
type Before<'a> = &'a dyn Fn(&mut Unit);

/// Settings may change while `idle` is high; a change at any other time raises bit 8.
#[test]
fn a_setting_that_moves_while_the_unit_works_is_flagged() {
    let moved = |name: &str, value: u64, when: Before<'_>| {
        let mut unit = Unit::of("", 3, 1);
        when(&mut unit);
        unit.set(name, value);
        unit.run.clock().unwrap();
        unit.run.clock().unwrap();
        unit.get("stat_errors") & 1 << 8
    };
    let whole = |unit: &mut Unit| {
        unit.rows(&[1, 2, 3, 4]);
        unit.rit(&entry(even()));
        assert_eq!(unit.get("idle"), 1);
    };
    let cases: [(&str, Before<'_>, u64); 5] = [
        ("nothing received", &|_| (), 0),
        ("all is done", &whole, 0),
        ("a row received", &|unit| unit.rows(&[1]), 1 << 8),
        ("entries wait", &|unit| unit.rit(&entry(even())), 1 << 8),
        (
            "a result waits",
            &|unit| {
                unit.set("m_axis_feat_tready", 0);
                unit.rows(&[1, 2, 3, 4]);
                unit.rit(&entry(even()));
            },
            1 << 8,
        ),
    ];
    for (what, when, flag) in cases {
        for (name, value) in [("cfg_vertices", 1), ("cfg_segments", 2)] {
            assert_eq!(moved(name, value, when), flag, "{name}, {what}");
        }
    }
}

/// `cfg_clear` in the middle of a job touches counters and flags alone.
#[test]
fn clearing_in_the_middle_changes_no_beat() {
    let beats = |clear: Option<u64>| {
        let mut unit = Unit::of("", 3, 1);
        unit.rows(&[1, 2, 3, 4]);
        unit.set("s_axis_rit_tvalid", 1);
        for (data, keep, last) in entry(even()) {
            unit.set("s_axis_rit_tdata", data);
            unit.set("s_axis_rit_tkeep", keep);
            unit.set("s_axis_rit_tlast", u64::from(last));
            unit.run.clock().unwrap();
        }
        unit.set("s_axis_rit_tvalid", 0);
        let mut found = vec![];
        for cycle in 0..40 {
            unit.set("cfg_clear", u64::from(clear == Some(cycle)));
            let ports = ["m_axis_feat_tvalid", "m_axis_feat_tdata", "idle"];
            found.push(ports.map(|name| unit.get(name)));
            unit.run.clock().unwrap();
        }
        assert!(found.iter().any(|[valid, ..]| *valid == 1));
        found
    };
    for cycle in 0..30 {
        assert_eq!(beats(Some(cycle)), beats(None), "cleared in cycle {cycle}");
    }
}

impl Unit {
    /// Sends beats with so many clocks before each, and then waits; gives (`tkeep`, `tlast`)
    /// of every beat that comes back.
    fn play(&mut self, beats: &[(Beat, u64)]) -> Vec<(u64, u64)> {
        let mut found = vec![];
        let mut clock = |unit: &mut Self| {
            if unit.get("m_axis_feat_tvalid") == 1 {
                found.push((unit.get("m_axis_feat_tkeep"), unit.get("m_axis_feat_tlast")));
            }
            unit.run.clock().unwrap();
        };
        for ((data, keep, last), gap) in beats {
            (0..*gap).for_each(|_| clock(self));
            self.set("s_axis_rit_tvalid", 1);
            self.set("s_axis_rit_tdata", *data);
            self.set("s_axis_rit_tkeep", *keep);
            self.set("s_axis_rit_tlast", u64::from(*last));
            assert_eq!(self.get("s_axis_rit_tready"), 1);
            clock(self);
            self.set("s_axis_rit_tvalid", 0);
        }
        (0..60).for_each(|_| clock(self));
        found
    }
}

/// The groups before may have been issued or not: the features end with a beat of
/// their own, the table is let go of, and the next MVoxel finds it.
#[test]
fn a_bare_last_beat_ends_its_mvoxel_after_any_gap() {
    let bare = (u64::MAX, 0, true);
    // Two single ids fill a beat, an entry of eight vertices six.
    let ids = vec![(2 << 32 | 1, FULL, false)];
    let mut cell = entry(even());
    cell[5].2 = false;
    let one_port: &[&[(u64, u64)]] = &[&[(3, 0), (3, 0), (0, 1)], &[(3, 0), (0, 1)]];
    // A group of two that is only begun ends the features itself.
    let two_ports: &[&[(u64, u64)]] = &[&[(15, 0), (0, 1)], &[(3, 1)]];
    for (ports, wanted) in [(1, one_port), (2, two_ports)] {
        let text = UNIT.replace("ports = 1", &format!("ports = {ports}"));
        let text = text.replace("[rit]\n", "[rit]\nstream_bits = 64\n");
        let module = gathering_unit(&Config::from_toml(&text, "test").unwrap()).unwrap();
        for ((log2, beats), wanted) in [(0, &ids), (3, &cell)].into_iter().zip(wanted) {
            for gap in 0..24 {
                let mut unit = Unit::new(&module, log2, 1);
                let mut sent: Vec<_> = beats.iter().map(|beat| (*beat, 0)).collect();
                sent.push((bare, gap));
                for mvoxel in 0..3 {
                    unit.rows(&[1, 2, 3, 4]);
                    let found = unit.play(&sent);
                    let label = format!("{ports} ports, {log2}, gap {gap}, MVoxel {mvoxel}");
                    assert_eq!(found, *wanted, "{label}");
                }
                assert_eq!(unit.flags(), 0);
            }
        }
    }
}

/// Wherever bare beats stand and whatever they say: the same features.
#[test]
fn bare_beats_within_an_mvoxel_are_none() {
    let beats = entry(even());
    let mut unit = Unit::of("", 3, 1);
    unit.rows(&[1, 2, 3, 4]);
    let bare = ((u64::MAX, 0, false), 1);
    let sent: Vec<_> = beats.iter().flat_map(|b| [bare, bare, (*b, 0)]).collect();
    assert_eq!(unit.play(&sent), [(3, 1)]);
    assert_eq!(unit.get("stat_entries"), 1);
    assert_eq!(unit.flags(), 0);
}

/// Halfway through an entry, and before any.
#[test]
fn a_bare_last_beat_behind_no_whole_entry_is_flagged() {
    let bare = ((0, 0, true), 0);
    for beats in [&entry(even())[..3], &[]] {
        let mut unit = Unit::of("", 3, 1);
        unit.rows(&[1, 2, 3, 4]);
        let mut sent: Vec<_> = beats.iter().map(|beat| (*beat, 0)).collect();
        sent.push(bare);
        unit.play(&sent);
        assert_eq!(unit.flags() & !0b111, 1 << 3, "{} beats", beats.len());
    }
}

/// An MVoxel is streamed once for every segment, or not.
#[test]
fn a_tuser_that_changes_within_an_mvoxel_is_flagged() {
    for turns_at in 0..7 {
        let mut unit = Unit::of("", 3, 1);
        unit.rows(&[1, 2, 3, 4]);
        for (at, beat) in entry(even()).into_iter().enumerate() {
            unit.set("s_axis_rit_tuser", u64::from(at >= turns_at));
            unit.set("s_axis_rit_tvalid", 1);
            unit.set("s_axis_rit_tdata", beat.0);
            unit.set("s_axis_rit_tkeep", beat.1);
            unit.set("s_axis_rit_tlast", u64::from(beat.2));
            unit.run.clock().unwrap();
        }
        unit.set("s_axis_rit_tvalid", 0);
        let turns = (1..6).contains(&turns_at);
        assert_eq!(unit.flags(), u64::from(turns) << 4, "{turns_at}");
    }
}

/// In every clock of a reset, the first one included, and before any clock.
#[test]
fn no_stream_is_ready_in_reset() {
    let module = gathering_unit(&Config::from_toml(UNIT, "test").unwrap()).unwrap();
    let mut unit = Unit::new(&module, 3, 1);
    for reset in [1, 0, 0, 1] {
        unit.set("rst_n", reset);
        for stream in ["rit", "mft"] {
            assert_eq!(unit.get(&format!("s_axis_{stream}_tready")), reset);
        }
        unit.run.clock().unwrap();
    }
    let mut fresh = Unit {
        run: Interpreter::new(&module, 5),
    };
    for stream in ["rit", "mft"] {
        assert_eq!(fresh.get(&format!("s_axis_{stream}_tready")), 0);
    }
}

/// Untrusted weights need not sum to one.
#[test]
fn any_weights_raise_no_sum_flag() {
    let mut unit = Unit::of("weights = \"any\"", 3, 1);
    unit.rows(&[1, 2, 3, 4]);
    let mut vertices = even();
    vertices[7].1 = 33;
    unit.rit(&entry(vertices));
    assert_eq!(unit.flags(), 0);
}

/// More entries than both halves hold must be streamed once a segment.
#[test]
fn an_mvoxel_too_large_to_keep_raises_its_flag() {
    for (entries, segments, flag) in [(17, 2, 1 << 5), (16, 2, 0), (17, 1, 0)] {
        let mut unit = Unit::of("", 3, segments);
        for _ in 0..2 {
            unit.rows(&[1, 2, 3, 4]);
        }
        let mut beats: Vec<Beat> = (0..entries).flat_map(|_| entry(even())).collect();
        let last = beats.len() - 1;
        for (i, beat) in beats.iter_mut().enumerate() {
            beat.2 = i == last;
        }
        unit.set("s_axis_rit_tvalid", 1);
        for (data, keep, last) in beats {
            unit.set("s_axis_rit_tdata", data);
            unit.set("s_axis_rit_tkeep", keep);
            unit.set("s_axis_rit_tlast", u64::from(last));
            // Such an MVoxel is never let go of: do not wait for ever.
            for _ in 0..300 {
                if unit.get("s_axis_rit_tready") == 1 {
                    break;
                }
                unit.run.clock().unwrap();
            }
            unit.run.clock().unwrap();
        }
        unit.set("s_axis_rit_tvalid", 0);
        for _ in 0..300 {
            unit.run.clock().unwrap();
        }
        assert_eq!(
            unit.get("stat_errors"),
            flag,
            "{entries} entries, {segments}"
        );
    }
}

/// A counter of 24 bits would take minutes: its end is forced near instead.
#[test]
fn counters_stop_at_their_maximum() {
    let config = Config::from_toml(UNIT, "test").unwrap();
    let module = gathering_unit(&config).unwrap();
    let near = Fault {
        module: module.name().to_owned(),
        register: "stat_busy".to_owned(),
        change: Change::Reset(((1 << 24) - 5).into()),
    };
    let mut unit = Unit::new(&near.inject(&module).unwrap(), 3, 1);
    unit.rows(&[1, 2, 3, 4]);
    unit.rit(&entry(even()));
    assert_eq!(unit.get("stat_busy"), (1 << 24) - 1);
}

/// A cell of an MVoxel of 2 x 2 x 2 vertices in a compact entry: fractions, row of
/// its first vertex.
fn compact(fraction: [u64; 3], row: u64) -> Vec<Beat> {
    let [x, y, z] = fraction;
    vec![(7 << 48 | z << 35 | y << 22 | x << 9 | row, FULL, true)]
}

const CELLS: &str = "[gu]\nbanks = 1\nports = 1\nvertices = [8, 4, 2]\n[rit]\nentry = \"compact\"\n\
    entries = 8\n[mvoxel]\nrows = 8\n";

#[test]
fn a_compact_cell_beyond_the_mvoxel_is_no_loaded_row() {
    let module = gathering_unit(&Config::from_toml(CELLS, "test").unwrap()).unwrap();
    for (log2, rows) in [(3, [0, 1, 2, 4]), (2, [0, 3, 5, 7])] {
        for row in rows {
            let mut unit = Unit::new(&module, log2, 1);
            unit.rows(&[100; 8]);
            unit.rit(&compact([1000, 2000, 0], row));
            // The first row alone has neighbours along all axes: 2 x 2 x 2, and of
            // planes 4 x 2.
            let beyond = match log2 {
                3 => row != 0,
                _ => row >= 3,
            };
            assert_eq!(unit.flags() & 1, u64::from(beyond), "{log2} {row}");
        }
    }
}

/// Where the next rows of the table are loaded too, only the faces tell.
#[test]
fn a_cell_at_a_face_is_beyond_it_whatever_is_loaded() {
    let text = CELLS.replace("rows = 8", "rows = 64");
    let module = gathering_unit(&Config::from_toml(&text, "test").unwrap()).unwrap();
    for row in 0..64 {
        // 64 vertices of a line, 8 x 8 of a plane, 4 x 4 x 4 of a volume.
        let (plane, cube) = ([row % 8, row / 8], [row % 4, row / 4 % 4, row / 16]);
        for (log2, beyond) in [
            (1, row == 63),
            (2, plane.contains(&7)),
            (3, cube.contains(&3)),
        ] {
            let mut unit = Unit::new(&module, log2, 1);
            unit.rows(&[100; 64]);
            unit.rit(&compact([1000, 2000, 3000], row));
            assert_eq!(unit.flags() & 1, u64::from(beyond), "{log2} {row}");
        }
    }
}

/// The same of whole cells.
#[test]
fn a_whole_cell_at_a_face_is_beyond_it() {
    let text = "[gu]\norganisation = \"parity\"\nbanks = 8\nports = 1\nmodes = \"structured\"\n\
        vertices = [8]\n[rit]\nentry = \"compact\"\nentries = 8\n[mvoxel]\nrows = 64\n";
    let module = gathering_unit(&Config::from_toml(text, "test").unwrap()).unwrap();
    for row in 0..64 {
        let mut unit = Unit::new(&module, 3, 1);
        let data = unit.run.port("s_axis_mft_tdata").unwrap();
        unit.run.set_words(data, &[5; 4]).unwrap();
        unit.set("s_axis_mft_tvalid", 1);
        for block in 0..8 {
            unit.set("s_axis_mft_tlast", u64::from(block == 7));
            unit.run.clock().unwrap();
        }
        unit.set("s_axis_mft_tvalid", 0);
        unit.rit(&compact([1000, 2000, 3000], row));
        let beyond = [row % 4, row / 4 % 4, row / 16].contains(&3);
        assert_eq!(unit.flags() & 1, u64::from(beyond), "{row}");
    }
}

/// An id of two records a row is a row, the bit that picks a record, and nothing
/// above.
#[test]
fn ids_of_two_records_a_row_end_with_the_bit_that_picks() {
    let text = "[gu]\nbanks = 2\nports = 1\nmodes = \"unstructured\"\nrecords_a_row = 2\n\
        [rit]\nentries = 8\n[mvoxel]\nrows = 8\n";
    let module = gathering_unit(&Config::from_toml(text, "test").unwrap()).unwrap();
    for (two, id, beyond) in [
        (1, 7, false),
        (1, 8 | 7, false),
        (1, 16, true),
        (1, 1 << 15, true),
        (0, 7, false),
        (0, 8, true),
    ] {
        let mut unit = Unit::new(&module, 0, 1);
        unit.set("cfg_two_records", two);
        unit.rows(&[0x0001_0002; 8]);
        unit.rit(&[(7 << 16 | id, 0x0f, true)]);
        assert_eq!(unit.flags() & 1, u64::from(beyond), "{two} {id}");
    }
}

/// Four single ids of which ports 2 and 3 wait for a turn: an id that was not loaded is
/// told whichever turn it has, and the stalls are counted and cleared.
#[test]
fn an_id_that_was_not_loaded_is_told_in_every_turn() {
    let text = "[gu]\nbanks = 1\nports = 4\nextra_ports = \"split\"\nmodes = \"unstructured\"\n\
        [rit]\nentries = 8\nstream_bits = 64\n[mvoxel]\nrows = 8\n";
    let module = gathering_unit(&Config::from_toml(text, "test").unwrap()).unwrap();
    for wrong in 0..5 {
        let mut unit = Unit::new(&module, 0, 1);
        unit.rows(&[1, 2, 3, 4, 5, 6, 7]);
        // Rows 0, 2, 4 and 6 lie in one part; row 7 is not there, in the other.
        let id = |port: u64| if port == wrong { 7 } else { 2 * port };
        let beat = |low: u64, last| (id(low) | id(low + 1) << 32, FULL, last);
        let last = |low: u64| (2 * (low % 2) + 1) | ((2 * (low % 2) + 2) << 32);
        unit.rit(&[
            beat(0, false),
            beat(2, false),
            (last(0), FULL, false),
            (last(1), FULL, true),
        ]);
        // Four rows of a part, or three of it: one more turn. Then two of each.
        assert_eq!(unit.get("stat_stall_bank"), 1, "port {wrong}");
        assert_eq!((unit.get("stat_entries"), unit.get("stat_busy")), (8, 2));
        assert_eq!(unit.flags(), u64::from(wrong < 4), "port {wrong}");
        assert_eq!(unit.get("stat_stall_bank"), 0, "cleared");
    }
}

/// Fractions above 1 count as 1, and those of axes that an entry lacks not at all:
/// a constant comes back as it is.
#[test]
fn compact_weights_sum_to_one_whatever_the_bits() {
    let module = gathering_unit(&Config::from_toml(CELLS, "test").unwrap()).unwrap();
    for log2 in [1, 2, 3] {
        for fraction in [[0; 3], [1, 4095, 77], [8191, 5000, 4097], [4096, 0, 8191]] {
            let mut unit = Unit::new(&module, log2, 1);
            unit.set("m_axis_feat_tready", 0);
            unit.rows(&[0x7ffe; 8]);
            unit.rit(&compact(fraction, 0));
            assert_eq!(unit.get("m_axis_feat_tvalid"), 1);
            assert_eq!(unit.get("m_axis_feat_tdata"), 0x7ffe, "{log2} {fraction:?}");
        }
    }
}

/// Ids whose parities are not their place's name no loaded row.
#[test]
fn a_vertex_of_another_parity_is_no_loaded_row() {
    let text = "[gu]\norganisation = \"parity\"\nbanks = 8\nports = 1\nmodes = \"structured\"\n\
        vertices = [8]\nweight_bits = 8\n[rit]\nentries = 8\n[mvoxel]\nrows = 8\n";
    let module = gathering_unit(&Config::from_toml(text, "test").unwrap()).unwrap();
    let cell: [(u64, u64); 8] = std::array::from_fn(|v| (v as u64, 32));
    for swapped in [false, true] {
        let mut unit = Unit::new(&module, 3, 1);
        let data = unit.run.port("s_axis_mft_tdata").unwrap();
        unit.run.set_words(data, &[5; 4]).unwrap();
        unit.set("s_axis_mft_tvalid", 1);
        unit.set("s_axis_mft_tlast", 1);
        unit.run.clock().unwrap();
        unit.set("s_axis_mft_tvalid", 0);
        let mut vertices = cell;
        if swapped {
            vertices.swap(1, 2);
        }
        unit.rit(&entry(vertices));
        assert_eq!(unit.flags(), u64::from(swapped));
    }
}

/// Of exact sums a part may weigh less than 1, and never more.
#[test]
fn parts_of_cells_may_weigh_less_than_one() {
    for (weight, flags) in [(31, 0), (32, 0), (33, 1 << 2)] {
        let mut unit = Unit::of("sums = \"exact\"", 3, 1);
        unit.rows(&[1, 2, 3, 4]);
        unit.rit(&entry([(0, weight); 8]));
        assert_eq!(unit.flags(), flags, "{weight}");
    }
}
