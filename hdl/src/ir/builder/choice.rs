//! Choices between values.

use num_traits::Zero as _;

use super::ModuleBuilder;
use crate::ir::node::{Op, Signal, Ty};

impl ModuleBuilder {
    /// `condition ? then : other`.
    pub fn mux(&mut self, condition: Signal, then: Signal, other: Signal) -> Signal {
        if condition.ty != Ty::bit() {
            let of = self.describe(condition);
            self.fail("mux", format!("condition {of} is not one unsigned bit"));
            return then;
        }
        if !self.agree("mux", then, other) {
            return then;
        }
        if then == other {
            return then;
        }
        if let Some(always) = self.constant(condition) {
            return if always.is_zero() { other } else { then };
        }
        self.node(Op::Mux(condition.id, then.id, other.id), then.ty)
    }

    /// `options[index]`; past the list the last one.
    pub fn select(&mut self, index: Signal, options: &[Signal]) -> Signal {
        let Some(first) = options.first().copied() else {
            self.fail("select", "no options".to_owned());
            return self.zero(Ty::bit());
        };
        if index.ty.signed {
            self.fail("select", "the index is signed".to_owned());
        }
        for o in options {
            if !self.agree("select", first, *o) {
                return first;
            }
        }
        let reachable = 1usize.checked_shl(index.width()).unwrap_or(usize::MAX);
        let options = &options[..options.len().min(reachable)];
        if options.iter().all(|o| *o == first) {
            return first;
        }
        if self.fixed[index.id] {
            // Nothing would ever wake a case statement.
            let last = options.len() - 1;
            return (0..last).rev().fold(options[last], |other, i| {
                let own = self.lit(i, index.ty);
                let here = self.eq(index, own);
                self.mux(here, options[i], other)
            });
        }
        self.node(
            Op::Select(index.id, options.iter().map(|o| o.id).collect()),
            first.ty,
        )
    }

    fn fold(
        &mut self,
        bits: &[Signal],
        empty: u8,
        op: fn(&mut Self, Signal, Signal) -> Signal,
    ) -> Signal {
        let mut all = bits.iter().copied();
        match all.next() {
            None => self.lit(empty, Ty::bit()),
            Some(first) => all.fold(first, |sum, bit| op(self, sum, bit)),
        }
    }

    /// Whether any of these bits is set.
    pub fn any_of(&mut self, bits: &[Signal]) -> Signal {
        self.fold(bits, 0, Self::or)
    }

    /// Whether all of these bits are set.
    pub fn all_of(&mut self, bits: &[Signal]) -> Signal {
        self.fold(bits, 1, Self::and)
    }
}
