//! Bitwise operations, arithmetic, comparisons, shifts.

use num_bigint::BigInt;
use num_traits::{ToPrimitive as _, Zero as _};

use super::ModuleBuilder;
use crate::node::{Binary, Op, Signal, Ty, Unary};

impl ModuleBuilder {
    fn binary(&mut self, what: &str, op: Binary, a: Signal, b: Signal, ty: Ty) -> Signal {
        if self.agree(what, a, b) {
            self.node(Op::Binary(op, a.id, b.id), ty)
        } else {
            self.zero(ty)
        }
    }

    /// An operation on two values of which one is a constant of equal bits. Bits of the value
    /// `ruling` determine the result; those of the other value pass the other operand.
    fn with_known_bits(&self, a: Signal, b: Signal, ruling: bool) -> Option<Signal> {
        if a.ty != b.ty || a.ty.signed {
            return None;
        }
        [(a, b), (b, a)].into_iter().find_map(|(known, other)| {
            let value = self.constant(known)?;
            let ones = *value == known.ty.max();
            if !ones && !value.is_zero() {
                return None;
            }
            Some(if ones == ruling { known } else { other })
        })
    }

    /// Bitwise and.
    pub fn and(&mut self, a: Signal, b: Signal) -> Signal {
        if let Some(result) = self.with_known_bits(a, b, false) {
            return result;
        }
        self.binary("and", Binary::And, a, b, a.ty)
    }

    /// Bitwise or.
    pub fn or(&mut self, a: Signal, b: Signal) -> Signal {
        if let Some(result) = self.with_known_bits(a, b, true) {
            return result;
        }
        self.binary("or", Binary::Or, a, b, a.ty)
    }

    /// Bitwise exclusive or.
    pub fn xor(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("xor", Binary::Xor, a, b, a.ty)
    }

    /// Bitwise complement.
    pub fn not(&mut self, a: Signal) -> Signal {
        if a.ty == Ty::bit()
            && let Some(known) = self.constant(a)
        {
            let inverse = u8::from(known.is_zero());
            return self.lit(inverse, a.ty);
        }
        self.node(Op::Unary(Unary::Not, a.id), a.ty)
    }

    /// Two's complement negation, wrapping.
    pub fn neg(&mut self, a: Signal) -> Signal {
        self.node(Op::Unary(Unary::Neg, a.id), a.ty)
    }

    /// Whether any bit is set.
    pub fn any(&mut self, a: Signal) -> Signal {
        if a.width() == 1 {
            return self.as_unsigned(a);
        }
        self.node(Op::Unary(Unary::Any, a.id), Ty::bit())
    }

    /// Whether all bits are set.
    pub fn all(&mut self, a: Signal) -> Signal {
        if a.width() == 1 {
            return self.as_unsigned(a);
        }
        self.node(Op::Unary(Unary::All, a.id), Ty::bit())
    }

    /// Exclusive or of all bits.
    pub fn parity(&mut self, a: Signal) -> Signal {
        self.node(Op::Unary(Unary::Parity, a.id), Ty::bit())
    }

    /// Sum of the operands' type, wrapping.
    pub fn add(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("add", Binary::Add, a, b, a.ty)
    }

    /// Difference of the operands' type, wrapping.
    pub fn sub(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("sub", Binary::Sub, a, b, a.ty)
    }

    /// Full product, as wide as both operands together. Both signed or both unsigned.
    pub fn mul(&mut self, a: Signal, b: Signal) -> Signal {
        let ty = Ty {
            width: a.ty.width + b.ty.width,
            signed: a.ty.signed,
        };
        if a.ty.signed == b.ty.signed {
            self.node(Op::Binary(Binary::Mul, a.id, b.id), ty)
        } else {
            let (x, y) = (self.describe(a), self.describe(b));
            self.fail("mul", format!("signedness differs: {x} and {y}"));
            self.zero(ty)
        }
    }

    /// Equal.
    pub fn eq(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("eq", Binary::Eq, a, b, Ty::bit())
    }

    /// Not equal.
    pub fn ne(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("ne", Binary::Ne, a, b, Ty::bit())
    }

    /// Less.
    pub fn lt(&mut self, a: Signal, b: Signal) -> Signal {
        if self.is_extreme(b, Ty::min) || self.is_extreme(a, Ty::max) {
            return self.compared("lt", a, b, |m| m.zero(Ty::bit()));
        }
        if a.ty == Ty::s(1) {
            // Of 0 and -1. Verilator 5.006 folds signed comparisons of single
            // constant bits wrongly.
            return self.compared("lt", a, b, |m| {
                let (a, b) = (m.as_unsigned(a), m.as_unsigned(b));
                let not_b = m.not(b);
                m.and(a, not_b)
            });
        }
        self.binary("lt", Binary::Lt, a, b, Ty::bit())
    }

    /// Less or equal.
    pub fn le(&mut self, a: Signal, b: Signal) -> Signal {
        if self.is_extreme(a, Ty::min) || self.is_extreme(b, Ty::max) {
            return self.compared("le", a, b, |m| m.lit(1, Ty::bit()));
        }
        if a.ty == Ty::s(1) {
            return self.compared("le", a, b, |m| {
                let (a, b) = (m.as_unsigned(a), m.as_unsigned(b));
                let not_b = m.not(b);
                m.or(a, not_b)
            });
        }
        self.binary("le", Binary::Le, a, b, Ty::bit())
    }

    /// A comparison in another form than its operator.
    fn compared(
        &mut self,
        what: &str,
        a: Signal,
        b: Signal,
        make: impl FnOnce(&mut Self) -> Signal,
    ) -> Signal {
        if self.agree(what, a, b) {
            make(self)
        } else {
            self.zero(Ty::bit())
        }
    }

    /// Whether a value is constant and an extreme of its type; linters warn about comparisons with
    /// it.
    fn is_extreme(&self, s: Signal, end: fn(Ty) -> BigInt) -> bool {
        self.constant(s).is_some_and(|value| *value == end(s.ty))
    }

    /// Greater.
    pub fn gt(&mut self, a: Signal, b: Signal) -> Signal {
        self.lt(b, a)
    }

    /// Greater or equal.
    pub fn ge(&mut self, a: Signal, b: Signal) -> Signal {
        self.le(b, a)
    }

    /// Left shift by an unsigned signal; the width is unchanged.
    pub fn shl(&mut self, a: Signal, amount: Signal) -> Signal {
        let amount = self.shift_amount("shl", amount);
        if let Some(known) = self.constant(amount).and_then(|n| n.to_u32()) {
            return self.shl_const(a, known);
        }
        self.node(Op::Shl(a.id, amount.id), a.ty)
    }

    /// Right shift by an unsigned signal, arithmetic if signed.
    pub fn shr(&mut self, a: Signal, amount: Signal) -> Signal {
        let amount = self.shift_amount("shr", amount);
        if let Some(known) = self.constant(amount).and_then(|n| n.to_u32()) {
            return self.shr_const(a, known);
        }
        self.node(Op::Shr(a.id, amount.id), a.ty)
    }

    /// The amount in at most 32 bits, as larger amounts shift everything out. Verilator 5.006 gives
    /// wrong results for values of up to 64 bits and amounts wider than 64.
    fn shift_amount(&mut self, what: &str, amount: Signal) -> Signal {
        if amount.ty.signed {
            self.fail(what, "the amount is signed".to_owned());
            return amount;
        }
        if amount.width() <= 32 {
            return amount;
        }
        let above = self.slice(amount, 32, amount.width() - 32);
        let far = self.any(above);
        let near = self.slice(amount, 0, 32);
        let all = self.lit(u32::MAX, Ty::u(32));
        self.mux(far, all, near)
    }

    /// Left shift by a constant below the width; the width is unchanged.
    pub fn shl_const(&mut self, a: Signal, by: u32) -> Signal {
        if by == 0 {
            return a;
        }
        if by >= a.width() {
            return self.zero(a.ty);
        }
        let low = self.slice(a, 0, a.width() - by);
        let zeros = self.zero(Ty::u(by));
        let both = self.cat(&[low, zeros]);
        self.cast(both, a.ty.signed)
    }

    /// Right shift by a constant, arithmetic if signed; the width is unchanged.
    pub fn shr_const(&mut self, a: Signal, by: u32) -> Signal {
        if by == 0 {
            return a;
        }
        let by = if a.signed() {
            by.min(a.width() - 1)
        } else {
            by
        };
        if by >= a.width() {
            return self.zero(a.ty);
        }
        let high = self.slice(a, by, a.width() - by);
        let high = self.cast(high, a.ty.signed);
        self.extend(high, a.width())
    }
}
