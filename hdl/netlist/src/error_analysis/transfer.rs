//! Error of a node from those of its operands.

use num_traits::{ToPrimitive, Zero};

use super::node_error::NodeError;
use crate::Module;
use crate::node::{Binary, Op, Ty, Unary};
use crate::range::{Interval, NodeIntervals};

/// Errors of a module's nodes; `None`: unbounded.
pub(super) struct NodeErrors<'a> {
    pub(super) module: &'a Module,
    pub(super) known: &'a NodeIntervals,
    /// By node of the hierarchy.
    pub(super) off: &'a [Option<NodeError>],
    /// Nodes whose high bits decide, and whose low bits are a remainder.
    pub(super) parts: &'a [usize],
    /// Number of the module's first node.
    pub(super) first: usize,
}

impl NodeErrors<'_> {
    /// Whether bits of a node are whole values of a vector.
    fn is_value(&self, of: usize, low: u32, width: u32) -> bool {
        let values = self.module.nodes[of].values;
        values.is_some_and(|own| low.is_multiple_of(own) && width.is_multiple_of(own))
    }

    /// Error of a combinational node with the untruncated result `whole`.
    ///
    /// Single bits are decisions, which have no error unless they are made of dropped bits.
    pub(super) fn of(&self, id: usize, whole: &Interval) -> Option<NodeError> {
        let node = &self.module.nodes[id];
        let off = |n: &usize| self.off[self.first + n].as_ref();
        let value = |n: &usize| &self.known.values[*n];
        let ty = |n: &usize| self.module.nodes[*n].ty;
        let fits = whole.fits(node.ty);
        let bits = |all: &[&usize]| {
            let kept = all.iter().all(|n| off(n).is_some_and(NodeError::is_none));
            if kept {
                NodeError::none()
            } else {
                NodeError::bit()
            }
        };
        match &node.op {
            Op::Lit(_) => Some(NodeError::none()),
            Op::Unary(Unary::Neg, a) if fits => Some(off(a)?.neg()),
            Op::Binary(Binary::Add, a, b) if fits => Some(off(a)?.add(off(b)?)),
            Op::Binary(Binary::Sub, a, b) if fits => Some(off(a)?.add(&off(b)?.neg())),
            Op::Binary(Binary::Mul, a, b) => Some(off(a)?.product(off(b)?, value(a), value(b))),
            Op::Shl(a, n) if fits => amounts(value(n), |n| Some(off(a)?.shl(n))),
            Op::Shr(a, n) => amounts(value(n), |n| Some(off(a)?.shr(n, value(a)))),
            // The same but for laps of the type.
            Op::Cast(a) if whole.wrap(node.ty).span() == whole.span() => self.uncut(*a),
            Op::Binary(Binary::And, a, b) if value(b).is_point() => {
                let b = value(b).wrap(Ty::u(ty(b).width)).low;
                if b.is_zero() {
                    Some(NodeError::none())
                } else if b == Ty::u(node.ty.width).max() {
                    off(a).cloned()
                } else {
                    None
                }
            }
            Op::Slice(a, low) if self.parts.contains(&(self.first + a)) => {
                if *low > 0 {
                    Some(NodeError::none())
                } else {
                    off(a).cloned()
                }
            }
            // Whole values of a vector: nothing is dropped from the one that is meant.
            Op::Slice(a, low) if self.is_value(*a, *low, node.ty.width) => {
                off(a).filter(|of| of.is_none()).cloned()
            }
            Op::Slice(a, 0) if fits && node.ty.width > 1 => off(a).cloned(),
            Op::Slice(a, 0) => Some(if value(a).is_point() {
                NodeError::of_known(value(a), node.ty.width)
            } else {
                NodeError::of_cut((self.first + a, node.ty.width))
            }),
            Op::Slice(a, low) if fits => {
                let a_off = off(a)?;
                Some(if value(a).is_point() {
                    a_off.shr(*low, value(a))
                } else {
                    a_off.cut((self.first + a, *low))
                })
            }
            Op::Cat(parts) if parts.iter().all(|p| off(p).is_some_and(NodeError::is_none)) => {
                Some(NodeError::none())
            }
            Op::Cat(parts) if fits => parts.iter().try_fold(NodeError::none(), |sum, p| {
                Some(sum.shl(ty(p).width).add(off(p)?))
            }),
            Op::Extend(a) => off(a).cloned(),
            Op::Round(a, bits, rounding) => Some(off(a)?.round(*bits, *rounding, value(a))),
            Op::Saturate(a) if value(a).fits(node.ty) => off(a).cloned(),
            Op::Saturate(a) => Some(off(a)?.join(&NodeError::none())),
            Op::Mux(c, t, e) if value(c).is_point() => {
                off(if value(c).low.is_zero() { e } else { t }).cloned()
            }
            Op::Mux(_, t, e) => Some(off(t)?.join(off(e)?)),
            Op::Select(index, options) => {
                let last = options.len() - 1;
                let at = |v: &num_bigint::BigInt| v.to_usize().unwrap_or(last).min(last);
                let picked = &options[at(&value(index).low)..=at(&value(index).high)];
                let mut all = picked.iter().map(off);
                let first = all.next()??.clone();
                all.try_fold(first, |sum, o| Some(sum.join(o?)))
            }
            _ if node.ty.width > 1 => None,
            Op::Unary(Unary::Not, a) => Some(bits(&[a])),
            Op::Binary(Binary::And | Binary::Or | Binary::Xor, a, b) => Some(bits(&[a, b])),
            _ => Some(NodeError::none()),
        }
    }
}

impl NodeErrors<'_> {
    /// Error of a node's untruncated result.
    fn uncut(&self, id: usize) -> Option<NodeError> {
        let node = &self.module.nodes[id];
        let off = |n: &usize| self.off[self.first + n].as_ref();
        if self.known.whole[id].fits(node.ty) {
            return off(&id).cloned();
        }
        match &node.op {
            Op::Slice(wide, 0) => off(wide).cloned(),
            Op::Binary(Binary::Add, a, b) => Some(off(a)?.add(off(b)?)),
            Op::Binary(Binary::Sub, a, b) => Some(off(a)?.add(&off(b)?.neg())),
            Op::Cast(a) => self.uncut(*a),
            _ => None,
        }
    }
}

/// Joins the results of all shift amounts.
fn amounts(n: &Interval, of: impl Fn(u32) -> Option<NodeError>) -> Option<NodeError> {
    let [low, high] = [&n.low, &n.high].map(|v| v.to_u32().filter(|v| *v <= 64));
    let mut all = (low?..=high?).map(of);
    let first = all.next()??;
    all.try_fold(first, |sum, o| Some(sum.join(&o?)))
}
