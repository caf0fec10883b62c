//! Data of the RIT reader's stages: rows, weights and slot of one vertex, or of all eight of a
//! cell.

use potamoi_formats::config::Config;
use potamoi_netlist::{Instance, ModuleBuilder, Signal, Ty};

use super::compact::of_compact;
use super::vertex::{ids, vertex};
use crate::circuits::is;
use crate::gathering_unit::parity::whole_entry::whole_entry;
use crate::gathering_unit::shared::rit_output::{HALF, Slot};
use crate::gathering_unit::shared::rit_reader::{Read, Reader};
use crate::gathering_unit::shared::rit_shape::Shape;

/// Weights of the issued entries; 0 where the unit supports single ids only.
pub(crate) fn weights(m: &mut ModuleBuilder, config: &Config, rit: Instance) -> Signal {
    let shape = Shape::of(config);
    if shape.has_weights() {
        return m.out(rit, "p_weight");
    }
    m.lit(0, Ty::u(16 * shape.ports))
}

/// Stages E to P of every port, and the outputs.
pub(super) fn stage_data(
    reader: &Reader,
    m: &mut ModuleBuilder,
    shape: &Shape,
    read: &Read,
    vertices: Signal,
    row: Signal,
) {
    let (before, p, fill) = (reader.before_issue(), reader.issue, read.fill_issue);
    // The vertices whose tags make the slot.
    let [vertex_0, vertex_1] = match before.step {
        None => [fill; 2],
        Some(step) => {
            let zero = m.and(fill, step.first);
            let is_one = is(m, step.vertex, 1);
            [m.name(zero, "p_fill_vertex_0"), m.and(fill, is_one)]
        }
    };
    let words: Vec<_> = match (shape.compact, shape.whole_cells) {
        (false, false) => vec![],
        _ => (0..shape.banks).map(|k| m.slice(row, 16 * k, 16)).collect(),
    };
    let ids = match (shape.compact, shape.whole_cells) {
        (false, false) => ids(reader, m, shape, vertices, row),
        _ => None,
    };
    let mut outputs: [Vec<Signal>; 3] = Default::default();
    for port in 0..shape.ports {
        let given = match (shape.compact, shape.whole_cells) {
            (true, _) => of_compact(reader, m, shape, read, vertices, &words, port),
            (false, true) => whole_entry(m, shape, read, &words, port),
            (false, false) => vertex(reader, m, shape, read, vertices, (row, ids), port),
        };
        let mut register = |name: &str, enable: Signal, value: Signal| {
            let reg = m.data_reg(name, HALF);
            m.set_next_if(reg, enable, value);
            reg
        };
        let weights = if shape.has_weights() {
            given.weights
        } else {
            vec![]
        };
        for (what, values) in [given.rows, weights].into_iter().enumerate() {
            let name = ["row", "weight"][what];
            for (i, value) in values.iter().enumerate() {
                let name = match values.len() {
                    1 => format!("p_{name}{port}"),
                    _ => format!("p_{name}{port}_{i}"),
                };
                outputs[what].insert(0, register(&name, fill, *value));
            }
        }
        match given.slot {
            Slot::Whole(slot) => {
                for i in 0..shape.slot_bits / 16 {
                    let part = m.slice(slot, 16 * i, 16);
                    let name = format!("p_{}{port}", ["tag", "high_tag"][i as usize]);
                    let reg = m.data_reg(&name, HALF);
                    m.set_next_if(reg, fill, part);
                    outputs[2].insert(0, reg);
                }
            }
            Slot::Tag(tag) => {
                outputs[2].insert(0, register(&format!("p_tag{port}"), vertex_0, tag));
                if shape.slot_bits == 32 {
                    let name = format!("p_high_tag{port}");
                    outputs[2].insert(0, register(&name, vertex_1, tag));
                }
            }
        }
    }
    m.output("p_valid", p.valid, "a vertex is offered");
    if let Some(step) = p.step {
        m.output("p_first", step.first, "vertex 0 of its group");
        m.output("p_last", step.last, "vertex V-1 of its group");
    }
    m.output("p_end", p.end, "last group of its MVoxel and segment");
    m.output("p_keep", p.keep, "ports that hold an entry");
    let one = match shape.at_once() {
        1 => "one a port",
        _ => "one a port and group of banks",
    };
    let slots = match shape.slot_bits {
        32 if !shape.whole_cells => "slots, complete with vertex 1",
        _ => "slots",
    };
    for (name, parts, doc) in [
        ("p_row", &outputs[0], one),
        ("p_weight", &outputs[1], one),
        ("p_slot", &outputs[2], slots),
    ] {
        if parts.is_empty() {
            continue;
        }
        let joined = m.cat(parts);
        m.output(name, joined, doc);
    }
}
