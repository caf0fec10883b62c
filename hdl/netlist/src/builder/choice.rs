//! Multiplexers and selections.

use num_traits::Zero as _;

use super::ModuleBuilder;
use crate::node::{Op, Signal, Ty};

impl ModuleBuilder {
    /// Multiplexer: `condition ? then : other`.
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

    /// `options[index]`; an index past the list selects the last option.
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
        let mut options = &options[..options.len().min(reachable)];
        // The last one stands for all that are alike at the end.
        while let [rest @ .., before, last] = options
            && self.is_same(*before, *last)
        {
            options = &options[..=rest.len()];
        }
        match *options {
            [only] => return only,
            [low, high] if index.width() == 1 => return self.mux(index, high, low),
            [zero, other] => {
                let own = self.lit(0, index.ty);
                let is_zero = self.eq(index, own);
                return self.mux(is_zero, zero, other);
            }
            _ => {}
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

    /// Marks a selection: where its options are values at equal distances in a vector, one for each
    /// code, it prints as an indexed part select instead of a `case`.
    pub fn indexed(&mut self, s: Signal) -> Signal {
        self.module.nodes[s.id].indexed = true;
        s
    }

    fn is_same(&self, a: Signal, b: Signal) -> bool {
        let value = self.constant(a);
        a == b || value.is_some() && value == self.constant(b)
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
