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
    (row, ids): (Signal, Option<Ids>),
    port: u32,
) -> RitOutput {
    let to_e = read.stages([RitStage::Entry]);
    let structured = shape.vertices.iter().any(|v| v.is_structured());
    let word = structured.then(|| {
        let word = word(reader, m, shape, vertices, row, port);
        carry(m, port, &to_e, "word", word)
    });
    let id = ids.map(|ids| {
        let id = m.slice(ids.all, ID * port, ID);
        carry(m, port, &to_e, "id", id)
    });
    let low = |m: &mut ModuleBuilder, of: Signal| m.slice(of, 0, ID);
    let single = ids.map(|ids| ids.are_read);
    let (row_and_tag, weight) = match (word, id.zip(single)) {
        (Some(word), Some((id, single))) => {
            let weight = m.slice(word, ID, 16);
            let none = m.lit(0, HALF);
            let own = low(m, word);
            (m.mux(single, id, own), m.mux(single, none, weight))
        }
        (Some(word), None) => (low(m, word), m.slice(word, ID, 16)),
        (None, Some((id, _))) => (id, m.lit(0, HALF)),
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
    let words = row.width() / WORD;
    let index_bits = bits_for(words - 1);
    let mut built = shape.vertices.iter().filter(|v| v.is_structured()).rev();
    // Other settings read as the largest size.
    let largest = built.next().copied().unwrap_or(Vertices::Eight);
    let index = word_index(reader, m, shape, largest, index_bits, port);
    let index = built.fold(index, |others, v| {
        let own = word_index(reader, m, shape, *v, index_bits, port);
        let is_set = is(m, vertices, v.log2());
        m.mux(is_set, own, others)
    });
    let index = m.name(index, &format!("word_index{port}"));
    if words.is_power_of_two() {
        return halved(m, row, index, &format!("word{port}"));
    }
    let options: Vec<_> = (0..words).map(|i| m.slice(row, WORD * i, WORD)).collect();
    let word = m.select(index, &options);
    m.name(word, &format!("word{port}"))
}

/// Place in the row of the vertex in Q of a port's entry.
fn word_index(
    reader: &Reader,
    m: &mut ModuleBuilder,
    shape: &Shape,
    vertices: Vertices,
    index_bits: u32,
    port: u32,
) -> Signal {
    let q = reader.banks;
    let low_bits = vertices.log2();
    let vertex = match q.step {
        None => m.lit(0, Ty::u(low_bits)),
        Some(step) => m.slice(step.vertex, 0, low_bits),
    };
    // One port's row of eight vertices is a single entry.
    if low_bits == index_bits {
        return vertex;
    }
    let entry_bits = index_bits - low_bits;
    if !shape.ports.is_power_of_two() {
        let entries: Vec<_> = (0..shape.groups(vertices))
            .map(|g| m.lit(g * shape.ports + port, Ty::u(entry_bits)))
            .collect();
        let entry = m.select(q.group, &entries);
        return m.cat(&[entry, vertex]);
    }
    let port_bits = shape.ports.ilog2();
    let mut parts = vec![];
    if entry_bits > port_bits {
        parts.push(m.slice(q.group, 0, entry_bits - port_bits));
    }
    if port_bits > 0 {
        parts.push(m.lit(port, Ty::u(port_bits)));
    }
    parts.push(vertex);
    m.cat(&parts)
}

/// Single ids in Q.
#[derive(Clone, Copy)]
pub(super) struct Ids {
    /// One a port, the first lowest.
    all: Signal,
    /// Whether the entries are single ids.
    are_read: Signal,
}

/// The ids in Q of all ports; `None` where the unit has no single ids. A row holds three times four
/// groups.
pub(super) fn ids(
    reader: &Reader,
    m: &mut ModuleBuilder,
    shape: &Shape,
    vertices: Signal,
    row: Signal,
) -> Option<Ids> {
    if !shape.vertices.contains(&Vertices::One) {
        return None;
    }
    let group = reader.banks.group;
    let part = row.width() / 3;
    let part_index = m.slice(group, 2, group.width() - 2);
    let parts = [0, 1, 2].map(|i| m.slice(row, part * i, part));
    let (first, second) = (is(m, part_index, 0), is(m, part_index, 1));
    let later = m.mux(second, parts[1], parts[2]);
    let of_four = m.mux(first, parts[0], later);
    let of_four = m.name(of_four, "ids_of_4");
    let place = m.slice(group, 0, 2);
    let all = halved(m, of_four, place, "ids");
    Some(Ids {
        all,
        are_read: is(m, vertices, 0),
    })
}

/// The value at `index` of those that a vector holds, one for each code: halves of halves.
fn halved(m: &mut ModuleBuilder, mut vector: Signal, index: Signal, name: &str) -> Signal {
    for bit in (0..index.width()).rev() {
        let half = vector.width() / 2;
        let (low, high) = (m.slice(vector, 0, half), m.slice(vector, half, half));
        let upper = m.bit(index, bit);
        vector = m.mux(upper, high, low);
        let own = match bit {
            0 => name.to_owned(),
            _ => format!("{name}_of_{}", 1 << bit),
        };
        vector = m.name(vector, &own);
    }
    vector
}
