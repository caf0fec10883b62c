//! Computes the intervals of a module's nodes, registers included.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::Interval;
use super::contract::Claim;
use super::order::order;
use super::transfer::{NodeIntervals, can_wrap, truth};
use crate::node::{Contract, Op};
use crate::{IrError, Module};

/// Growths of a register's range after which it is widened to its type.
const PATIENCE: u32 = 8;

/// Ranges of a module's nodes for given ranges of its inputs.
#[derive(Debug)]
pub(crate) struct ModuleRanges {
    pub(crate) values: Vec<Interval>,
    /// Nodes with declared ranges, which must hold only when their value is used.
    pub(crate) claimed: Vec<bool>,
    pub(crate) instances: Vec<Arc<ModuleRanges>>,
    pub(super) errors: Vec<IrError>,
}

/// Cache of results by module and input ranges.
#[derive(Default)]
pub(super) struct Analyser {
    found: BTreeMap<(usize, Vec<Interval>), Arc<ModuleRanges>>,
}

/// A module during the fixed-point iteration.
struct Work<'a> {
    module: &'a Module,
    known: NodeIntervals,
    claims: Vec<Claim>,
    /// Claim of each node, if any.
    claim_of: BTreeMap<usize, usize>,
    assumed: BTreeMap<usize, Interval>,
    instances: Vec<Option<Arc<ModuleRanges>>>,
    /// Nodes in topological order.
    order: Vec<usize>,
    /// Inputs of instances, by instance and port, that depend on outputs of the same instance:
    /// their range is taken as unlimited.
    looped: BTreeSet<(usize, usize)>,
    changed: Vec<bool>,
    /// Whether every node was visited once.
    seen: bool,
    grown: BTreeMap<usize, u32>,
}

impl Analyser {
    /// Ranges of a module for input ranges in the order of its ports.
    pub(super) fn module(
        &mut self,
        module: &Arc<Module>,
        inputs: &[Interval],
    ) -> Arc<ModuleRanges> {
        let key = (Arc::as_ptr(module) as usize, inputs.to_vec());
        if let Some(known) = self.found.get(&key) {
            return known.clone();
        }
        let mut work = Work::new(module, inputs);
        while work.pass(self) {}
        let ranges = Arc::new(work.finish());
        self.found.insert(key, ranges.clone());
        ranges
    }
}

/// Declared range of a node, if any.
pub(crate) fn assumption(module: &Module, id: usize) -> Option<Interval> {
    let all = module.contracts.iter().filter_map(|c| match c {
        Contract::Range {
            node, low, high, ..
        } if *node == id => Some(Interval::new(low.clone(), high.clone())),
        _ => None,
    });
    all.reduce(|a, b| a.meet(&b).unwrap_or(a))
}

impl<'a> Work<'a> {
    fn new(module: &'a Module, inputs: &[Interval]) -> Self {
        let mut values: Vec<_> = module.nodes.iter().map(|n| Interval::all(n.ty)).collect();
        let given = module.ports.iter().filter(|p| !p.output).zip(inputs);
        for (port, i) in given {
            values[port.node] = i.clone();
        }
        for (id, node) in module.nodes.iter().enumerate() {
            if let Op::Reg { reset, .. } = &node.op {
                values[id] = reset.as_ref().map_or_else(Interval::zero, Interval::point);
            }
        }
        let claims: Vec<_> = module
            .contracts
            .iter()
            .filter_map(|c| Claim::of(module, c))
            .collect();
        let mut claim_of = BTreeMap::new();
        for (i, claim) in claims.iter().enumerate() {
            claim_of.extend(claim.sums.iter().map(|n| (*n, i)));
        }
        let (order, looped) = order(module);
        let assumed = (0..module.nodes.len())
            .filter_map(|id| Some((id, assumption(module, id)?)))
            .collect();
        Self {
            module,
            known: NodeIntervals {
                whole: values.clone(),
                values,
            },
            claims,
            claim_of,
            assumed,
            instances: vec![None; module.instances.len()],
            order,
            looped,
            changed: vec![true; module.nodes.len()],
            seen: false,
            grown: BTreeMap::new(),
        }
    }

    /// Visits all nodes whose operands changed. Returns whether a register grew.
    fn pass(&mut self, all: &mut Analyser) -> bool {
        let mut renewed: Vec<Option<bool>> = vec![None; self.instances.len()];
        for id in self.order.clone() {
            let node = &self.module.nodes[id];
            if let Op::InstanceOut(i, _) = &node.op
                && renewed[*i].is_none()
            {
                renewed[*i] = Some(self.instance(*i, all));
            }
            let claimed = self.claim_of.contains_key(&id);
            let due = match &node.op {
                Op::Reg { .. } | Op::Input | Op::ReadSync(..) | Op::ReadAsync(..) | Op::Lit(_) => {
                    self.changed[id]
                }
                Op::InstanceOut(i, _) => renewed[*i] == Some(true),
                op => claimed || op.operands().iter().any(|o| self.changed[*o]),
            };
            if self.seen && !due {
                self.changed[id] = false;
                continue;
            }
            let mut whole = match &node.op {
                Op::InstanceOut(i, port) => {
                    let inner = &self.module.instances[*i].module.ports[*port];
                    let ranges = self.instances[*i].as_ref();
                    ranges.map_or_else(|| Interval::all(node.ty), |r| r.values[inner.node].clone())
                }
                Op::Reg { .. } | Op::Input | Op::ReadSync(..) | Op::ReadAsync(..) => {
                    self.known.values[id].clone()
                }
                _ => self.known.result(self.module, id),
            };
            if let Some(claim) = self.claim_of.get(&id) {
                let bound = self.claims[*claim].bound(&self.known);
                whole = whole.meet(&bound).unwrap_or(bound);
            }
            let mut value = whole.wrap(node.ty);
            if let Some(assumed) = self.assumed.get(&id) {
                value = value.meet(assumed).unwrap_or_else(|| assumed.clone());
                whole = value.clone();
            }
            self.changed[id] = !self.seen
                || self.changed[id] && matches!(node.op, Op::Reg { .. })
                || value != self.known.values[id]
                || whole != self.known.whole[id];
            self.known.values[id] = value;
            self.known.whole[id] = whole;
        }
        for i in 0..renewed.len() {
            if renewed[i].is_none() {
                self.instance(i, all);
            }
        }
        self.seen = true;
        self.edge()
    }

    /// Updates an instance's ranges if its inputs changed.
    fn instance(&mut self, index: usize, all: &mut Analyser) -> bool {
        let inst = &self.module.instances[index];
        let known = self.instances[index].is_some();
        if known && !inst.inputs.iter().any(|(_, n)| self.changed[*n]) {
            return false;
        }
        let inner = &inst.module;
        let inputs: Vec<_> = inner
            .ports
            .iter()
            .enumerate()
            .filter(|(_, p)| !p.output)
            .map(|(i, port)| {
                let looped = self.looped.contains(&(index, i));
                let source = inst.inputs.iter().find(|(p, _)| *p == i && !looped);
                let given = source.map(|(_, n)| self.known.values[*n].clone());
                given.unwrap_or_else(|| Interval::all(inner.nodes[port.node].ty))
            })
            .collect();
        self.instances[index] = Some(all.module(inner, &inputs));
        true
    }

    /// Applies the clock edge to all registers. Returns whether one grew.
    fn edge(&mut self) -> bool {
        let mut any = false;
        self.changed.fill(false);
        for (id, node) in self.module.nodes.iter().enumerate() {
            let Op::Reg { next, enable, .. } = &node.op else {
                continue;
            };
            let old = &self.known.values[id];
            let claim = self.claims.iter().find(|c| c.reg == id);
            let idle = enable.is_some_and(|e| truth(&self.known.values[e]) == Some(false));
            let taken = match (claim, next) {
                (Some(claim), _) => claim.bound(&self.known),
                (None, Some(next)) if !idle => self.known.values[*next].clone(),
                _ => continue,
            };
            let all = Interval::all(node.ty);
            let mut grown = old.join(&taken).meet(&all).unwrap_or_else(|| all.clone());
            if grown == *old {
                continue;
            }
            let times = self.grown.entry(id).or_default();
            *times += 1;
            if *times > PATIENCE {
                grown = all;
            }
            self.known.values[id] = grown;
            self.changed[id] = true;
            any = true;
        }
        any
    }

    /// Ranges found, and violations.
    fn finish(self) -> ModuleRanges {
        let mut errors = vec![];
        let module = self.module;
        let mut fail = |id: usize, problem: String| {
            errors.push(IrError {
                module: module.name.clone(),
                node: name(module, id),
                problem,
            });
        };
        let wider = |i: &Interval, id: usize| i.ty(module.nodes[id].ty.signed);
        for (id, node) in module.nodes.iter().enumerate() {
            let whole = &self.known.whole[id];
            let claimed = self.claim_of.contains_key(&id);
            if node.exact && !claimed && can_wrap(&node.op) && !whole.fits(node.ty) {
                let (ty, fit) = (node.ty, wider(whole, id));
                fail(
                    id,
                    format!("is to be exact, but {ty} does not hold {whole}; {fit} would do"),
                );
            }
        }
        for (id, assumed) in &self.assumed {
            let ty = module.nodes[*id].ty;
            if assumed.low > assumed.high || !assumed.fits(ty) {
                fail(
                    *id,
                    format!("is declared to be {assumed}, which is not a range of {ty}"),
                );
            }
        }
        for claim in &self.claims {
            self.judge(claim, &mut fail);
        }
        for inst in &module.instances {
            for (port, n) in &inst.inputs {
                let port = &inst.module.ports[*port];
                let value = &self.known.values[*n];
                if let Some(assumed) = assumption(&inst.module, port.node)
                    && !value.within(&assumed)
                {
                    let (inner, of) = (&inst.module.name, &inst.name);
                    fail(
                        *n,
                        format!(
                            "input {} of instance {of} is {value}, but {inner} relies on {assumed}",
                            port.name
                        ),
                    );
                }
            }
        }
        let mut claimed = vec![false; module.nodes.len()];
        for id in self.claim_of.keys() {
            claimed[*id] = true;
        }
        for id in self.assumed.keys() {
            claimed[*id] |= !matches!(module.nodes[*id].op, Op::Input);
        }
        ModuleRanges {
            values: self.known.values,
            claimed,
            instances: self.instances.into_iter().flatten().collect(),
            errors,
        }
    }

    /// Checks that a contract's range holds inductively.
    fn judge(&self, claim: &Claim, fail: &mut dyn FnMut(usize, String)) {
        let nodes = &self.module.nodes;
        let bound = claim.bound(&self.known);
        let promise = format!("{} ({})", claim.promise(), claim.why);
        let reg = name(self.module, claim.reg);
        let ty = nodes[claim.reg].ty;
        if !bound.fits(ty) {
            let fit = bound.ty(ty.signed);
            fail(
                claim.reg,
                format!("holds {promise}: {bound}, which {ty} does not hold; {fit} would do"),
            );
            return;
        }
        if let Op::Reg {
            reset: Some(reset), ..
        } = &nodes[claim.reg].op
            && !bound.contains(reset)
        {
            fail(
                claim.reg,
                format!("resets to {reset}, outside {bound} that follows from {promise}"),
            );
        }
        for id in &claim.strange {
            fail(
                *id,
                format!(
                    "{reg} is declared to hold {promise}, but takes this over, which is neither a \
                     fresh value nor {reg} plus a declared term"
                ),
            );
        }
        for id in &claim.starts {
            let value = &self.known.values[*id];
            if !value.within(&bound) {
                fail(
                    *id,
                    format!(
                        "{reg} starts again from this, {value}, outside {bound} that follows from {promise}"
                    ),
                );
            }
        }
        for id in claim.sums.iter().chain(&claim.kept) {
            let (whole, ty) = (&self.known.whole[*id], nodes[*id].ty);
            if !whole.fits(ty) {
                let fit = whole.ty(ty.signed);
                fail(
                    *id,
                    format!(
                        "{reg} is summed up through this, {whole}, which {ty} does not hold; {fit} would do"
                    ),
                );
            }
        }
    }
}

/// Name of a node in messages: its own, or one made of its operands.
fn name(module: &Module, id: usize) -> String {
    let node = &module.nodes[id];
    if let Some(name) = &node.name {
        return name.clone();
    }
    let port = module.ports.iter().find(|p| p.node == id);
    if let Some(port) = port {
        return port.name.clone();
    }
    let operands = node.op.operands();
    let of: Vec<_> = operands
        .iter()
        .map(|o| {
            module.nodes[*o]
                .name
                .as_deref()
                .unwrap_or("an unnamed node")
        })
        .collect();
    if of.is_empty() {
        format!("unnamed node {id}")
    } else {
        format!("unnamed node {id} of {}", of.join(", "))
    }
}
