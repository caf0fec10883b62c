//! Slices and width conversions, always explicit and exact.

use num_bigint::BigInt;
use num_traits::Zero as _;
use potamoi_formats::fixed::Rounding;

use super::ModuleBuilder;
use crate::node::{Node, Op, Signal, Ty};

impl ModuleBuilder {
    /// Bits `low .. low + width`, unsigned.
    pub fn slice(&mut self, a: Signal, low: u32, width: u32) -> Signal {
        if width == 0 || low.checked_add(width).is_none_or(|end| end > a.width()) {
            let of = self.describe(a);
            self.fail("slice", format!("bits {low}+{width} of {of}"));
            return self.zero(Ty::u(width.max(1)));
        }
        if low == 0 && width == a.width() {
            return self.as_unsigned(a);
        }
        if let Some(value) = self.constant(a) {
            // Big integers shift and mask as two's complement.
            let bits = (value >> low) & ((BigInt::from(1) << width) - 1);
            return self.lit(bits, Ty::u(width));
        }
        let own = &self.module.nodes[a.id];
        if let (Op::Slice(of, base), None) = (&own.op, &own.name) {
            let (of, base) = (*of, *base);
            let whole = self.module.nodes[of].ty;
            let of = Signal { id: of, ty: whole };
            return self.slice(of, base + low, width);
        }
        self.node(Op::Slice(a.id, low), Ty::u(width))
    }

    /// Neighbouring slices of one signal as one slice, in a concatenation.
    fn neighbours(&mut self, parts: &[Signal]) -> Vec<Signal> {
        let mut joined: Vec<Signal> = vec![];
        for &part in parts {
            let last = joined.last().map(|s| (*s, &self.module.nodes[s.id].op));
            let here = &self.module.nodes[part.id].op;
            match (last, here) {
                (Some((high, Op::Slice(a, from))), Op::Slice(b, low))
                    if a == b && *from == low + part.width() =>
                {
                    let ty = self.module.nodes[*a].ty;
                    let (of, low) = (Signal { id: *a, ty }, *low);
                    joined.pop();
                    joined.push(self.slice(of, low, part.width() + high.width()));
                }
                _ => joined.push(part),
            }
        }
        joined
    }

    /// Value of an unnamed constant.
    pub(super) fn constant(&self, s: Signal) -> Option<&BigInt> {
        match &self.module.nodes[s.id] {
            Node {
                op: Op::Lit(value),
                name: None,
                ..
            } => Some(value),
            _ => None,
        }
    }

    /// Whether a signal is made of constants alone.
    #[must_use]
    pub fn is_fixed(&self, s: Signal) -> bool {
        self.fixed[s.id]
    }

    /// One bit.
    pub fn bit(&mut self, a: Signal, index: u32) -> Signal {
        self.slice(a, index, 1)
    }

    /// Concatenation, high part first; unsigned.
    pub fn cat(&mut self, parts: &[Signal]) -> Signal {
        let parts = self.neighbours(parts);
        match &*parts {
            [] => {
                self.fail("cat", "no parts".to_owned());
                self.zero(Ty::bit())
            }
            [one] => self.as_unsigned(*one),
            _ => {
                let widths = parts.iter().map(|p| p.width());
                let width = widths.fold(0, u32::saturating_add);
                self.node(Op::Cat(parts.iter().map(|p| p.id).collect()), Ty::u(width))
            }
        }
    }

    /// `count` copies, concatenated.
    pub fn repeat(&mut self, a: Signal, count: u32) -> Signal {
        if count == 1 {
            return self.as_unsigned(a);
        }
        if count == 0 {
            let of = self.describe(a);
            self.fail("repeat", format!("0 copies of {of}: expected 1 at least"));
            return self.as_unsigned(a);
        }
        let width = a.width().saturating_mul(count);
        if a.ty == Ty::bit()
            && let Some(value) = self.constant(a)
        {
            let ty = Ty::u(width);
            let all = if value.is_zero() {
                value.clone()
            } else {
                ty.max()
            };
            return self.lit(all, ty);
        }
        self.node(Op::Repeat(a.id, count), Ty::u(width))
    }

    /// Extends with zeros, or with the sign if signed.
    pub fn extend(&mut self, a: Signal, width: u32) -> Signal {
        if width == a.width() {
            return a;
        }
        if width < a.width() {
            let of = self.describe(a);
            self.fail(
                "extend",
                format!("{of} to {width} bits is narrower: truncate, round or saturate"),
            );
            return self.zero(Ty { width, ..a.ty });
        }
        let wide = Ty { width, ..a.ty };
        if let Some(value) = self.constant(a).cloned() {
            return self.lit(value, wide);
        }
        match self.module.nodes[a.id].op {
            Op::Extend(from) if self.module.nodes[a.id].name.is_none() => {
                self.node(Op::Extend(from), wide)
            }
            _ => self.node(Op::Extend(a.id), wide),
        }
    }

    /// Drops high bits; the signedness is unchanged.
    pub fn truncate(&mut self, a: Signal, width: u32) -> Signal {
        if width == a.width() {
            return a;
        }
        let cut = self.slice(a, 0, width);
        self.cast(cut, a.ty.signed)
    }

    pub(super) fn cast(&mut self, a: Signal, signed: bool) -> Signal {
        if a.ty.signed == signed {
            return a;
        }
        self.node(Op::Cast(a.id), Ty { signed, ..a.ty })
    }

    /// Reinterprets the bits as two's complement.
    pub fn as_signed(&mut self, a: Signal) -> Signal {
        self.cast(a, true)
    }

    /// Reinterprets the bits as unsigned.
    pub fn as_unsigned(&mut self, a: Signal) -> Signal {
        self.cast(a, false)
    }

    /// Drops `bits` low bits with rounding. The result is one bit wider than the remaining bits, so
    /// that it cannot overflow.
    pub fn round(&mut self, a: Signal, bits: u32, rounding: Rounding) -> Signal {
        if bits == 0 {
            return self.extend(a, a.width() + 1);
        }
        if bits >= a.width() {
            let of = self.describe(a);
            self.fail("round", format!("{bits} bits off {of}"));
            return self.zero(Ty { width: 1, ..a.ty });
        }
        let ty = Ty {
            width: a.width() - bits + 1,
            ..a.ty
        };
        self.node(Op::Round(a.id, bits, rounding), ty)
    }

    /// Saturates to another type.
    pub fn saturate(&mut self, a: Signal, ty: Ty) -> Signal {
        let ty = self.legal(ty);
        if ty == a.ty {
            return a;
        }
        if ty.min() <= a.ty.min() && ty.max() >= a.ty.max() {
            let wide = self.extend(a, ty.width);
            return self.cast(wide, ty.signed);
        }
        self.node(Op::Saturate(a.id), ty)
    }

    /// Whether saturating to `ty` changes the value.
    pub fn saturated(&mut self, a: Signal, ty: Ty) -> Signal {
        let ty = self.legal(ty);
        let mut outside = vec![];
        if ty.max() < a.ty.max() {
            let max = self.lit(ty.max(), a.ty);
            outside.push(self.gt(a, max));
        }
        if ty.min() > a.ty.min() {
            let min = self.lit(ty.min(), a.ty);
            outside.push(self.lt(a, min));
        }
        self.any_of(&outside)
    }
}
