//! Case analysis of multiplexers: each side with the facts that its condition implies.

use num_bigint::BigInt;
use num_traits::One;

use super::interval_interpreter::IntervalInterpreter;
use super::node_error::NodeError;
use crate::node::{Binary, Op, Ty, Unary};
use crate::range::{Interval, truth};

/// Largest depth of re-evaluation behind a side.
const DEPTH: u32 = 6;

/// A node's value, its untruncated result, and its error.
type Found = (Interval, Interval, Option<NodeError>);

impl IntervalInterpreter<'_> {
    /// Evaluates a node from its operands.
    pub(super) fn result(&mut self, id: usize) -> Found {
        let Some(condition) = self.open(id) else {
            return self.plain(id);
        };
        let mut sides = [false, true].into_iter().filter_map(|side| {
            let mut facts = vec![(condition, Interval::new(u8::from(side), u8::from(side)))];
            self.says(condition, side, &mut facts);
            self.under(&facts, id)
        });
        let Some(first) = sides.next() else {
            return self.plain(id);
        };
        sides.fold(first, |(value, whole, off), (v, w, o)| {
            let off = off.zip(o).map(|(a, b)| a.join(&b));
            (value.join(&v), whole.join(&w), off)
        })
    }

    /// The undecided condition of a multiplexer of words: this node, or one with known options that
    /// it adds or subtracts.
    fn open(&self, id: usize) -> Option<usize> {
        match &self.node(id).op {
            Op::Mux(..) => self.undecided(id),
            Op::Binary(Binary::Add | Binary::Sub, a, b) => {
                let of = |n: &usize| Some(self.beside(id, *n)).filter(|n| self.is_choice(*n));
                of(a).or_else(|| of(b)).and_then(|n| self.undecided(n))
            }
            _ => None,
        }
    }

    /// Whether a node is made of multiplexers of known values only.
    fn is_choice(&self, id: usize) -> bool {
        match &self.node(id).op {
            Op::Mux(_, t, e) => [t, e].into_iter().all(|n| {
                let n = self.beside(id, *n);
                self.value(n).is_point() || self.is_choice(n)
            }),
            _ => false,
        }
    }

    /// The first undecided condition along the selected options.
    fn undecided(&self, id: usize) -> Option<usize> {
        let Op::Mux(c, t, e) = &self.node(id).op else {
            return None;
        };
        if self.fixed.contains(&id) {
            return None;
        }
        let c = self.beside(id, *c);
        match truth(self.value(c)) {
            None => (self.node(id).ty.width > 1).then_some(c),
            Some(true) => self.undecided(self.beside(id, *t)),
            Some(false) => self.undecided(self.beside(id, *e)),
        }
    }

    /// Adds the facts implied by the value of a bit.
    fn says(&self, bit: usize, so: bool, facts: &mut Vec<(usize, Interval)>) {
        let at = |n: &usize| self.beside(bit, *n);
        match &self.node(bit).op {
            Op::Unary(Unary::Not, a) => self.says(at(a), !so, facts),
            Op::Cast(a) | Op::Extend(a) => self.says(at(a), so, facts),
            Op::Binary(Binary::And, a, b) => {
                let [a, b] = [at(a), at(b)];
                if so {
                    self.says(a, true, facts);
                    self.says(b, true, facts);
                } else if truth(self.value(a)) == Some(true) {
                    self.says(b, false, facts);
                } else if truth(self.value(b)) == Some(true) {
                    self.says(a, false, facts);
                }
            }
            Op::Binary(Binary::Or, a, b) => {
                let [a, b] = [at(a), at(b)];
                if !so {
                    self.says(a, false, facts);
                    self.says(b, false, facts);
                } else if truth(self.value(a)) == Some(false) {
                    self.says(b, true, facts);
                } else if truth(self.value(b)) == Some(false) {
                    self.says(a, true, facts);
                }
            }
            Op::Mux(c, t, e) => match truth(self.value(at(c))) {
                Some(true) => self.says(at(t), so, facts),
                Some(false) => self.says(at(e), so, facts),
                None => {}
            },
            // The top bit says whether half of the range is reached.
            Op::Slice(a, low)
                if self.node(at(a)).ty == Ty::u(low + 1) && self.node(bit).ty.width == 1 =>
            {
                let a = at(a);
                let (half, own) = (BigInt::one() << low, self.value(a).clone());
                let fact = match so {
                    true => Interval {
                        high: own.high.max(half.clone()),
                        low: half,
                    },
                    false => Interval {
                        low: own.low.min(&half - 1u8),
                        high: half - 1u8,
                    },
                };
                facts.push((a, fact));
            }
            Op::Binary(op @ (Binary::Le | Binary::Lt), a, b) => {
                let [a, b] = [at(a), at(b)];
                let (x, y) = (self.value(a).clone(), self.value(b).clone());
                // Less or equal, or by one less; else the other way round.
                let (below, above, strict) = if so {
                    ((a, x), (b, y), *op == Binary::Lt)
                } else {
                    ((b, y), (a, x), *op == Binary::Le)
                };
                let one = u8::from(strict);
                let (low, high) = (&below.1.low + one, &above.1.high - one);
                let upper = Interval {
                    low: below.1.low.clone().min(high.clone()),
                    high,
                };
                let lower = Interval {
                    high: above.1.high.clone().max(low.clone()),
                    low,
                };
                facts.push((below.0, upper));
                facts.push((above.0, lower));
            }
            _ => {}
        }
    }

    /// Evaluates a node under facts; `None` where they contradict each other.
    fn under(&mut self, facts: &[(usize, Interval)], id: usize) -> Option<Found> {
        let (mut saved, mut possible) = (vec![], true);
        let outside = self.fixed.len();
        for (n, fact) in facts {
            let Some(met) = self.value(*n).meet(fact) else {
                possible = false;
                break;
            };
            self.save(*n, &mut saved);
            let off = self.off[*n].clone();
            self.keep(*n, met.clone(), met, off);
            self.fixed.push(*n);
        }
        let found = possible.then(|| {
            for n in self.node(id).op.operands() {
                self.renew(self.beside(id, n), outside, DEPTH, &mut saved);
            }
            self.result(id)
        });
        self.fixed.truncate(outside);
        while let Some((n, (value, whole, off))) = saved.pop() {
            self.keep(n, value, whole, off);
        }
        found
    }

    fn save(&self, id: usize, saved: &mut Vec<(usize, Found)>) {
        let unit = self.tree.unit_of[id];
        let at = id - self.tree.units[unit].first_node;
        let known = &self.known[unit];
        let was = (
            known.values[at].clone(),
            known.whole[at].clone(),
            self.off[id].clone(),
        );
        saved.push((id, was));
    }

    /// Propagates the last fixed value to a node. Returns whether it is reached.
    fn renew(
        &mut self,
        id: usize,
        outside: usize,
        depth: u32,
        saved: &mut Vec<(usize, Found)>,
    ) -> bool {
        if let Some(at) = self.fixed.iter().rposition(|n| *n == id) {
            return at >= outside;
        }
        let op = &self.node(id).op;
        if depth == 0 || matches!(op, Op::InstanceOut(..)) {
            return false;
        }
        let mut reached = false;
        for n in op.operands() {
            let n = self.beside(id, n);
            reached |= self.renew(n, outside, depth - 1, saved);
        }
        if reached {
            self.save(id, saved);
            let (value, whole, off) = self.result(id);
            self.keep(id, value, whole, off);
        }
        reached
    }
}
