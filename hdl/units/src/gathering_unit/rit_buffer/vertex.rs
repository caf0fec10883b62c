//! One vertex of entries in the paper's format.

use potamoi_formats::rit::Vertices;
use potamoi_formats::timing::RitStage;
use potamoi_netlist::{ModuleBuilder, Signal};

use crate::gathering_unit::shared::rit_output::{HALF, HALFWORDS, RitOutput, Slot};
use crate::gathering_unit::shared::rit_reader::{Read, Reader};
use crate::gathering_unit::shared::rit_shape::Shape;
use crate::gathering_unit::shared::rit_split::carry_named;

/// Halfword `j` of an entry's word in Q, for one entry size.
fn halfword(
    reader: &Reader,
    m: &mut ModuleBuilder,
    shape: &Shape,
    words: &[Signal],
    of: (u32, Vertices, u32),
) -> Signal {
    let (port, v, j) = of;
    let q = reader.banks;
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

/// Id and weight of one vertex. With a stage between, the halfwords of each entry size are
/// registered before the size is selected.
pub(super) fn vertex(
    reader: &Reader,
    m: &mut ModuleBuilder,
    shape: &Shape,
    read: &Read,
    vertices: Signal,
    words: &[Signal],
    port: u32,
) -> RitOutput {
    let to_e = read.stages([RitStage::Entry]);
    let [row, tag, weight] = [0, 1, 2].map(|j| {
        let what = HALFWORDS[j as usize];
        let s = shape.by_vertices(m, vertices, |m, v| {
            let picked = halfword(reader, m, shape, words, (port, v, j));
            if j == 2 && !v.is_structured() {
                return picked;
            }
            let name = format!("{what}{port}_v{}", v.count());
            carry_named(m, &to_e, &name, picked)
        });
        m.name(s, &format!("new_{what}{port}"))
    });
    RitOutput {
        rows: vec![row],
        weights: vec![weight],
        slot: Slot::Tag(tag),
    }
}
