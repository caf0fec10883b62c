//! Compact RIT entries: rows and weights of a cell's vertices, made of its first
//! row and three fractions.
//!
//! A weight is made by splitting 1 along z, then y, then x: a sum `s` into
//! `s - h` and `h = floor(s u + 1/2)`, so that an entry's weights sum to exactly 1.
//! Stage E holds the entry, F the sums after y, P the weights; where pipelined, G and H
//! the products along y and x. One vertex a cycle takes one multiplier along y and one
//! along x; all eight take two and four.

use potamoi_formats::compact::{FRACTION_AT, FRACTION_BITS, ROW_BITS, SLOT_AT};
use potamoi_formats::rit::{MAX_VERTICES, Vertices};

use super::rit_pick::{Given, Slot};
use super::rit_reader::{Read, Reader, Step};
use super::rit_shape::Shape;
use super::rit_split::{Product, WeightStages, carry, first_split, is_one};
use crate::ir::{ModuleBuilder, Signal, Ty};

const AXES: [&str; 3] = ["x", "y", "z"];
/// Bit of a row that no MVoxel has: names no vertex.
const NO_ROW: u32 = 15;

/// Stage E of a port.
struct Entry {
    row: Signal,
    slot: Signal,
    /// Along x, y and z.
    fraction: [Signal; 3],
}

impl Reader {
    /// Rows, weights and slot of a port's compact entry.
    pub(super) fn of_cell(
        &self,
        m: &mut ModuleBuilder,
        shape: &Shape,
        read: &Read,
        vertices: Signal,
        words: &[Signal],
        port: u32,
    ) -> Given {
        let entry = self.entry(m, shape, read, vertices, words, port);
        let stages = WeightStages::of(read);
        let slot = carry(m, port, &stages.to_f, "slot", entry.slot);
        let slot = carry(m, port, &stages.to_p, "slot", slot);
        let across = carry(m, port, &stages.to_f, "fraction_x", entry.fraction[0]);
        let steps: Vec<Step> = self.steps().into_iter().flatten().collect();
        let (rows, weights) = match steps.is_empty() {
            true => cell(m, shape, &stages, &entry, across, port),
            false => {
                let of_y = 1 + stages.of_y().len();
                let row = row_of_vertex(m, shape, &entry, steps[1].vertex, vertices, port);
                let row = carry(m, port, &stages.to_f, "row", row);
                let row = carry(m, port, &stages.to_p, "row", row);
                let steps = [steps[steps.len() - 2], steps[of_y], steps[1]];
                let weight = weight(m, shape, &stages, &entry, (across, steps), port);
                (vec![row], vec![weight])
            }
        };
        let weights = weights.into_iter().map(|w| halfword(m, w)).collect();
        Given {
            rows,
            weights,
            slot: Slot::Whole(slot),
        }
    }

    /// Stage E: the entry or the id of a port.
    fn entry(
        &self,
        m: &mut ModuleBuilder,
        shape: &Shape,
        read: &Read,
        vertices: Signal,
        words: &[Signal],
        port: u32,
    ) -> Entry {
        let q = self.stages()[0];
        let register = |m: &mut ModuleBuilder, name: &str, value: Signal| {
            let reg = m.reg(&format!("e_{name}{port}"), value.ty(), 0);
            m.set_next_if(reg, read.fills[0], value);
            reg
        };
        // The same halfwords whatever the number of vertices, but for single ids.
        let of_size = |m: &mut ModuleBuilder, v: Vertices| {
            let size = shape.entry_halfwords(v);
            let of_group: Vec<_> = (0..shape.groups(v))
                .map(|g| {
                    let at = ((g * shape.ports + port) * size) as usize;
                    let mut parts = words[at..at + size as usize].to_vec();
                    parts.reverse();
                    m.cat(&parts)
                })
                .collect();
            let picked = m.select(q.group, &of_group);
            let kind = if v.is_structured() { "entry" } else { "id" };
            m.name(picked, &format!("{kind}{port}"))
        };
        let cell = shape.vertices.iter().find(|v| v.is_structured());
        let word = match cell {
            Some(v) => of_size(m, *v),
            None => m.lit(0, Ty::u(64)),
        };
        let mut row = m.slice(word, 0, ROW_BITS);
        row = m.extend(row, 16);
        let mut slot = m.slice(word, SLOT_AT, 16);
        if shape.vertices.contains(&Vertices::One) {
            let id = of_size(m, Vertices::One);
            let single = crate::parts::is(m, vertices, 0);
            let (id_row, id_tag) = (m.slice(id, 0, 16), m.slice(id, 16, 16));
            row = m.mux(single, id_row, row);
            slot = m.mux(single, id_tag, slot);
        }
        let fraction = FRACTION_AT.map(|at| m.slice(word, at, FRACTION_BITS));
        // Axes that an entry lacks do not count, whatever their bits.
        let fraction = [0, 1, 2].map(|axis: usize| {
            let used = shape.by_vertices(m, vertices, |m, v| {
                m.lit(u32::from(v.log2() as usize > axis), Ty::bit())
            });
            let used = m.name(used, &format!("has_{}{port}", AXES[axis]));
            let mask = m.repeat(used, FRACTION_BITS);
            m.and(fraction[axis], mask)
        });
        let fraction = [0, 1, 2]
            .map(|axis: usize| register(m, &format!("fraction_{}", AXES[axis]), fraction[axis]));
        Entry {
            row: register(m, "row", row),
            slot: register(m, "slot", slot),
            fraction,
        }
    }
}

/// The weight of a vertex; of each axis, the step that says on which side it is.
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
    let product = product.carry(m, stages.of_y(), &along_y);
    let one = is_one(m, entry.fraction[1]);
    let one = carry(m, port, stages.of_y(), "one_y", one);
    let (low, high) = product.split(m, &along_y, one);
    let sum = m.mux(y, high, low);
    let sum = carry(m, port, stages.f(), "sum_y", sum);
    let along_x = format!("x{port}");
    let product = Product::of(m, &along_x, sum, across);
    let product = product.carry(m, &stages.to_p, &along_x);
    let one = is_one(m, across);
    let one = carry(m, port, &stages.to_p, "one_x", one);
    let (low, high) = product.split(m, &along_x, one);
    m.mux(x, high, low)
}

/// Rows and weights of all eight vertices.
fn cell(
    m: &mut ModuleBuilder,
    shape: &Shape,
    stages: &WeightStages,
    entry: &Entry,
    across: Signal,
    port: u32,
) -> (Vec<Signal>, Vec<Signal>) {
    let hold = |m: &mut ModuleBuilder, name: &str, value: Signal| {
        let value = carry(m, port, &stages.to_f, name, value);
        carry(m, port, &stages.to_p, name, value)
    };
    let odd = [0, 1, 2].map(|axis: u32| {
        let bit = m.bit(entry.row, axis * shape.axis_bits());
        m.name(bit, &format!("odd_{}{port}", AXES[axis as usize]))
    });
    let next = [0, 1, 2].map(|axis: u32| {
        let next = next_even(m, shape, entry.row, odd[axis as usize], axis);
        hold(m, &format!("next_{}", AXES[axis as usize]), next)
    });
    let bits = shape.axis_bits();
    let half = [0, 1, 2].map(|axis: u32| {
        (bits > 1).then(|| {
            let half = m.slice(entry.row, axis * bits + 1, bits - 1);
            hold(m, &format!("half_{}", AXES[axis as usize]), half)
        })
    });
    let above = (3 * bits < 16).then(|| {
        let above = m.slice(entry.row, 3 * bits, 16 - 3 * bits);
        hold(m, "above", above)
    });
    let rows = rows_of_groups(m, bits, half, above, next);
    // The side whose parity is 0 first.
    let by_parity = |m: &mut ModuleBuilder, name: &str, parts: (Signal, Signal), odd| {
        let (low, high) = parts;
        [("even", high, low), ("odd", low, high)].map(|(side, first, other)| {
            let part = m.mux(odd, first, other);
            m.name(part, &format!("{side}_part_{name}"))
        })
    };
    let name = |axis: &str, i: usize| format!("{axis}{port}_{i}");
    let first = first_split(m, shape, &format!("z{port}"), entry.fraction[2]);
    let mut sums = vec![];
    let along_z = by_parity(m, &format!("z{port}"), first, odd[2]);
    let odd_y = carry(m, port, stages.of_y(), "odd_y", odd[1]);
    let one = is_one(m, entry.fraction[1]);
    let one_y = carry(m, port, stages.of_y(), "one_y", one);
    for (i, sum) in along_z.into_iter().enumerate() {
        let product = Product::of(m, &name("y", i), sum, entry.fraction[1]);
        let product = product.carry(m, stages.of_y(), &name("y", i));
        let parts = product.split(m, &name("y", i), one_y);
        sums.extend(by_parity(m, &name("y", i), parts, odd_y));
    }
    let odd_x = hold(m, "odd_x", odd[0]);
    let one = is_one(m, across);
    let one_x = carry(m, port, &stages.to_p, "one_x", one);
    let mut weights = vec![];
    for (i, sum) in sums.into_iter().enumerate() {
        let sum = carry(m, port, stages.f(), &format!("sum{i}_"), sum);
        let product = Product::of(m, &name("x", i), sum, across);
        let product = product.carry(m, &stages.to_p, &name("x", i));
        let parts = product.split(m, &name("x", i), one_x);
        weights.extend(by_parity(m, &name("x", i), parts, odd_x));
    }
    (rows, weights)
}

/// The row of the vertex in E. Beyond the MVoxel's faces there is none.
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

/// A weight in 16 bits.
fn halfword(m: &mut ModuleBuilder, weight: Signal) -> Signal {
    m.extend(weight, 16)
}

/// Along an axis, the first vertex of even parity that is the cell's: its own first
/// one, or the next; half its place, and on top whether it is beyond the MVoxel.
fn next_even(
    m: &mut ModuleBuilder,
    shape: &Shape,
    first: Signal,
    odd: Signal,
    axis: u32,
) -> Signal {
    let bits = shape.axis_bits();
    if bits == 1 {
        return odd;
    }
    let half = m.slice(first, axis * bits + 1, bits - 1);
    let half = m.extend(half, bits);
    let step = m.extend(odd, bits);
    m.add(half, step)
}

/// The row that each group of banks gives: along an axis on which the group's
/// parity is odd half the first vertex's place, else that of the next even one.
fn rows_of_groups(
    m: &mut ModuleBuilder,
    bits: u32,
    half: [Option<Signal>; 3],
    above: Option<Signal>,
    next: [Signal; 3],
) -> Vec<Signal> {
    (0..MAX_VERTICES as u32)
        .map(|group| {
            let mut parts = vec![];
            let mut beyond = vec![];
            parts.extend(above);
            for axis in (0..3).rev() {
                let parity = group >> axis & 1;
                let even = next[axis as usize];
                if let Some(half) = half[axis as usize] {
                    parts.push(match parity {
                        0 => m.slice(even, 0, bits - 1),
                        _ => half,
                    });
                }
                parts.push(m.lit(parity, Ty::bit()));
                if parity == 0 {
                    beyond.push(m.bit(even, bits - 1));
                }
            }
            let row = m.cat(&parts);
            let outside = m.any_of(&beyond);
            let none = m.lit(0, Ty::u(NO_ROW));
            let flag = m.cat(&[outside, none]);
            m.or(row, flag)
        })
        .collect()
}
