//! The RIT buffer: double buffered, in banks of 16 bits, so that M entries or
//! ids are read in one cycle.
//!
//! A row holds M eight-vertex entries, 24 M halfwords, one a bank. Whatever
//! the entry size, a beat of the stream fills whole banks of one row, so the
//! write side needs no shifter: bank `k` always takes lane `k mod lanes`.

use std::sync::Arc;

use potamoi_formats::config::{Config, RitConfig};
use potamoi_formats::rit::Vertices;

use super::ram;
use crate::ir::{IrErrors, Module, ModuleBuilder, Signal, Ty};
use crate::parts::{popcount, select_by};

/// Geometry of the buffer that both of its sides share.
struct Shape {
    ports: u32,
    banks: u32,
    lanes: u32,
    phases: u32,
    rows: u32,
    row_bits: u32,
    vertices: Vec<Vertices>,
}

impl Shape {
    fn of(config: &Config) -> Self {
        let banks = config.rit_row_bits() / 16;
        let lanes = config.rit_stream_bits() / 16;
        let rows = config.rit_rows();
        Self {
            ports: config.gu.ports,
            banks,
            lanes,
            phases: banks / lanes,
            rows,
            row_bits: bits_for(rows),
            vertices: config.supported_vertices(),
        }
    }

    fn entry_halfwords(vertices: Vertices) -> u32 {
        (vertices.entry_bytes() / 2) as u32
    }

    /// Groups of M entries in a row.
    fn groups(&self, vertices: Vertices) -> u32 {
        self.banks / (self.ports * Self::entry_halfwords(vertices))
    }

    fn most_groups(&self) -> u32 {
        self.vertices.iter().map(|v| self.groups(*v)).max().unwrap_or(1)
    }
}

/// Bits that hold 0..=n.
fn bits_for(n: u32) -> u32 {
    n.ilog2() + 1
}

/// What the writer tells the reader about each half.
struct Halves {
    closed: [Signal; 2],
    row: [Signal; 2],
    group: [Signal; 2],
    last: [Signal; 2],
    streamed: [Signal; 2],
    keep: [Signal; 2],
}

/// Builds `rit_buffer`.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub fn rit_buffer(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let shape = Shape::of(config);
    let mut m = ModuleBuilder::new("rit_buffer");
    m.doc("Double-buffered ray index table. Takes packed entries, gives one vertex of M entries a cycle.");
    let m = &mut m;
    let bit = Ty::bit();
    let vertices = m.input("cfg_vertices", Ty::u(2), "log2 of the vertices an entry");
    let segments = m.input("cfg_segments", Ty::u(7), "channel segments, 1 and up");
    let tvalid = m.input("s_axis_rit_tvalid", bit, "");
    let tdata = m.input("s_axis_rit_tdata", Ty::u(shape.lanes * 16), "packed entries, little-endian");
    let tkeep = m.input("s_axis_rit_tkeep", Ty::u(shape.lanes * 2), "bytes that belong to the MVoxel");
    let tlast = m.input("s_axis_rit_tlast", bit, "ends the MVoxel");
    let tuser = m.input("s_axis_rit_tuser", bit, "streamed once for every segment");
    let take = m.input("p_take", bit, "the vertex in P is issued");

    m.section("State of each half");
    let place = Ty::u(shape.row_bits);
    let group_ty = Ty::u(bits_for(shape.most_groups()));
    let pair = |m: &mut ModuleBuilder, name: &str, ty: Ty| [0, 1].map(|h| m.reg(&format!("{name}_{h}"), ty, 0));
    let halves = Halves {
        closed: pair(m, "closed", bit),
        row: pair(m, "end_row", place),
        group: pair(m, "end_group", group_ty),
        last: pair(m, "ends_mvoxel", bit),
        streamed: pair(m, "streamed", bit),
        keep: pair(m, "last_keep", Ty::u(shape.ports)),
    };

    m.section("Reader: position");
    let reader = Reader::declare(m, &shape, group_ty);
    let release = reader.build(m, &shape, &halves, vertices, segments, take);

    m.section("Writer");
    let write = Writer { tvalid, tdata, tkeep, tlast, tuser };
    let errors = write.build(m, &shape, &halves, vertices, segments, &release, &reader, &config.rit)?;
    m.output("errors", errors, "ragged entries, bytes missing, MVoxel too large to keep");
    std::mem::replace(m, ModuleBuilder::new("done")).finish()
}
