//! Rows that no MVoxel loaded, by every way to name one.

use potamoi_formats::config::Config;
use potamoi_units::gathering_unit::gathering_unit;

use super::{CELLS, FULL, Unit, compact, entry};

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
