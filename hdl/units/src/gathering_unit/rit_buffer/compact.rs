//! Compact RIT entries: rows and weights of a cell's vertices, computed from its first row and
//! three fractions.
//!
//! A weight results from splitting 1 along z, then y, then x: a sum `s` becomes `s - h` and `h =
//! floor(s u + 1/2)`, so that an entry's weights sum to exactly 1. Stage E holds the entry, F the
//! sums after y, P the weights; where pipelined, G and H hold the products along y and x. One
//! vertex a cycle takes one multiplier along y and one along x; all eight take two and four.

use potamoi_formats::timing::RitStage;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use crate::gathering_unit::parity::compact_cell::cell;
use crate::gathering_unit::shared::compact_entry::{AXES, Entry, NO_ROW, entry};
use crate::gathering_unit::shared::rit_output::{RitOutput, Slot};
use crate::gathering_unit::shared::rit_reader::{Read, Reader, Step};
use crate::gathering_unit::shared::rit_shape::Shape;
use crate::gathering_unit::shared::rit_split::{Product, WeightStages, carry, first_split, is_one};

/// Rows, weights and slot of a port's compact entry.
pub(super) fn of_compact(
    reader: &Reader,
    m: &mut ModuleBuilder,
    shape: &Shape,
    read: &Read,
    vertices: Signal,
    words: &[Signal],
    port: u32,
) -> RitOutput {
    let entry = entry(reader, m, shape, read, vertices, words, port);
    let stages = WeightStages::of(read);
    let slot = carry(m, port, &stages.to_part_y, "slot", entry.slot);
    let slot = carry(m, port, &stages.product_x, "slot", slot);
    let across = carry(m, port, &stages.to_part_y, "fraction_x", entry.fraction[0]);
    // Where each axis' side is chosen; none where all eight vertices are made.
    let of_z = reader.step_at([RitStage::Entry]);
    let of_y = reader.step_at([RitStage::ProductY, RitStage::Entry]);
    let of_x = reader.step_at([RitStage::ProductX, RitStage::PartY]);
    let (rows, weights) = match (of_x, of_y, of_z) {
        (Some(x), Some(y), Some(z)) => {
            let row = row_of_vertex(m, shape, &entry, z.vertex, vertices, port);
            let row = carry(m, port, &stages.to_part_y, "row", row);
            let row = carry(m, port, &stages.product_x, "row", row);
            let weight = weight(m, shape, &stages, &entry, (across, [x, y, z]), port);
            (vec![row], vec![weight])
        }
        _ => cell(m, shape, &stages, &entry, across, port),
    };
    let weights = weights.into_iter().map(|w| halfword(m, w)).collect();
    RitOutput {
        rows,
        weights,
        slot: Slot::Whole(slot),
    }
}

/// Weight of a vertex; for each axis, the step tells its side.
fn weight(
    m: &mut ModuleBuilder,
    shape: &Shape,
    stages: &WeightStages,
    entry: &Entry,
    (across, steps): (Signal, [Step; 3]),
    port: u32,
) -> Signal {
    let [x, y, z] = [0, 1, 2].map(|axis: u32| {
        let bit = m.bit(steps[axis as usize].vertex, axis);
        m.name(bit, &format!("far_{}{port}", AXES[axis as usize]))
    });
    let (low, high) = first_split(m, shape, &format!("z{port}"), entry.fraction[2]);
    let sum = m.mux(z, high, low);
    let sum = m.name(sum, &format!("sum_z{port}"));
    let along_y = format!("y{port}");
    let product = Product::of(m, &along_y, sum, entry.fraction[1]);
    let product = product.carry(m, &stages.product_y, &along_y);
    let one = is_one(m, entry.fraction[1]);
    let one = carry(m, port, &stages.product_y, "one_y", one);
    let (low, high) = product.split(m, &along_y, one);
    let sum = m.mux(y, high, low);
    let sum = carry(m, port, &stages.part_y, "sum_y", sum);
    let along_x = format!("x{port}");
    let product = Product::of(m, &along_x, sum, across);
    let product = product.carry(m, &stages.product_x, &along_x);
    let one = is_one(m, across);
    let one = carry(m, port, &stages.product_x, "one_x", one);
    let (low, high) = product.split(m, &along_x, one);
    m.mux(x, high, low)
}

/// Row of the vertex in E; no row beyond the MVoxel's faces.
fn row_of_vertex(
    m: &mut ModuleBuilder,
    shape: &Shape,
    entry: &Entry,
    vertex: Signal,
    vertices: Signal,
    port: u32,
) -> Signal {
    let ty = entry.row.ty();
    let offset = shape.by_vertices(m, vertices, |m, v| {
        let offsets = shape.offsets(v);
        let options: Vec<_> = offsets[..v.count()].iter().map(|o| m.lit(*o, ty)).collect();
        let offset = m.select(vertex, &options);
        m.name(offset, &format!("offset{port}_v{}", v.count()))
    });
    let offset = m.name(offset, &format!("offset{port}"));
    let outside = shape.by_vertices(m, vertices, |m, v| {
        let mut beyond = vec![];
        let mut low = 0;
        for (axis, bits) in (0..).zip(shape.row_fields(v)) {
            let field = m.slice(entry.row, low, bits);
            let top = m.all(field);
            let far = m.bit(vertex, axis);
            beyond.push(m.and(top, far));
            low += bits;
        }
        m.any_of(&beyond)
    });
    let outside = m.name(outside, &format!("outside{port}"));
    let row = m.add(entry.row, offset);
    let none = m.lit(0, Ty::u(NO_ROW));
    let flag = m.cat(&[outside, none]);
    m.or(row, flag)
}

/// A weight, extended to 16 bits.
fn halfword(m: &mut ModuleBuilder, weight: Signal) -> Signal {
    m.extend(weight, 16)
}
