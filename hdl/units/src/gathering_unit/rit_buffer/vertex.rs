//! One vertex of entries in the paper's format.
//!
//! A row is a list of words of three halfwords, row, tag and weight. The vertices of an entry lie
//! one after the other, as do the entries of a group, so that one selection serves every number of
//! vertices. Single ids have words of two halfwords, and a selection of their own.

use potamoi_formats::rit::Vertices;
use potamoi_formats::timing::RitStage;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use crate::circuits::{bits_for, is};
use crate::gathering_unit::shared::rit_output::{HALF, RitOutput, Slot};
use crate::gathering_unit::shared::rit_reader::{Read, Reader};
use crate::gathering_unit::shared::rit_shape::Shape;
use crate::gathering_unit::shared::rit_split::carry;

/// Bits of a word of an entry, and of an id.
const WORD: u32 = 48;
const ID: u32 = 32;

/// Id and weight of one vertex. With a stage between, word and id are registered before one of them
/// is selected.
pub(super) fn vertex(
    reader: &Reader,
    m: &mut ModuleBuilder,
    shape: &Shape,
    read: &Read,
    vertices: Signal,
    row: Signal,
    port: u32,
) -> RitOutput {
    let to_e = read.stages([RitStage::Entry]);
    let structured = shape.vertices.iter().any(|v| v.is_structured());
    let word = structured.then(|| {
        let word = word(reader, m, shape, vertices, row, port);
        carry(m, port, &to_e, "word", word)
    });
    let id = shape.vertices.contains(&Vertices::One).then(|| {
        let id = id(reader, m, shape, row, port);
        carry(m, port, &to_e, "id", id)
    });
    let low = |m: &mut ModuleBuilder, of: Signal| m.slice(of, 0, ID);
    let (row_and_tag, weight) = match (word, id) {
        (Some(word), Some(id)) => {
            let single = is(m, vertices, 0);
            let weight = m.slice(word, ID, 16);
            let none = m.lit(0, HALF);
            let own = low(m, word);
            (m.mux(single, id, own), m.mux(single, none, weight))
        }
        (Some(word), None) => (low(m, word), m.slice(word, ID, 16)),
        (None, Some(id)) => (id, m.lit(0, HALF)),
        (None, None) => (m.lit(0, Ty::u(ID)), m.lit(0, HALF)),
    };
    let row_and_tag = m.name(row_and_tag, &format!("new_row_and_tag{port}"));
    let row = m.slice(row_and_tag, 0, 16);
    let tag = m.slice(row_and_tag, 16, 16);
    RitOutput {
        rows: vec![row],
        weights: vec![m.name(weight, &format!("new_weight{port}"))],
        slot: Slot::Tag(tag),
    }
}

/// The word in Q of the vertex of a port's entry.
fn word(
    reader: &Reader,
    m: &mut ModuleBuilder,
    shape: &Shape,
    vertices: Signal,
    row: Signal,
    port: u32,
) -> Signal {
    let q = reader.banks;
    let words = row.width() / WORD;
    let index_bits = bits_for(words - 1);
    let index = shape.by_vertices(m, vertices, |m, v| {
        if !v.is_structured() {
            return m.lit(0, Ty::u(index_bits));
        }
        let low_bits = v.log2();
        let vertex = |m: &mut ModuleBuilder| match q.step {
            None => m.lit(0, Ty::u(low_bits)),
            Some(step) => m.slice(step.vertex, 0, low_bits),
        };
        // One port's row of eight vertices is a single entry.
        if low_bits == index_bits {
            return vertex(m);
        }
        let entries: Vec<_> = (0..shape.groups(v))
            .map(|g| m.lit(g * shape.ports + port, Ty::u(index_bits - low_bits)))
            .collect();
        let entry = m.select(q.group, &entries);
        let vertex = vertex(m);
        m.cat(&[entry, vertex])
    });
    let index = m.name(index, &format!("word_index{port}"));
    let options: Vec<_> = (0..words).map(|i| m.slice(row, WORD * i, WORD)).collect();
    let word = m.select(index, &options);
    m.name(word, &format!("word{port}"))
}

/// The id in Q of a port.
fn id(reader: &Reader, m: &mut ModuleBuilder, shape: &Shape, row: Signal, port: u32) -> Signal {
    let options: Vec<_> = (0..shape.groups(Vertices::One))
        .map(|g| m.slice(row, ID * (g * shape.ports + port), ID))
        .collect();
    let id = m.select(reader.banks.group, &options);
    m.name(id, &format!("id{port}"))
}
