//! Entries of the paper's format with all eight vertices at once.

use potamoi_formats::rit::MAX_VERTICES;
use potamoi_formats::timing::RitStage;
use potamoi_netlist::{ModuleBuilder, Signal};

use crate::gathering_unit::shared::rit_output::{HALFWORDS, RitOutput, Slot};
use crate::gathering_unit::shared::rit_reader::Read;
use crate::gathering_unit::shared::rit_shape::Shape;
use crate::gathering_unit::shared::rit_split::carry_named;

/// Ids and weights of all vertices of an entry, each in the group of banks of its parities: where
/// the first vertex is odd along an axis, the two sides are swapped.
pub(crate) fn whole_entry(
    m: &mut ModuleBuilder,
    shape: &Shape,
    read: &Read,
    words: &[Signal],
    port: u32,
) -> RitOutput {
    let at = |v: u32, j: u32| words[(port * 24 + v * 3 + j) as usize];
    let to_e = read.stages([RitStage::Entry]);
    let mut held = |v: u32, j: u32| {
        let name = format!("{}{port}_{v}", HALFWORDS[j as usize]);
        carry_named(m, &to_e, &name, at(v, j))
    };
    let count = MAX_VERTICES as u32;
    let rows: Vec<_> = (0..count).map(|v| held(v, 0)).collect();
    let weights: Vec<_> = (0..count).map(|v| held(v, 2)).collect();
    let tags: Vec<_> = (0..shape.slot_bits / 16)
        .rev()
        .map(|v| held(v, 1))
        .collect();
    let slot = m.cat(&tags);
    let odd: Vec<_> = (0..3)
        .map(|axis| {
            let bit = m.bit(rows[0], axis * shape.axis_bits());
            m.name(
                bit,
                &format!("first{port}_odd_{}", ["x", "y", "z"][axis as usize]),
            )
        })
        .collect();
    let mut to_groups = |mut values: Vec<Signal>, what: &str| {
        for (axis, odd) in odd.iter().enumerate() {
            let swapped =
                |m: &mut ModuleBuilder, v: usize| m.mux(*odd, values[v ^ 1 << axis], values[v]);
            values = (0..values.len()).map(|v| swapped(m, v)).collect();
        }
        let named = values.into_iter().enumerate();
        named
            .map(|(g, s)| m.name(s, &format!("{what}{port}_group{g}")))
            .collect()
    };
    RitOutput {
        rows: to_groups(rows, "row"),
        weights: to_groups(weights, "weight"),
        slot: Slot::Whole(slot),
    }
}
