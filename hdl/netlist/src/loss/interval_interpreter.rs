//! A hierarchy that runs on intervals.

use std::collections::BTreeMap;

use super::off::Off;
use super::transfer::Offs;
use crate::Module;
use crate::node::{Node, Op, Ty};
use crate::range::{Interval, Known, truth};
use crate::tree::Tree;

/// Runs what certain signals follow from, out of reset.
pub struct IntervalInterpreter<'a> {
    pub(super) tree: Tree<'a>,
    /// Nodes that count, each after those it needs.
    order: Vec<usize>,
    /// By unit.
    pub(super) known: Vec<Known>,
    /// By node; `None`: there is no bound.
    pub(super) off: Vec<Option<Off>>,
    inputs: BTreeMap<usize, Interval>,
    /// Nodes that changed since the cycle was followed.
    changed: Vec<bool>,
    /// A node that has less than all its values in this cycle.
    narrowed: Option<(usize, Interval)>,
    /// Nodes that are looked at with less than all their values.
    pub(super) fixed: Vec<usize>,
    /// Nodes that are read in parts.
    parts: Vec<usize>,
}

impl<'a> IntervalInterpreter<'a> {
    /// Nothing but what these signals, `instance.signal`, follow from is looked at.
    /// Of `parts` high bits are taken for decisions, and low ones for what is left.
    pub fn new(module: &'a Module, signals: &[&str], parts: &[&str]) -> Option<Self> {
        let mut tree = Tree::default();
        tree.add(module, None);
        let known = tree.units.iter().map(|u| Known::of(u.module)).collect();
        let off = vec![None; tree.unit_of.len()];
        let changed = vec![true; off.len()];
        let mut machine = Self {
            tree,
            order: vec![],
            known,
            off,
            inputs: BTreeMap::new(),
            changed,
            narrowed: None,
            fixed: vec![],
            parts: vec![],
        };
        let parts: Option<Vec<_>> = parts.iter().map(|s| machine.find(s)).collect();
        machine.parts = parts?;
        let found: Option<Vec<_>> = signals.iter().map(|s| machine.find(s)).collect();
        machine.order = machine.cone(found?);
        machine.reset();
        Some(machine)
    }

    /// The number of a named signal or port: `instance.instance.signal`.
    #[must_use]
    pub fn find(&self, path: &str) -> Option<usize> {
        let mut parts: Vec<&str> = path.split('.').collect();
        let name = parts.pop()?;
        let mut unit = &self.tree.units[0];
        for part in parts {
            let at = unit.module.instances.iter().position(|i| i.name == part)?;
            unit = &self.tree.units[unit.children[at]];
        }
        let module = unit.module;
        let port = module.ports.iter().find(|p| p.name == name).map(|p| p.node);
        let named = || {
            let mut nodes = module.nodes.iter();
            nodes.position(|n| n.name.as_deref() == Some(name))
        };
        Some(unit.first_node + port.or_else(named)?)
    }

    /// What these follow from, through registers too, in the order of the cycle.
    fn cone(&self, roots: Vec<usize>) -> Vec<usize> {
        let mut counts = vec![false; self.off.len()];
        let mut todo = roots;
        while let Some(id) = todo.pop() {
            if !std::mem::replace(&mut counts[id], true) {
                todo.extend(self.tree.needs(id));
                let (unit, at) = self.tree.find(id);
                let edge = unit.module.nodes[at].op.edge_operands();
                todo.extend(edge.into_iter().map(|n| unit.first_node + n));
            }
        }
        let (mut order, mut done) = (vec![], vec![false; counts.len()]);
        let mut stack: Vec<(usize, bool)> = vec![];
        for start in (0..counts.len()).filter(|id| counts[*id]) {
            stack.push((start, false));
            while let Some((id, ready)) = stack.pop() {
                if done[id] {
                    continue;
                }
                if ready {
                    done[id] = true;
                    order.push(id);
                } else {
                    stack.push((id, true));
                    stack.extend(self.tree.needs(id).into_iter().map(|n| (n, false)));
                }
            }
        }
        order
    }

    /// What a node computes; its operands are found by [`Self::beside`].
    #[must_use]
    pub fn op(&self, id: usize) -> &Op {
        &self.node(id).op
    }

    /// The type of a node.
    #[must_use]
    pub fn ty(&self, id: usize) -> Ty {
        self.node(id).ty
    }

    pub(super) fn node(&self, id: usize) -> &Node {
        let (unit, at) = self.tree.find(id);
        &unit.module.nodes[at]
    }

    /// The operand of a node, by the number it has there.
    #[must_use]
    pub fn beside(&self, id: usize, operand: usize) -> usize {
        self.tree.find(id).0.first_node + operand
    }

    /// The values of a node in this cycle.
    #[must_use]
    pub fn value(&self, id: usize) -> &Interval {
        let unit = self.tree.unit_of[id];
        &self.known[unit].values[id - self.tree.units[unit].first_node]
    }

    /// How far a node is off, if that is bounded: least and most, in last places, rounded
    /// outwards.
    #[must_use]
    pub fn off(&self, id: usize) -> Option<[f64; 2]> {
        self.off[id].as_ref().map(Off::bounds)
    }

    /// What an input of the module is from now on.
    pub fn set(&mut self, id: usize, value: Interval) {
        self.inputs.insert(id, value);
    }

    pub(super) fn keep(&mut self, id: usize, value: Interval, whole: Interval, off: Option<Off>) {
        let unit = self.tree.unit_of[id];
        let at = id - self.tree.units[unit].first_node;
        self.known[unit].values[at] = value;
        self.known[unit].whole[at] = whole;
        self.off[id] = off;
    }

    /// Registers as they are after reset.
    pub fn reset(&mut self) {
        for at in 0..self.order.len() {
            let id = self.order[at];
            if let Op::Reg { reset, .. } = &self.node(id).op {
                let reset = Interval::point(reset);
                self.take_over(id, reset, Some(Off::none()));
            }
        }
    }

    /// Keeps a value, and notes whether it is another.
    fn take_over(&mut self, id: usize, value: Interval, off: Option<Off>) {
        self.changed[id] |= *self.value(id) != value || self.off[id] != off;
        self.keep(id, value.clone(), value, off);
    }

    /// Follows the inputs and registers through the cycle.
    pub fn settle(&mut self) {
        for at in 0..self.order.len() {
            self.follow(self.order[at]);
        }
        self.changed.fill(false);
    }

    fn follow(&mut self, id: usize) {
        let needs = self.tree.needs(id);
        let node = self.node(id);
        if !self.changed[id] && !needs.is_empty() && !needs.iter().any(|n| self.changed[*n]) {
            return;
        }
        match &node.op {
            Op::Reg { .. } => {}
            Op::Input | Op::OutOfReset | Op::InstanceOut(..) => match needs.first() {
                Some(source) => {
                    let (value, off) = (self.value(*source).clone(), self.off[*source].clone());
                    self.take_over(id, value, off);
                }
                None => {
                    let all = || Interval::all(node.ty);
                    let value = self.inputs.get(&id).cloned().unwrap_or_else(all);
                    self.take_over(id, value, Some(Off::none()));
                }
            },
            Op::ReadSync(..) | Op::ReadAsync(..) => {
                self.take_over(id, Interval::all(node.ty), None);
            }
            Op::Lit(_) if !self.changed[id] => {}
            _ => {
                let (mut value, mut whole, off) = self.result(id);
                if let Some((at, to)) = &self.narrowed
                    && *at == id
                    && let Some(both) = value.meet(to)
                {
                    (value, whole) = (both.clone(), both);
                }
                let unit = self.tree.unit_of[id];
                let before = &self.known[unit].whole[id - self.tree.units[unit].first_node];
                self.changed[id] |=
                    *before != whole || *self.value(id) != value || self.off[id] != off;
                self.keep(id, value, whole, off);
            }
        }
    }

    /// A node as its operands are, whatever they have to do with each other.
    pub(super) fn plain(&self, id: usize) -> (Interval, Interval, Option<Off>) {
        let unit = self.tree.unit_of[id];
        let (of, known) = (&self.tree.units[unit], &self.known[unit]);
        let at = id - of.first_node;
        let whole = known.result(of.module, at);
        let offs = Offs {
            module: of.module,
            known,
            off: &self.off,
            parts: &self.parts,
            first: of.first_node,
        };
        let off = offs.of(at, &whole);
        (whole.wrap(of.module.nodes[at].ty), whole, off)
    }

    /// What is known of a node in this cycle beside what intervals say; `None` where they
    /// contradict each other.
    pub fn narrow(&mut self, id: usize, to: &Interval) -> Option<()> {
        self.value(id).meet(to)?;
        self.narrowed = Some((id, to.clone()));
        self.changed[id] = true;
        self.settle();
        Some(())
    }

    /// Registers take over what they may.
    pub fn clock(&mut self) {
        if let Some((id, _)) = self.narrowed.take() {
            self.changed[id] = true;
        }
        let mut taken = vec![];
        for &id in &self.order {
            let Op::Reg { next, enable, .. } = &self.node(id).op else {
                continue;
            };
            let Some(next) = next.map(|n| self.beside(id, n)) else {
                continue;
            };
            let enabled = enable.map_or(Some(true), |e| truth(self.value(self.beside(id, e))));
            let new = self.value(next).clone();
            let off = self.off[next].as_ref().map(Off::alone);
            match enabled {
                Some(true) => taken.push((id, new, off)),
                Some(false) => {}
                None => {
                    let both = new.join(self.value(id));
                    let off = off.zip(self.off[id].as_ref()).map(|(a, b)| a.join(b));
                    taken.push((id, both, off));
                }
            }
        }
        for (id, value, off) in taken {
            self.take_over(id, value, off);
        }
    }
}
