//! Stage E of compact RIT entries: a cell's first row, its slot and its three fractions.

use potamoi_formats::compact::{FRACTION_AT, FRACTION_BITS, ROW_BITS, SLOT_AT};
use potamoi_formats::rit::Vertices;
use potamoi_formats::timing::RitStage;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::rit_reader::{Read, Reader};
use super::rit_shape::Shape;
use super::rit_split::carry;
use crate::circuits::is;

/// Names of the axes.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];
/// Bit of a row that no MVoxel has; it marks the absence of a vertex.
pub(crate) const NO_ROW: u32 = 15;

/// Stage E of a port.
pub(crate) struct Entry {
    pub(crate) row: Signal,
    pub(crate) slot: Signal,
    /// Along x, y and z.
    pub(crate) fraction: [Signal; 3],
}

/// Stage E: the entry or the id of a port.
pub(crate) fn entry(
    reader: &Reader,
    m: &mut ModuleBuilder,
    shape: &Shape,
    read: &Read,
    vertices: Signal,
    words: &[Signal],
    port: u32,
) -> Entry {
    let q = reader.banks;
    let to_e = read.stages([RitStage::Entry]);
    let register =
        |m: &mut ModuleBuilder, name: &str, value: Signal| carry(m, port, &to_e, name, value);
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
        let single = is(m, vertices, 0);
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
