//! Registers whose range follows from what they are declared to hold.
//!
//! A contract declares a count (at most so many terms, or codes that sum to
//! at most so much), which no interval can see. Everything else is derived:
//! that the register only ever holds a value, starts again, or adds a declared
//! term, and that the count times the term's range fits every node on the way.

use num_bigint::BigInt;
use num_traits::Zero;

use super::Interval;
use super::transfer::{NodeIntervals, power};
use crate::Module;
use crate::node::{Binary, Contract, Op};

/// A contract of a register, with its evidence in the netlist.
#[derive(Debug, Clone)]
pub(super) struct Claim {
    pub(super) reg: usize,
    pub(super) why: String,
    part: Part,
    /// Sums and terms that are in the register's range when they are used.
    pub(super) sums: Vec<usize>,
    /// Restart values of the register.
    pub(super) starts: Vec<usize>,
    /// Other next values, which the contract does not explain.
    pub(super) strange: Vec<usize>,
    /// Reinterpretations along the path, which must not change the value.
    pub(super) kept: Vec<usize>,
}

#[derive(Debug, Clone)]
enum Part {
    Terms { term: usize, most: BigInt },
    Weighted { feature: usize, total: BigInt },
}

impl Claim {
    /// The claim of a contract on a register.
    pub(super) fn of(module: &Module, contract: &Contract) -> Option<Self> {
        let (reg, part, why) = match contract {
            Contract::Range { .. } => return None,
            Contract::Terms {
                reg,
                term,
                most,
                why,
            } => {
                let most = BigInt::from(*most);
                (*reg, Part::Terms { term: *term, most }, why)
            }
            Contract::Weighted {
                reg,
                feature,
                total,
                why,
            } => {
                let (feature, total) = (*feature, total.clone());
                (*reg, Part::Weighted { feature, total }, why)
            }
        };
        let mut claim = Self {
            reg,
            why: why.clone(),
            part,
            sums: vec![],
            starts: vec![],
            strange: vec![],
            kept: vec![],
        };
        match &module.nodes.get(reg)?.op {
            Op::Reg {
                next: Some(next), ..
            } => {
                let on_reg = dependents(module, reg);
                claim.take(module, reg, *next, &on_reg);
            }
            _ => claim.strange.push(reg),
        }
        Some(claim)
    }

    /// Range of the register.
    pub(super) fn bound(&self, known: &NodeIntervals) -> Interval {
        match &self.part {
            Part::Terms { term, most } => known.values[*term].up_to(most),
            Part::Weighted { feature, total } => known.values[*feature].up_to(total),
        }
    }

    /// Text of the contract for messages.
    pub(super) fn promise(&self) -> String {
        match &self.part {
            Part::Terms { most, .. } => format!("at most {most} terms"),
            Part::Weighted { total, .. } => format!("codes that sum to at most {total}"),
        }
    }

    /// Classifies one possible next value of the register.
    fn take(&mut self, module: &Module, user: usize, id: usize, on_reg: &[bool]) {
        if id == self.reg {
            return;
        }
        if self.tries(|this| this.is_term(module, user, id)) {
            return;
        }
        if !on_reg[id] {
            self.starts.push(id);
            return;
        }
        self.enter(module, user, id);
        match &module.nodes[id].op {
            Op::Mux(_, t, e) => {
                self.take(module, id, *t, on_reg);
                self.take(module, id, *e, on_reg);
            }
            Op::Select(_, options) => {
                for o in options {
                    self.take(module, id, *o, on_reg);
                }
            }
            Op::Cast(a) | Op::Extend(a) | Op::Slice(a, 0) => self.take(module, id, *a, on_reg),
            Op::Binary(Binary::Add, a, b) => {
                let (held, term) = if on_reg[*a] { (*a, *b) } else { (*b, *a) };
                if self
                    .tries(|this| this.is_held(module, id, held) && this.is_term(module, id, term))
                {
                    self.sums.push(id);
                } else {
                    self.strange.push(id);
                }
            }
            _ => self.strange.push(id),
        }
    }

    /// Tries a path, and discards its evidence on failure.
    fn tries(&mut self, way: impl Fn(&mut Self) -> bool) -> bool {
        let (sums, kept) = (self.sums.len(), self.kept.len());
        let found = way(self);
        if !found {
            self.sums.truncate(sums);
            self.kept.truncate(kept);
        }
        found
    }

    /// Records the last of a chain of reinterpretations.
    fn enter(&mut self, module: &Module, user: usize, id: usize) {
        let bits = |n: usize| {
            matches!(
                module.nodes[n].op,
                Op::Cast(_) | Op::Slice(_, 0) | Op::Cat(_)
            )
        };
        if bits(id) && !bits(user) {
            self.kept.push(id);
        }
    }

    /// Whether a node is the register, or a choice of it and 0.
    fn is_held(&mut self, module: &Module, user: usize, id: usize) -> bool {
        let reg = self.reg;
        self.leads(module, user, id, false, &mut |_, n| n == reg)
    }

    /// Whether a node is a declared term, or a choice of it and 0, also from earlier cycles.
    fn is_term(&mut self, module: &Module, user: usize, id: usize) -> bool {
        match self.part.clone() {
            Part::Terms { term, .. } => self.leads(module, user, id, true, &mut |_, n| n == term),
            Part::Weighted { feature, total } => {
                self.leads(module, user, id, true, &mut |this, n| {
                    let mut is_feature =
                        |a| this.leads(module, n, a, true, &mut |_, m| m == feature);
                    match &module.nodes[n].op {
                        Op::Binary(Binary::Mul, a, b) => {
                            let found = is_feature(*a) || is_feature(*b);
                            if found {
                                this.sums.push(n);
                            }
                            found
                        }
                        // The feature with a weight that is a power of two.
                        Op::Cat(parts) => {
                            let low = &parts[1..];
                            let bits = low.iter().map(|p| module.nodes[*p].ty.width).sum();
                            low.iter().all(|p| zero(module, *p))
                                && power(bits) <= total
                                && is_feature(parts[0])
                        }
                        _ => false,
                    }
                })
            }
        }
    }

    /// Whether a node is one that `is` accepts, or 0, for any control; with `late` also through
    /// registers.
    fn leads(
        &mut self,
        module: &Module,
        user: usize,
        id: usize,
        late: bool,
        is: &mut dyn FnMut(&mut Self, usize) -> bool,
    ) -> bool {
        self.enter(module, user, id);
        if is(self, id) {
            return true;
        }
        match &module.nodes[id].op {
            Op::Cast(a) | Op::Extend(a) | Op::Slice(a, 0) => self.leads(module, id, *a, late, is),
            Op::Mux(_, t, e) => {
                let (no_t, no_e) = (zero(module, *t), zero(module, *e));
                !(no_t && no_e)
                    && (no_t || self.leads(module, id, *t, late, is))
                    && (no_e || self.leads(module, id, *e, late, is))
            }
            Op::Binary(Binary::And, a, b) => {
                let mask = |n: usize| matches!(module.nodes[n].op, Op::Repeat(bit, _) if module.nodes[bit].ty.width == 1);
                (mask(*a) && self.leads(module, id, *b, late, is))
                    || (mask(*b) && self.leads(module, id, *a, late, is))
            }
            // Only registers that stand after their source, so that this ends.
            Op::Reg {
                reset,
                next: Some(next),
                ..
            } => {
                late && reset.as_ref().is_none_or(BigInt::is_zero)
                    && *next < id
                    && self.leads(module, id, *next, late, is)
            }
            _ => false,
        }
    }
}

fn zero(module: &Module, id: usize) -> bool {
    matches!(&module.nodes[id].op, Op::Lit(v) if v.is_zero())
}

/// Nodes with a combinational path from this one.
fn dependents(module: &Module, id: usize) -> Vec<bool> {
    let mut on = vec![false; module.nodes.len()];
    on[id] = true;
    // Again while something was found, because instances may be connected to
    // nodes that stand after them.
    let mut found = true;
    while std::mem::take(&mut found) {
        for (n, node) in module.nodes.iter().enumerate().filter(|(n, _)| *n != id) {
            let now = match &node.op {
                Op::InstanceOut(i, _) => module.instances[*i].inputs.iter().any(|(_, s)| on[*s]),
                op => op.operands().iter().any(|o| on[*o]),
            };
            found |= now && !on[n];
            on[n] |= now;
        }
    }
    on
}
