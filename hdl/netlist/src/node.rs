//! Types, signals and nodes of the netlist.

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::fixed::Rounding;

use super::Module;

/// Width and signedness. No conversion is implicit: operands must agree, and extension, truncation
/// and reinterpretation are nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Ty {
    /// Width in bits, at least 1.
    pub width: u32,
    /// Whether it is two's complement.
    pub signed: bool,
}

impl Ty {
    /// An unsigned type.
    #[must_use]
    pub const fn u(width: u32) -> Self {
        Self {
            width,
            signed: false,
        }
    }

    /// A two's complement type.
    #[must_use]
    pub const fn s(width: u32) -> Self {
        Self {
            width,
            signed: true,
        }
    }

    /// One unsigned bit.
    #[must_use]
    pub const fn bit() -> Self {
        Self::u(1)
    }

    /// The smallest value.
    #[must_use]
    pub fn min(self) -> BigInt {
        if self.signed {
            -(BigInt::from(1) << (self.width - 1))
        } else {
            BigInt::ZERO
        }
    }

    /// The largest value.
    #[must_use]
    pub fn max(self) -> BigInt {
        (BigInt::from(1) << (self.width - u32::from(self.signed))) - 1
    }
}

impl std::fmt::Display for Ty {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", if self.signed { 's' } else { 'u' }, self.width)
    }
}

/// A value in a module: index and type of its node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Signal {
    pub(crate) id: usize,
    pub(crate) ty: Ty,
}

impl Signal {
    /// Width in bits.
    #[must_use]
    pub const fn width(self) -> u32 {
        self.ty.width
    }

    /// Whether it is two's complement.
    #[must_use]
    pub const fn signed(self) -> bool {
        self.ty.signed
    }

    /// Its type.
    #[must_use]
    pub const fn ty(self) -> Ty {
        self.ty
    }
}

/// A memory of a module.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemId(pub(crate) usize);

/// An instance of a module.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Instance(pub(crate) usize);

/// Binary operators on operands of one type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Binary {
    /// Bitwise and.
    And,
    /// Bitwise or.
    Or,
    /// Bitwise exclusive or.
    Xor,
    /// Sum, modulo the type's width.
    Add,
    /// Difference, modulo the type's width.
    Sub,
    /// Product, as wide as both operands together.
    Mul,
    /// `a == b`, one bit.
    Eq,
    /// `a != b`, one bit.
    Ne,
    /// `a < b`, one bit.
    Lt,
    /// `a <= b`, one bit.
    Le,
}

/// Unary operators.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unary {
    /// Every bit inverted.
    Not,
    /// `-a`, modulo the type's width.
    Neg,
    /// Whether a bit is set.
    Any,
    /// Whether every bit is set.
    All,
    /// Exclusive or of all bits.
    Parity,
}

/// Operation of a node. Operands are indices of nodes in the same module.
#[derive(Debug, Clone)]
pub enum Op {
    /// A port.
    Input,
    /// `rst_n` as a value: 0 in reset.
    OutOfReset,
    /// A constant; a named one prints as a localparam.
    Lit(BigInt),
    /// Unary operator, operand.
    Unary(Unary, usize),
    /// Binary operator, left operand, right operand.
    Binary(Binary, usize, usize),
    /// Left shift: value, amount.
    Shl(usize, usize),
    /// Right shift, arithmetic if signed: value, amount.
    Shr(usize, usize),
    /// Slice: value, lowest bit; the node's width.
    Slice(usize, u32),
    /// Concatenation, high part first.
    Cat(Vec<usize>),
    /// Repetition: value, count.
    Repeat(usize, u32),
    /// Extension by the operand's signedness.
    Extend(usize),
    /// Reinterpretation with another signedness.
    Cast(usize),
    /// Rounding: value, dropped bits, mode.
    Round(usize, u32, Rounding),
    /// Saturation to the node's type.
    Saturate(usize),
    /// Multiplexer: condition, value if 1, value if 0.
    Mux(usize, usize, usize),
    /// Selection: index, options; past the list the last one.
    Select(usize, Vec<usize>),
    /// A register; without `enable` it takes `next` at every clock edge.
    Reg {
        /// Reset value.
        reset: BigInt,
        /// Next value; `None` until it is set.
        next: Option<usize>,
        /// Enable.
        enable: Option<usize>,
    },
    /// Synchronous read: memory, enable, address.
    ReadSync(usize, usize, usize),
    /// Combinational read: memory, address.
    ReadAsync(usize, usize),
    /// Output of an instance: instance, port.
    InstanceOut(usize, usize),
}

impl Op {
    /// Operands with a combinational path to this node.
    pub(crate) fn operands(&self) -> Vec<usize> {
        match self {
            Self::Input
            | Self::OutOfReset
            | Self::Lit(_)
            | Self::Reg { .. }
            | Self::ReadSync(..)
            | Self::InstanceOut(..) => vec![],
            Self::Unary(_, a)
            | Self::Slice(a, _)
            | Self::Repeat(a, _)
            | Self::Extend(a)
            | Self::Cast(a)
            | Self::Round(a, ..)
            | Self::Saturate(a)
            | Self::ReadAsync(_, a) => vec![*a],
            Self::Binary(_, a, b) | Self::Shl(a, b) | Self::Shr(a, b) => vec![*a, *b],
            Self::Mux(c, t, e) => vec![*c, *t, *e],
            Self::Cat(parts) => parts.clone(),
            Self::Select(index, options) => {
                let mut all = vec![*index];
                all.extend(options);
                all
            }
        }
    }

    /// Operands sampled at the clock edge.
    pub(crate) fn edge_operands(&self) -> Vec<usize> {
        match self {
            Self::Reg { next, enable, .. } => next.iter().chain(enable).copied().collect(),
            Self::ReadSync(_, en, addr) => vec![*en, *addr],
            _ => vec![],
        }
    }
}

/// A node with its annotations.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub(crate) op: Op,
    pub(crate) ty: Ty,
    pub(crate) name: Option<String>,
    pub(crate) note: Option<String>,
    pub(crate) section: usize,
    /// Asserted not to wrap; proven by the range analysis.
    pub(crate) exact: bool,
    /// Width of the values that it is a vector of: its constants print value by value.
    pub(crate) values: Option<u32>,
    /// A selection that prints as an indexed part select. Yosys makes more of one than of a `case`.
    pub(crate) indexed: bool,
}

/// A port, in order of declaration.
#[derive(Debug, Clone)]
pub(crate) struct Port {
    pub(crate) name: String,
    pub(crate) node: usize,
    pub(crate) output: bool,
    /// Low in reset: its node is the conjunction with `rst_n`.
    pub(crate) low_in_reset: bool,
    pub(crate) doc: String,
}

#[derive(Debug, Clone)]
pub(crate) struct Memory {
    pub(crate) name: String,
    pub(crate) depth: u32,
    pub(crate) width: u32,
    pub(crate) doc: String,
    /// Whether nothing depends on what a read of a word gives that is written at the same edge.
    pub(crate) free_collisions: bool,
    /// Number of earlier nodes.
    pub(crate) at: usize,
    /// Writes: enable, address, data.
    pub(crate) writes: Vec<(usize, usize, usize)>,
}

#[derive(Debug, Clone)]
pub(crate) struct Inst {
    pub(crate) name: String,
    pub(crate) module: Arc<Module>,
    /// Inputs: port index of the module, node here.
    pub(crate) inputs: Vec<(usize, usize)>,
    /// Number of earlier nodes.
    pub(crate) at: usize,
}

/// Instances of one module over one or two loops, printed as `generate for`. The instances are
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
}

/// A matrix of bits with rows and columns exchanged, printed as `generate for`. The node is an
/// ordinary concatenation of bits.
#[derive(Debug, Clone)]
pub(crate) struct Transposed {
    pub(crate) node: usize,
    /// The matrix, row by row, row 0 lowest.
    pub(crate) from: usize,
    /// Loop variable and count of its rows and of its columns.
    pub(crate) rows: (String, u32),
    pub(crate) columns: (String, u32),
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

/// A declared bound for the range analysis.
#[derive(Debug, Clone)]
pub(crate) enum Contract {
    /// The signal is within these bounds.
    Range {
        node: usize,
        low: BigInt,
        high: BigInt,
        why: String,
    },
    /// The register holds the sum of at most this many terms.
    Terms {
        reg: usize,
        term: usize,
        most: u32,
        why: String,
    },
    /// The register holds features weighted by codes with the sum `total`.
    Weighted {
        reg: usize,
        feature: usize,
        total: BigInt,
        why: String,
    },
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
    let (index, options) = (*index, &options[..]);
    if !node.indexed {
        return None;
    }
    let codes = 1usize.checked_shl(nodes[index].ty.width)?;
    let [first, second, ..] = options else {
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
    let all = options.len() == codes && (0..).zip(options).all(in_order);
    all.then_some(Picked {
        vector: *vector,
        base: *base,
        stride,
        width,
    })
}
