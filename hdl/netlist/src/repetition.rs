//! Repetition in a module: what some of its nodes and instances have in common, so that the text has
//! loops and indices. The nodes and instances themselves are ordinary ones.

use super::node::{Node, Op, Ty};

/// Instances of one module over loops, printed as `generate for`. The instances are
/// ordinary ones; the array says what they have in common.
#[derive(Debug, Clone)]
pub(crate) struct Array {
    pub(crate) name: String,
    /// Loop variables and their counts, the outermost first.
    pub(crate) loops: Vec<(String, u32)>,
    /// Index of the first instance; the others follow, the innermost loop fastest.
    pub(crate) first: usize,
    /// Input port, and what feeds it.
    pub(crate) inputs: Vec<(usize, Fed)>,
    /// Output port, and the vector of all its values.
    pub(crate) outputs: Vec<(usize, usize)>,
}

impl Array {
    /// Number of instances.
    pub(crate) fn count(&self) -> usize {
        self.loops
            .iter()
            .map(|(_, count)| *count as usize)
            .product()
    }

    /// Loops of the text: those with more than one turn, or the innermost.
    pub(crate) fn printed_loops(&self) -> Vec<(String, u32)> {
        let more = self.loops.iter().filter(|(_, count)| *count > 1).cloned();
        let more: Vec<_> = more.collect();
        match more.is_empty() {
            true => self.loops.last().cloned().into_iter().collect(),
            false => more,
        }
    }

    /// Scope of an instance in the text, if it is one of the array: `bank[3]`, or with an outer loop
    /// over `port`, `bank_of_port[1].bank[3]`.
    pub(crate) fn scope(&self, instance: usize) -> Option<String> {
        let mut rest = instance.checked_sub(self.first)?;
        if rest >= self.count() {
            return None;
        }
        let loops = self.printed_loops();
        let mut scopes = vec![];
        for at in (0..loops.len()).rev() {
            let count = loops[at].1 as usize;
            let label = label(&self.name, &loops, at);
            scopes.push(format!("{label}[{}]", rest % count));
            rest /= count;
        }
        scopes.reverse();
        Some(scopes.join("."))
    }
}

/// Label of the block of a loop: the name for the innermost.
pub(crate) fn label(name: &str, loops: &[(String, u32)], at: usize) -> String {
    match at + 1 == loops.len() {
        true => name.to_owned(),
        false => format!("{name}_of_{}", loops[at].0),
    }
}

/// Bits of a vector in another order, or several times each, printed as loops. The node is an ordinary
/// concatenation of bits.
#[derive(Debug, Clone)]
pub(crate) struct Rearranged {
    pub(crate) node: usize,
    /// The vector.
    pub(crate) from: usize,
    /// The loops, outermost first: each bit of the node is of one turn of them, or as many as follow one
    /// another.
    pub(crate) loops: Vec<Stride>,
    pub(crate) times: u32,
}

/// A loop over bits.
#[derive(Debug, Clone)]
pub(crate) struct Stride {
    pub(crate) variable: String,
    pub(crate) count: u32,
    /// Distance of the bits of two turns, in the node and in the vector.
    pub(crate) to: u32,
    pub(crate) from: u32,
}

/// `3 * row + column`, the loop of the largest distance first.
pub(crate) fn place(mut terms: Vec<(&str, u32)>) -> String {
    terms.sort_by_key(|(_, distance)| std::cmp::Reverse(*distance));
    let terms = terms
        .into_iter()
        .map(|(variable, distance)| match distance {
            1 => variable.to_owned(),
            _ => format!("{distance} * {variable}"),
        });
    terms.collect::<Vec<_>>().join(" + ")
}

/// What feeds an input port of all instances of an array.
#[derive(Debug, Clone)]
pub(crate) struct Fed {
    pub(crate) node: usize,
    /// Loops, by index, over which the node is a vector with a value for each instance; none where
    /// all instances take the node itself.
    pub(crate) over: Vec<usize>,
    /// Distance in bits of the values in the vector, and lowest bit of the first.
    pub(crate) stride: u32,
    pub(crate) base: u32,
}

/// Values at equal distances in a vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Picked {
    pub(crate) vector: usize,
    /// Lowest bit of the first value, distance and width of the values.
    pub(crate) base: u32,
    pub(crate) stride: u32,
    pub(crate) width: u32,
}

/// What an indexed selection picks, if it has an option for each code of its index, and the options
/// are values at equal distances in a vector.
pub(crate) fn picked(nodes: &[Node], node: &Node) -> Option<Picked> {
    let Op::Select(index, options) = &node.op else {
        return None;
    };
    let codes = 1usize.checked_shl(nodes[*index].ty.width)?;
    let [first, second, ..] = &options[..] else {
        return None;
    };
    let (Op::Slice(vector, base), Op::Slice(_, next)) = (&nodes[*first].op, &nodes[*second].op)
    else {
        return None;
    };
    let (stride, width) = (next.checked_sub(*base)?, nodes[*first].ty.width);
    let in_order = |(i, option): (u32, &usize)| {
        let own = &nodes[*option];
        own.ty == Ty::u(width)
            && matches!(own.op, Op::Slice(v, low) if v == *vector && low == base + i * stride)
    };
    let all = node.indexed && options.len() == codes && (0..).zip(options).all(in_order);
    all.then_some(Picked {
        vector: *vector,
        base: *base,
        stride,
        width,
    })
}
