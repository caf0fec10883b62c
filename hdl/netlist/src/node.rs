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
        /// Reset value; `None` for data that nothing reads before it is written.
        reset: Option<BigInt>,
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
    /// A selection that prints as an indexed part select, of which Yosys makes a larger circuit than
    /// of a `case`.
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
