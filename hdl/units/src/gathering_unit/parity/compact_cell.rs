//! Rows and weights of all eight vertices of a compact entry.

use potamoi_formats::rit::MAX_VERTICES;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use crate::gathering_unit::shared::compact_entry::{AXES, Entry, NO_ROW};
use crate::gathering_unit::shared::rit_shape::Shape;
use crate::gathering_unit::shared::rit_split::{Product, WeightStages, carry, first_split, is_one};

/// Rows and weights of all eight vertices.
pub(crate) fn cell(
    m: &mut ModuleBuilder,
    shape: &Shape,
    stages: &WeightStages,
    entry: &Entry,
    across: Signal,
    port: u32,
) -> (Vec<Signal>, Vec<Signal>) {
    let hold = |m: &mut ModuleBuilder, name: &str, value: Signal| {
        let value = carry(m, port, &stages.to_part_y, name, value);
        carry(m, port, &stages.product_x, name, value)
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
    let odd_y = carry(m, port, &stages.product_y, "odd_y", odd[1]);
    let one = is_one(m, entry.fraction[1]);
    let one_y = carry(m, port, &stages.product_y, "one_y", one);
    for (i, sum) in along_z.into_iter().enumerate() {
        let product = Product::of(m, &name("y", i), sum, entry.fraction[1]);
        let product = product.carry(m, &stages.product_y, &name("y", i));
        let parts = product.split(m, &name("y", i), one_y);
        sums.extend(by_parity(m, &name("y", i), parts, odd_y));
    }
    let odd_x = hold(m, "odd_x", odd[0]);
    let one = is_one(m, across);
    let one_x = carry(m, port, &stages.product_x, "one_x", one);
    let mut weights = vec![];
    for (i, sum) in sums.into_iter().enumerate() {
        let sum = carry(m, port, &stages.part_y, &format!("sum{i}_"), sum);
        let product = Product::of(m, &name("x", i), sum, across);
        let product = product.carry(m, &stages.product_x, &name("x", i));
        let parts = product.split(m, &name("x", i), one_x);
        weights.extend(by_parity(m, &name("x", i), parts, odd_x));
    }
    (rows, weights)
}

/// The cell's first vertex of even parity along an axis: its own first vertex, or the next. Returns
/// half its position; the top bit tells whether it is beyond the MVoxel.
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

/// Row read in each group of banks: along an axis with odd parity of the group, half the position
/// of the first vertex, otherwise that of the next even one.
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
