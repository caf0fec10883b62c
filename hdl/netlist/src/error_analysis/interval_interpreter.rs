//! Interpreter of a hierarchy on intervals.

use std::collections::BTreeMap;

use super::node_error::NodeError;
use super::transfer::NodeErrors;
use crate::Module;
use crate::node::{Node, Op, Ty};
use crate::range::{Interval, NodeIntervals, truth};
use crate::tree::Tree;

/// Interprets the cone of certain signals on intervals, out of reset.
pub struct IntervalInterpreter<'a> {
    pub(super) tree: Tree<'a>,
    /// Nodes of the cone in topological order.
    order: Vec<usize>,
    /// Nodes with a combinational path to each of them.
    needs: Vec<Box<[usize]>>,
    /// Values by unit.
    pub(super) known: Vec<NodeIntervals>,
    /// Errors by node; `None`: unbounded.
    pub(super) off: Vec<Option<NodeError>>,
    inputs: BTreeMap<usize, Interval>,
    /// Nodes that changed since the cycle was last evaluated.
    changed: Vec<bool>,
    /// A node restricted to a part of its values in this cycle.
    narrowed: Option<(usize, Interval)>,
    /// Nodes evaluated with a part of their values.
    pub(super) fixed: Vec<usize>,
    /// Nodes read in parts.
    parts: Vec<usize>,
}

impl<'a> IntervalInterpreter<'a> {
    /// An interpreter for the cone of `signals`, given as `instance.signal`. Of `parts`, high bits
    /// count as decisions and low bits as remainder.
    pub fn new(module: &'a Module, signals: &[&str], parts: &[&str]) -> Option<Self> {
        let mut tree = Tree::default();
        tree.add(module, None);
        let known = tree
            .units
            .iter()
            .map(|u| NodeIntervals::of(u.module))
            .collect();
        let off = vec![None; tree.unit_of.len()];
        let changed = vec![true; off.len()];
        let mut machine = Self {
            tree,
            order: vec![],
            needs: vec![],
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
        let needs = machine
            .order
            .iter()
            .map(|id| machine.tree.needs(*id).into());
        machine.needs = needs.collect();
        machine.reset();
        Some(machine)
    }

    /// Number of a signal or port with the hierarchical name `instance.instance.signal`.
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

    /// The cone of `roots`, through registers too, in topological order.
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

    /// Operation of a node; [`Self::beside`] finds its operands.
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

    /// An operand of a node, by its number there.
    #[must_use]
    pub fn beside(&self, id: usize, operand: usize) -> usize {
        self.tree.find(id).0.first_node + operand
    }

    /// Values of a node in this cycle.
    #[must_use]
    pub fn value(&self, id: usize) -> &Interval {
        let unit = self.tree.unit_of[id];
        &self.known[unit].values[id - self.tree.units[unit].first_node]
    }

    /// Smallest and largest error of a node in ulp, rounded outwards; `None` if unbounded.
    #[must_use]
    pub fn off(&self, id: usize) -> Option<[f64; 2]> {
        self.off[id].as_ref().map(NodeError::bounds)
    }

    /// Sets an input of the module.
    pub fn set(&mut self, id: usize, value: Interval) {
        self.inputs.insert(id, value);
    }

    pub(super) fn keep(
        &mut self,
        id: usize,
        value: Interval,
        whole: Interval,
        off: Option<NodeError>,
    ) {
        let unit = self.tree.unit_of[id];
        let at = id - self.tree.units[unit].first_node;
        self.known[unit].values[at] = value;
        self.known[unit].whole[at] = whole;
        self.off[id] = off;
    }

    /// Resets the registers.
    pub fn reset(&mut self) {
        for at in 0..self.order.len() {
            let id = self.order[at];
            if let Op::Reg { reset, .. } = &self.node(id).op {
                let reset = reset.as_ref().map_or_else(Interval::zero, Interval::point);
                self.take_over(id, reset, Some(NodeError::none()));
            }
        }
    }

    /// Stores a value, and notes whether it changed.
    fn take_over(&mut self, id: usize, value: Interval, off: Option<NodeError>) {
        self.changed[id] |= *self.value(id) != value || self.off[id] != off;
        self.keep(id, value.clone(), value, off);
    }

    /// Evaluates the cycle for the current inputs and registers.
    pub fn settle(&mut self) {
        for at in 0..self.order.len() {
            self.follow(at);
        }
        self.changed.fill(false);
    }

    /// Evaluates a node, by its place in the order.
    fn follow(&mut self, at: usize) {
        let (id, needs) = (self.order[at], &self.needs[at]);
        if !self.changed[id] && !needs.is_empty() && !needs.iter().any(|n| self.changed[*n]) {
            return;
        }
        let source = needs.first().copied();
        let node = self.node(id);
        match &node.op {
            Op::Reg { .. } => {}
            Op::Input | Op::OutOfReset | Op::InstanceOut(..) => match source {
                Some(source) => {
                    let (value, off) = (self.value(source).clone(), self.off[source].clone());
                    self.take_over(id, value, off);
                }
                None => {
                    let all = || Interval::all(node.ty);
                    let value = self.inputs.get(&id).cloned().unwrap_or_else(all);
                    self.take_over(id, value, Some(NodeError::none()));
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

    /// Evaluates a node from its operands, taken as independent.
    pub(super) fn plain(&self, id: usize) -> (Interval, Interval, Option<NodeError>) {
        let unit = self.tree.unit_of[id];
        let (of, known) = (&self.tree.units[unit], &self.known[unit]);
        let at = id - of.first_node;
        let whole = known.result(of.module, at);
        let offs = NodeErrors {
            module: of.module,
            known,
            off: &self.off,
            parts: &self.parts,
            first: of.first_node,
        };
        let off = offs.of(at, &whole);
        (whole.wrap(of.module.nodes[at].ty), whole, off)
    }

    /// Restricts a node's values in this cycle; `None` for a contradiction.
    pub fn narrow(&mut self, id: usize, to: &Interval) -> Option<()> {
        self.value(id).meet(to)?;
        self.narrowed = Some((id, to.clone()));
        self.changed[id] = true;
        self.settle();
        Some(())
    }

    /// Applies the clock edge to all registers.
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
            let off = self.off[next].as_ref().map(NodeError::alone);
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
