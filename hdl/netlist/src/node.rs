//! Types, signals and nodes of the netlist.

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::fixed::Rounding;

use super::Module;

/// Width and signedness. Nothing is ever converted silently: operands must
/// agree, and extension, truncation and reinterpretation are nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Ty {
    /// Bits, at least 1.
    pub width: u32,
    /// Two's complement, or unsigned.
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

/// A value in a module: the index of its node, and its type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Signal {
    pub(crate) id: usize,
    pub(crate) ty: Ty,
}

impl Signal {
    /// Bits.
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

/// Operators of two operands of one type.
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

/// Operators of one operand.
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

/// What a node computes. Operands are numbers of nodes of the same module.
#[derive(Debug, Clone)]
pub enum Op {
    /// A port.
    Input,
    /// `rst_n` itself: 0 in reset.
    OutOfReset,
    /// A constant; with a name it prints as a localparam.
    Lit(BigInt),
    /// Operator, operand.
    Unary(Unary, usize),
    /// Operator, left operand, right operand.
    Binary(Binary, usize, usize),
    /// Dynamic shift to the left: value, amount.
    Shl(usize, usize),
    /// Dynamic shift to the right, arithmetic where signed: value, amount.
    Shr(usize, usize),
    /// Value, low bit; the width is the node's.
    Slice(usize, u32),
    /// High part first.
    Cat(Vec<usize>),
    /// Value, how often it is repeated.
    Repeat(usize, u32),
    /// By the operand's signedness.
    Extend(usize),
    /// To another signedness of the same width.
    Cast(usize),
    /// Value, bits dropped, how.
    Round(usize, u32, Rounding),
    /// To the range of the node's type.
    Saturate(usize),
    /// Condition, value if it is 1, value if it is 0.
    Mux(usize, usize, usize),
    /// Index, options; past the list the last one.
    Select(usize, Vec<usize>),
    /// A register; without `enable` it takes over `next` at every clock edge.
    Reg {
        /// Value in reset.
        reset: BigInt,
        /// Value that is taken over; `None` until it is set.
        next: Option<usize>,
        /// When it is taken over.
        enable: Option<usize>,
    },
    /// Read at the clock edge: memory, enable, address.
    ReadSync(usize, usize, usize),
    /// Read in the same cycle: memory, address.
    ReadAsync(usize, usize),
    /// Instance, port.
    InstanceOut(usize, usize),
}

impl Op {
    /// Nodes whose value this one needs in the same cycle.
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

    /// Nodes whose value this one takes over at the clock edge.
    pub(crate) fn edge_operands(&self) -> Vec<usize> {
        match self {
            Self::Reg { next, enable, .. } => next.iter().chain(enable).copied().collect(),
            Self::ReadSync(_, en, addr) => vec![*en, *addr],
            _ => vec![],
        }
    }
}

/// A node with what its author said of it.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub(crate) op: Op,
    pub(crate) ty: Ty,
    pub(crate) name: Option<String>,
    pub(crate) note: Option<String>,
    pub(crate) section: usize,
    /// Must not wrap; proven by the range analysis.
    pub(crate) exact: bool,
}

/// A port, in order of declaration.
#[derive(Debug, Clone)]
pub(crate) struct Port {
    pub(crate) name: String,
    pub(crate) node: usize,
    pub(crate) output: bool,
    /// Its node is the conjunction of `rst_n` and what it is otherwise.
    pub(crate) low_in_reset: bool,
    pub(crate) doc: String,
}

#[derive(Debug, Clone)]
pub(crate) struct Memory {
    pub(crate) name: String,
    pub(crate) depth: u32,
    pub(crate) width: u32,
    pub(crate) doc: String,
    /// Nodes that stood before it.
    pub(crate) at: usize,
    /// Enable, address, data.
    pub(crate) writes: Vec<(usize, usize, usize)>,
}

#[derive(Debug, Clone)]
pub(crate) struct Inst {
    pub(crate) name: String,
    pub(crate) module: Arc<Module>,
    /// Port index of the module -> node here, for inputs.
    pub(crate) inputs: Vec<(usize, usize)>,
    /// Nodes that stood before it.
    pub(crate) at: usize,
}

/// A declared bound that the range analysis builds on.
#[derive(Debug, Clone)]
pub(crate) enum Contract {
    /// The signal stays within these bounds.
    Range {
        node: usize,
        low: BigInt,
        high: BigInt,
        why: String,
    },
    /// The register holds at most this many terms.
    Terms {
        reg: usize,
        term: usize,
        most: u32,
        why: String,
    },
    /// The register holds features weighted by codes that sum to `total`.
    Weighted {
        reg: usize,
        feature: usize,
        total: BigInt,
        why: String,
    },
}
