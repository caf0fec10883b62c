//! The gathering unit's flags and counters, by hand: each broken promise of the
//! streams raises its own bit, `cfg_clear` takes it back, counters stop at
//! their ends.

mod promises;
mod rit_stream;
mod rows;
mod settings;
mod weights;

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{Interpreter, Module};
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

/// A cell of an MVoxel of 2 x 2 x 2 vertices in a compact entry: fractions, row of
/// its first vertex.
fn compact(fraction: [u64; 3], row: u64) -> Vec<Beat> {
    let [x, y, z] = fraction;
    vec![(7 << 48 | z << 35 | y << 22 | x << 9 | row, FULL, true)]
}

const CELLS: &str = "[gu]\nbanks = 1\nports = 1\nvertices = [8, 4, 2]\n[rit]\nentry = \"compact\"\n\
    entries = 8\n[mvoxel]\nrows = 8\n";
