//! The RIT buffer: double buffered, a row wide, so that M entries or ids are read in one cycle.
//!
//! A row holds M eight-vertex entries, which are 24 M halfwords. A beat of the stream is a part of a
//! row for every entry size, so the write side needs no shifter: a row is a memory for each beat of
//! it, and beat `k` of a row is a word of memory `k`.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{Feed, IrErrors, Module, ModuleBuilder, Ty};

use super::checks::rit_buffer_checks;
use super::reader_data::stage_data;
use crate::gathering_unit::shared::rit_reader::Reader;
use crate::gathering_unit::shared::rit_shape::{Halves, Shape};
use crate::gathering_unit::shared::rit_writer::Writer;
use crate::memory::{Size, ram_1r1w};

/// Builds `rit_buffer`.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub(crate) fn rit_buffer(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let shape = Shape::of(config);
    let beat_bits = 16 * shape.lanes;
    let size = Size {
        words: shape.depth(),
        bits: beat_bits,
    };
    let bank = ram_1r1w("rit_bank", size)?;
    let mut builder = ModuleBuilder::new("rit_buffer");
    let m = &mut builder;
    let taken = match (shape.whole_cells, shape.compact) {
        (false, false) => {
            "Takes packed entries, gives one vertex of M entries a cycle. A row of the banks holds M \
             eight-vertex entries, two of four, four of two vertices, or 12 M single ids."
        }
        (false, true) => {
            "Takes compact entries, gives one vertex of M entries a cycle. A row of the banks holds \
             6 M entries, or 12 M single ids."
        }
        (true, false) => {
            "Takes packed entries, gives all eight vertices of M entries a cycle. A row of the banks \
             holds M entries."
        }
        (true, true) => {
            "Takes compact entries, gives all eight vertices of M entries a cycle. A row of the banks \
             holds 6 M entries."
        }
    };
    m.doc(&format!("double-buffered ray index table. {taken}"));
    let bit = Ty::bit();
    let vertices = m.input("cfg_vertices", Ty::u(2), "log2 of the vertices an entry");
    if shape.vertices.len() == 1 {
        m.unused(vertices, "One entry size is built.");
    }
    let segments = m.input("cfg_segments", Ty::u(7), "channel segments, 1 and up");
    let writer = Writer {
        valid: m.input("s_axis_rit_tvalid", bit, ""),
        data: m.input(
            "s_axis_rit_tdata",
            Ty::u(beat_bits),
            "packed entries, little-endian",
        ),
        keep: m.input(
            "s_axis_rit_tkeep",
            Ty::u(shape.lanes * 2),
            "bytes that belong to the MVoxel",
        ),
        last: m.input("s_axis_rit_tlast", bit, "ends the MVoxel"),
        user: m.input("s_axis_rit_tuser", bit, "streamed once for every segment"),
    };
    let take = m.input("p_take", bit, "the vertex in P is issued");

    m.section(
        "Each half, as the writer leaves it: what lies before (end_row, end_group) can be read",
    );
    let halves = Halves::declare(m, &shape);

    m.section("Reader: the next vertex to read");
    let reader = Reader::declare(m, &shape);
    let read = reader.advance(m, &shape, &halves, vertices, segments, take);

    m.section("Writer");
    let write = writer.build(m, &shape, &halves, vertices, segments, read.release);

    m.section("Banks, one a beat of a row: read with vertex 0 of a group and held for the others");
    let inputs = [
        ("we", Feed::Each(write.enables)),
        ("waddr", Feed::Shared(write.address)),
        ("wdata", Feed::Shared(writer.data)),
        ("re", Feed::Shared(read.row_enable)),
        ("raddr", Feed::Shared(read.address)),
    ];
    let banks = m.array("bank", &bank, &[("beat", shape.phases)], &inputs);
    let row = m.all_out(banks, "rdata");

    m.section("Stages to P: row, weight and slot, picked or made, and registered");
    stage_data(&reader, m, &shape, &read, vertices, row);

    m.section("Stream and error outputs");
    let mut holds = halves.closed.to_vec();
    holds.push(write.amid);
    holds.extend(reader.stages().into_iter().map(|(_, stage)| stage.valid));
    let holds = m.any_of(&holds);
    let empty = m.not(holds);
    m.output("is_empty", empty, "nothing is received that is not issued");
    m.output("s_axis_rit_tready", write.ready, "");
    m.output(
        "errors",
        write.errors,
        "{too large to keep, bytes or tuser not as they must be, ragged entries}",
    );
    rit_buffer_checks(m, &shape, config.gu.segments);
    builder.finish()
}
