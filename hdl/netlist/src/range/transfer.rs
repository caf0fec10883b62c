//! Interval of a node from those of its operands.

use num_bigint::BigInt;
use num_traits::{One, ToPrimitive, Zero};

use super::Interval;
use crate::Module;
use crate::node::{Binary, Op, Ty, Unary};

/// Intervals of a module's nodes.
#[derive(Debug, Clone)]
pub(crate) struct NodeIntervals {
    /// Values of each node.
    pub(crate) values: Vec<Interval>,
    /// Untruncated results: integers that agree with the values in their low bits.
    pub(crate) whole: Vec<Interval>,
}

impl NodeIntervals {
    /// The full ranges of all types.
    pub(crate) fn of(module: &Module) -> Self {
        let values: Vec<_> = module.nodes.iter().map(|n| Interval::all(n.ty)).collect();
        let whole = values.clone();
        Self { values, whole }
    }

    /// The untruncated result of a combinational node.
    pub(crate) fn result(&self, module: &Module, id: usize) -> Interval {
        let node = &module.nodes[id];
        let of = |n: &usize| &self.values[*n];
        let ty = |n: &usize| module.nodes[*n].ty;
        let code = |n: &usize| of(n).wrap(Ty::u(ty(n).width));
        let all = || Interval::all(node.ty);
        match &node.op {
            Op::Lit(value) => Interval::point(value),
            Op::Unary(op, a) => match op {
                Unary::Not if node.ty.signed => Interval::new(-1, -1).add(&of(a).neg()),
                Unary::Not => Interval::point(&node.ty.max()).add(&of(a).neg()),
                Unary::Neg => of(a).neg(),
                Unary::Any => decided(!of(a).contains(&BigInt::zero()), is(of(a), &BigInt::zero())),
                Unary::All => {
                    let ones = Ty::u(ty(a).width).max();
                    decided(is(&code(a), &ones), !code(a).contains(&ones))
                }
                Unary::Parity => Interval::new(0, 1),
            },
            Op::Binary(Binary::And, a, b) if is(&code(b), &Ty::u(ty(b).width).max()) => {
                of(a).clone()
            }
            Op::Binary(op, a, b) => binary(*op, of(a), of(b)).unwrap_or_else(all),
            Op::Shl(a, n) => {
                let (least, most) = amounts(of(n), node.ty.width);
                of(a).shl(least, most)
            }
            Op::Shr(a, n) => {
                let (least, most) = amounts(of(n), node.ty.width);
                of(a).shr(least, most)
            }
            // The low bits of the whole result are those of the value.
            Op::Slice(a, 0) => self.whole[*a].clone(),
            Op::Slice(a, low) => of(a).shr(*low, *low),
            Op::Cat(parts) => {
                // What is above the top part is cut off.
                let mut sum = Interval::new(0, 0);
                for (i, p) in parts.iter().enumerate() {
                    let part = if i == 0 {
                        self.whole[*p].clone()
                    } else {
                        code(p)
                    };
                    sum = sum.shl(ty(p).width, ty(p).width).add(&part);
                }
                sum
            }
            Op::Repeat(a, n) => {
                let width = ty(a).width;
                let ones = (0..*n).fold(BigInt::zero(), |sum, _| (sum << width) + 1u8);
                code(a).mul(&Interval::point(&ones))
            }
            Op::Extend(a) => of(a).clone(),
            Op::Cast(a) => self.whole[*a].clone(),
            Op::Round(a, bits, rounding) => of(a).round(*bits, *rounding),
            Op::Saturate(a) => of(a).clamp(node.ty),
            Op::Mux(c, t, e) => match truth(of(c)) {
                Some(true) => of(t).clone(),
                Some(false) => of(e).clone(),
                None => of(t).join(of(e)),
            },
            Op::Select(index, options) => {
                let last = options.len() - 1;
                let at = |v: &BigInt| v.to_usize().unwrap_or(last).min(last);
                let picked = &options[at(&of(index).low)..=at(&of(index).high)];
                let joined = picked.iter().map(of).cloned().reduce(|a, b| a.join(&b));
                joined.unwrap_or_else(all)
            }
            Op::Input
            | Op::OutOfReset
            | Op::Reg { .. }
            | Op::ReadSync(..)
            | Op::ReadAsync(..)
            | Op::InstanceOut(..) => all(),
        }
    }
}

/// The value of a bit, if it is known.
pub(crate) fn truth(bit: &Interval) -> Option<bool> {
    bit.is_point().then(|| !bit.low.is_zero())
}

fn is(i: &Interval, value: &BigInt) -> bool {
    i.is_point() && &i.low == value
}

fn decided(yes: bool, no: bool) -> Interval {
    Interval::new(u8::from(yes), u8::from(!no))
}

/// Range of shift amounts; the width and more shift everything out.
fn amounts(n: &Interval, width: u32) -> (u32, u32) {
    let cut = |v: &BigInt| v.to_u32().unwrap_or(width).min(width);
    (cut(&n.low), cut(&n.high))
}

fn binary(op: Binary, a: &Interval, b: &Interval) -> Option<Interval> {
    let apart = a.high < b.low || b.high < a.low;
    let same = a.is_point() && a == b;
    let points = a.is_point() && b.is_point();
    Some(match op {
        Binary::And if points => Interval::point(&(&a.low & &b.low)),
        Binary::Or if points => Interval::point(&(&a.low | &b.low)),
        Binary::Xor if points => Interval::point(&(&a.low ^ &b.low)),
        Binary::And => a.and(b)?,
        Binary::Or => {
            let any = a.or(b)?;
            Interval::new((&a.low).max(&b.low).clone(), any.high)
        }
        Binary::Xor => a.or(b)?,
        Binary::Add => a.add(b),
        Binary::Sub => a.add(&b.neg()),
        Binary::Mul => a.mul(b),
        Binary::Eq => decided(same, apart),
        Binary::Ne => decided(apart, same),
        Binary::Lt => decided(a.high < b.low, a.low >= b.high),
        Binary::Le => decided(a.high <= b.low, a.low > b.high),
    })
}

/// Whether a node's result may exceed its type.
pub(super) fn can_wrap(op: &Op) -> bool {
    matches!(
        op,
        Op::Unary(Unary::Neg, _)
            | Op::Binary(Binary::Add | Binary::Sub, ..)
            | Op::Shl(..)
            | Op::Slice(..)
            | Op::Cast(_)
    )
}

/// Power of two.
pub(super) fn power(bits: u32) -> BigInt {
    BigInt::one() << bits
}
