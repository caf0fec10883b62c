//! Range analysis: the values of each node, from declared input ranges and contracts of registers.
//! It proves that sums do not overflow.
//!
//! Modules are analysed top down, once for every combination of input ranges. Memories may hold any
//! value, unless a range is declared for what is read.

mod analyse;
mod contract;
mod interval;
mod order;
#[cfg(test)]
mod tests;
mod transfer;

use std::collections::BTreeSet;
use std::sync::Arc;

use num_bigint::BigInt;

use super::{IrError, IrErrors, Module};
use analyse::Analyser;

pub(crate) use analyse::{ModuleRanges, assumption};
pub use interval::Interval;
pub(crate) use transfer::{NodeIntervals, truth};

/// The proven range of every node of a module and of the instances below it.
///
/// They hold in every cycle after the first reset, whatever the inputs, as
/// long as inputs keep their declared ranges and registers their contracts.
#[derive(Debug, Clone)]
pub struct Ranges {
    pub(crate) module: Arc<Module>,
    pub(crate) root: Arc<ModuleRanges>,
}

impl Ranges {
    /// Range of a signal with the hierarchical name `instance.instance.signal`.
    #[must_use]
    pub fn of(&self, path: &str) -> Option<(BigInt, BigInt)> {
        let (mut module, mut ranges) = (&self.module, &self.root);
        let mut parts: Vec<&str> = path.split('.').collect();
        let name = parts.pop()?;
        for part in parts {
            let i = module.instances.iter().position(|i| i.name == part)?;
            (module, ranges) = (&module.instances[i].module, &ranges.instances[i]);
        }
        let named = module
            .nodes
            .iter()
            .position(|n| n.name.as_deref() == Some(name));
        let port = || module.ports.iter().find(|p| p.name == name).map(|p| p.node);
        let i = &ranges.values[named.or_else(port)?];
        Some((i.low.clone(), i.high.clone()))
    }
}

/// Derives the ranges of a module and its hierarchy.
///
/// # Errors
/// Each node marked exact that may wrap, each register whose width or netlist violates its
/// contract, and each instance input beyond its declared range, with the signal, its range and the
/// required type.
pub fn ranges(module: &Arc<Module>) -> Result<Ranges, IrErrors> {
    let inputs: Vec<_> = module
        .ports
        .iter()
        .filter(|p| !p.output)
        .map(|p| {
            assumption(module, p.node).unwrap_or_else(|| Interval::all(module.nodes[p.node].ty))
        })
        .collect();
    let root = Analyser::default().module(module, &inputs);
    let mut errors = vec![];
    collect(&root, &mut errors, &mut BTreeSet::new());
    if errors.is_empty() {
        let module = module.clone();
        Ok(Ranges { module, root })
    } else {
        Err(IrErrors(errors))
    }
}

fn collect(ranges: &Arc<ModuleRanges>, errors: &mut Vec<IrError>, seen: &mut BTreeSet<usize>) {
    if seen.insert(Arc::as_ptr(ranges) as usize) {
        for e in &ranges.errors {
            if !errors.contains(e) {
                errors.push(e.clone());
            }
        }
        for below in &ranges.instances {
            collect(below, errors, seen);
        }
    }
}
