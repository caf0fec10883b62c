//! Checks of a module: assertions, assumptions and cover points, with the logic that only they use.
//!
//! That logic, the *ghosts*, is kept apart from the nodes of the module, so that nothing but the
//! printer ever sees it: it changes no digest, no simulation and no synthesis.

mod formula;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::Module;
use crate::node::{Node, Op};

pub(crate) use formula::{Formula, parse};

/// What is said of a condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CheckKind {
    /// A property: the condition always holds.
    Assert,
    /// A condition that always holds, and is there to support the proof of others.
    Invariant,
    /// What the module expects of its inputs: assumed of the ports of a top module, asserted of the
    /// ports of an instance.
    Assume,
    /// The condition holds at some time.
    Cover,
}

/// A check.
#[derive(Debug, Clone)]
pub(crate) struct Check {
    pub(crate) kind: CheckKind,
    pub(crate) name: String,
    pub(crate) doc: String,
    /// One bit, of the joined nodes.
    pub(crate) node: usize,
}

/// Where the value of a ghost comes from that nothing in the module computes.
#[derive(Debug, Clone)]
pub(crate) enum Source {
    /// Any constant: a proof holds for all values, a simulation takes one.
    Free,
    /// Whether checks count in this clock, `checking`.
    Checking,
    /// A signal within an instance, by its name there.
    Inside { instance: usize, name: String },
    /// Whether two payloads are the same.
    Same {
        a: usize,
        b: usize,
        /// A proof may not compare one bit of them.
        whole: bool,
        /// In a simulation X is the same as X.
        takes_x: bool,
    },
}

impl Source {
    /// Nodes that it reads.
    pub(crate) fn operands(&self) -> Vec<usize> {
        match self {
            Self::Free | Self::Checking | Self::Inside { .. } => vec![],
            Self::Same { a, b, .. } => vec![*a, *b],
        }
    }
}

/// The checks of a module.
#[derive(Debug, Clone, Default)]
pub(crate) struct Checks {
    /// Number of nodes of the module. Indices from here on are those of ghosts.
    pub(crate) base: usize,
    pub(crate) ghosts: Vec<Node>,
    /// Sources of the ghosts that are inputs.
    pub(crate) sources: BTreeMap<usize, Source>,
    pub(crate) list: Vec<Check>,
}

/// A check, for a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CheckInfo {
    /// Names of the instances from the top module on, and the name of the check, joined by dots.
    pub path: String,
    /// The module that states it.
    pub module: String,
    /// What is said.
    pub kind: CheckKind,
    /// The property in words.
    pub doc: String,
}

impl Checks {
    /// The module with the ghosts among its nodes, and the number of its own nodes. A fault may have
    /// added nodes to it since the checks were made.
    pub(crate) fn joined(&self, module: &Module) -> Module {
        let mut joined = module.clone();
        let shift = module.nodes.len() - self.base;
        let moved = |id: &mut usize| {
            if *id >= self.base {
                *id += shift;
            }
        };
        let mut checks = self.clone();
        for node in &mut checks.ghosts {
            each_operand(&mut node.op, moved);
        }
        for check in &mut checks.list {
            moved(&mut check.node);
        }
        let sources = std::mem::take(&mut checks.sources).into_iter();
        let moved_source = |(id, mut source): (usize, Source)| {
            if let Source::Same { a, b, .. } = &mut source {
                [a, b].into_iter().for_each(moved);
            }
            (id + shift, source)
        };
        checks.sources = sources.map(moved_source).collect();
        checks.base += shift;
        joined.nodes.append(&mut checks.ghosts);
        joined.checks = checks;
        joined
    }
}

/// Visits the operands of an operation.
fn each_operand(op: &mut Op, mut visit: impl FnMut(&mut usize)) {
    match op {
        Op::Input | Op::OutOfReset | Op::Lit(_) | Op::InstanceOut(..) => {}
        Op::Unary(_, a)
        | Op::Slice(a, _)
        | Op::Repeat(a, _)
        | Op::Extend(a)
        | Op::Cast(a)
        | Op::Round(a, ..)
        | Op::Saturate(a)
        | Op::ReadAsync(_, a) => visit(a),
        Op::Binary(_, a, b) | Op::Shl(a, b) | Op::Shr(a, b) | Op::ReadSync(_, a, b) => {
            visit(a);
            visit(b);
        }
        Op::Mux(c, t, e) => [c, t, e].into_iter().for_each(visit),
        Op::Cat(parts) => parts.iter_mut().for_each(visit),
        Op::Select(index, options) => {
            visit(index);
            options.iter_mut().for_each(visit);
        }
        Op::Reg { next, enable, .. } => {
            next.iter_mut().chain(enable).for_each(visit);
        }
    }
}

impl Module {
    /// Whether the module has checks that are proven of it alone: they are of data, in a module
    /// without a reset.
    #[must_use]
    pub fn is_proven_alone(&self) -> bool {
        !self.checks.list.is_empty() && !self.has_reset()
    }

    /// Modules below that are proven alone, by name.
    #[must_use]
    pub fn proven_alone(&self) -> BTreeMap<String, Arc<Self>> {
        let mut all = BTreeMap::new();
        for child in self.instances.iter().map(|instance| &instance.module) {
            if child.is_proven_alone() {
                all.insert(child.name.clone(), Arc::clone(child));
            }
            all.extend(child.proven_alone());
        }
        all
    }

    /// Modules below that carry data, topmost ones alone: those with a clock and without checks in them
    /// or below, and those that are proven alone. A proof lets their outputs be anything.
    #[must_use]
    pub fn data_modules(&self) -> BTreeSet<String> {
        self.data_modules_beside(&BTreeSet::new())
    }

    /// As [`Module::data_modules`], with the modules `apart` among them, whatever checks they have.
    #[must_use]
    pub fn data_modules_beside(&self, apart: &BTreeSet<String>) -> BTreeSet<String> {
        let mut all = BTreeSet::new();
        for child in self.instances.iter().map(|instance| &instance.module) {
            let is_apart = apart.contains(&child.name) || child.is_proven_alone();
            // Logic without a clock, such as an arbiter, costs a proof little.
            let is_data = child.checks().is_empty() && child.is_clocked();
            if is_apart || is_data {
                all.insert(child.name.clone());
            } else {
                all.extend(child.data_modules_beside(apart));
            }
        }
        all
    }

    /// Names of the module and of those below, but for the modules `cut` and what is in them alone.
    #[must_use]
    pub fn modules_outside(&self, cut: &BTreeSet<String>) -> BTreeSet<String> {
        let mut all = BTreeSet::from([self.name.clone()]);
        for child in self.instances.iter().map(|instance| &instance.module) {
            if !cut.contains(&child.name) {
                all.append(&mut child.modules_outside(cut));
            }
        }
        all
    }

    /// The checks of the module and of its instances, those of an array of instances once, without
    /// those of modules that are proven alone.
    #[must_use]
    pub fn checks(self: &Arc<Self>) -> Vec<CheckInfo> {
        self.checks_beside(&BTreeSet::new())
    }

    /// As [`Module::checks`], without those of the modules `apart`.
    #[must_use]
    pub fn checks_beside(self: &Arc<Self>, apart: &BTreeSet<String>) -> Vec<CheckInfo> {
        let mut all = vec![];
        list(self, "", apart, &mut all);
        all
    }
}

/// A scope in an array, or a path in one, with its indices left open: `bank[]` of `bank[3]`.
#[must_use]
pub fn every_index(path: &str) -> String {
    let mut parts = path.split('[');
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |path, part| {
        let rest = part.split_once(']').map_or(part, |(_, rest)| rest);
        format!("{path}[]{rest}")
    })
}

fn list(module: &Module, path: &str, apart: &BTreeSet<String>, all: &mut Vec<CheckInfo>) {
    all.extend(module.checks.list.iter().map(|check| CheckInfo {
        path: format!("{path}{}", check.name),
        module: module.name.clone(),
        // What an instance expects, its parent has to keep.
        kind: match check.kind {
            CheckKind::Assume if !path.is_empty() => CheckKind::Assert,
            kind => kind,
        },
        doc: check.doc.clone(),
    }));
    for (at, instance) in module.instances.iter().enumerate() {
        let arrays = &module.arrays;
        let later = arrays.iter().any(|a| {
            let others = a.first + 1..a.first + a.count();
            others.contains(&at)
        });
        let is_apart = apart.contains(&instance.module.name) || instance.module.is_proven_alone();
        if !later && !is_apart {
            let scope = arrays.iter().find_map(|array| array.scope(at));
            let name = match scope {
                Some(scope) => format!("{}.{}", every_index(&scope), instance.module.name),
                None => instance.name.clone(),
            };
            list(&instance.module, &format!("{path}{name}."), apart, all);
        }
    }
}

#[cfg(test)]
mod tests;
