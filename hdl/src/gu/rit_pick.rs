//! What the stages of the RIT reader carry: rows, weights and slot of a vertex, or
//! of all eight of a cell, picked from the paper's entries.

use potamoi_formats::config::Config;
use potamoi_formats::rit::{MAX_VERTICES, Vertices};

use super::rit_reader::{Read, Reader};
use super::rit_shape::Shape;
use crate::ir::{Instance, ModuleBuilder, Signal, Ty};
use crate::parts::is;

/// Names of the halfwords of an entry's word.
const HALFWORDS: [&str; 3] = ["row", "tag", "weight"];
/// Bits of a halfword.
const HALF: Ty = Ty::u(16);

/// What is issued of one port's entry: one row and weight, or one for each group
/// of banks.
pub(super) struct Given {
    pub(super) rows: Vec<Signal>,
    pub(super) weights: Vec<Signal>,
    pub(super) slot: Slot,
}

/// Where a slot comes from.
pub(super) enum Slot {
    /// With every vertex, whole.
    Whole(Signal),
    /// In the tags of vertices 0 and 1.
    Tag(Signal),
}

/// Weights of what is issued; zeros where no entry has any.
pub(super) fn weights(m: &mut ModuleBuilder, config: &Config, rit: Instance) -> Signal {
    let shape = Shape::of(config);
    if shape.has_weights() {
        return m.out(rit, "p_weight");
    }
    m.lit(0, Ty::u(16 * shape.ports))
}

impl Reader {
    /// Stages E to P of every port, and the outputs.
    pub(super) fn give(
        &self,
        m: &mut ModuleBuilder,
        shape: &Shape,
        read: &Read,
        vertices: Signal,
        words: &[Signal],
    ) {
        let stages = self.stages();
        let last = stages.len() - 1;
        let (before, p, fill) = (stages[last - 1], stages[last], read.fills[last - 1]);
        // The vertices whose tags make the slot.
        let [vertex_0, vertex_1] = match before.step {
            None => [fill; 2],
            Some(step) => {
                let zero = m.and(fill, step.first);
                let is_one = is(m, step.vertex, 1);
                [m.name(zero, "p_fill_vertex_0"), m.and(fill, is_one)]
            }
        };
        let mut outputs: [Vec<Signal>; 3] = Default::default();
        for port in 0..shape.ports {
            let given = match (shape.compact, shape.whole_cells) {
                (true, _) => self.of_cell(m, shape, read, vertices, words, port),
                (false, true) => self.whole_entry(m, shape, read, words, port),
                (false, false) => self.vertex(m, shape, read, vertices, words, port),
            };
            let mut register = |name: &str, enable: Signal, value: Signal| {
                let reg = m.reg(name, HALF, 0);
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
                        let reg = m.reg(&name, HALF, 0);
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

    /// Halfword `j` of an entry's word in Q, for one entry size.
    fn halfword(
        &self,
        m: &mut ModuleBuilder,
        shape: &Shape,
        words: &[Signal],
        of: (u32, Vertices, u32),
    ) -> Signal {
        let (port, v, j) = of;
        let q = self.stages()[0];
        let what = HALFWORDS[j as usize];
        let size = shape.entry_halfwords(v);
        let (count, groups) = (v.count() as u32, shape.groups(v));
        let word = if v.is_structured() { 3 } else { 2 };
        if j >= word {
            return m.lit(0, HALF);
        }
        let of_group: Vec<_> = (0..groups)
            .map(|g| {
                let at = |x: u32| g * shape.ports * size + port * size + x * word + j;
                let options: Vec<_> = (0..count).map(|x| words[at(x) as usize]).collect();
                let of_vertex = match q.step {
                    None => options[0],
                    Some(step) => m.select(step.vertex, &options),
                };
                m.name(of_vertex, &format!("{what}{port}_v{count}_group{g}"))
            })
            .collect();
        let picked = m.select(q.group, &of_group);
        m.name(picked, &format!("{what}{port}_v{count}"))
    }

    /// Id and weight of one vertex. With a stage between, the halfwords of each
    /// entry size are registered before one size is chosen.
    fn vertex(
        &self,
        m: &mut ModuleBuilder,
        shape: &Shape,
        read: &Read,
        vertices: Signal,
        words: &[Signal],
        port: u32,
    ) -> Given {
        let [row, tag, weight] = [0, 1, 2].map(|j| {
            let what = HALFWORDS[j as usize];
            let s = shape.by_vertices(m, vertices, |m, v| {
                let picked = self.halfword(m, shape, words, (port, v, j));
                if shape.between == 0 || j == 2 && !v.is_structured() {
                    return picked;
                }
                let reg = m.reg(&format!("e_{what}{port}_v{}", v.count()), HALF, 0);
                m.set_next_if(reg, read.fills[0], picked);
                reg
            });
            m.name(s, &format!("new_{what}{port}"))
        });
        Given {
            rows: vec![row],
            weights: vec![weight],
            slot: Slot::Tag(tag),
        }
    }

    /// Ids and weights of all vertices of an entry, each at the group of banks of
    /// its parities: where the first vertex is odd along an axis, the two sides
    /// change places.
    fn whole_entry(
        &self,
        m: &mut ModuleBuilder,
        shape: &Shape,
        read: &Read,
        words: &[Signal],
        port: u32,
    ) -> Given {
        let at = |v: u32, j: u32| words[(port * 24 + v * 3 + j) as usize];
        let mut held = |v: u32, j: u32| {
            if shape.between == 0 {
                return at(v, j);
            }
            let name = format!("e_{}{port}_{v}", HALFWORDS[j as usize]);
            let reg = m.reg(&name, HALF, 0);
            m.set_next_if(reg, read.fills[0], at(v, j));
            reg
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
        Given {
            rows: to_groups(rows, "row"),
            weights: to_groups(weights, "weight"),
            slot: Slot::Whole(slot),
        }
    }
}
