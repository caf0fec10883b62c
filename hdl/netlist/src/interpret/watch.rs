//! Run-time checks of proven ranges and declared bounds.

use std::sync::Arc;

use num_bigint::{BigInt, BigUint};

use super::InterpretError;
use super::flatten::Layout;
use super::step::Slot;
use crate::check::live;
use crate::node::{Contract, Op};
use crate::{Interval, Module, ModuleRanges, Ranges};

/// A value with its range.
#[derive(Debug, Clone)]
pub(super) struct Watch {
    signal: String,
    slot: Slot,
    range: Interval,
    why: String,
}

impl Watch {
    pub(super) fn check(&self, values: &[u64], cycle: u64) -> Result<(), InterpretError> {
        let digits = self.slot.of(values).iter();
        let digits = digits.flat_map(|w| [*w as u32, (w >> 32) as u32]);
        let mut value = BigInt::from(BigUint::new(digits.collect()));
        let ty = self.slot.ty;
        if ty.signed && value.bit(u64::from(ty.width - 1)) {
            value -= BigInt::from(1) << ty.width;
        }
        if self.range.contains(&value) {
            return Ok(());
        }
        Err(InterpretError::OutOfRange {
            signal: self.signal.clone(),
            value,
            expected: format!("{}, {}", self.range, self.why),
            cycle,
        })
    }
}

/// All checks of a module.
pub(super) fn all(
    module: &Arc<Module>,
    layout: &Layout,
    ranges: &Ranges,
) -> Result<Vec<Watch>, InterpretError> {
    if !Arc::ptr_eq(module, &ranges.module) {
        return Err(InterpretError::ForeignRanges(module.name.clone()));
    }
    let mut watches = vec![];
    let inputs = vec![false; module.ports.len()];
    add(module, layout, &ranges.root, "", &inputs, &mut watches);
    Ok(watches)
}

/// Adds a module's checks; whether each of its outputs rests on a contract.
///
/// A sum that a contract bounds is within its range only when it counts, so
/// that nothing that follows from it can be checked in every cycle, but the
/// register that holds it can.
fn add(
    module: &Module,
    layout: &Layout,
    ranges: &ModuleRanges,
    path: &str,
    inputs: &[bool],
    watches: &mut Vec<Watch>,
) -> Vec<bool> {
    let held = |id: usize| {
        module.contracts.iter().find_map(|c| match c {
            Contract::Terms { reg, why, .. } | Contract::Weighted { reg, why, .. } => {
                (*reg == id).then_some(why)
            }
            Contract::Range { .. } => None,
        })
    };
    let mut rests = ranges.claimed.clone();
    let mut below: Vec<Vec<Watch>>;
    // Until no register is found to follow from such a sum any more.
    loop {
        let before = rests.clone();
        below = vec![];
        let mut outputs: Vec<Vec<bool>> = vec![];
        for id in 0..=module.nodes.len() {
            while let Some(inst) = module.instances.get(outputs.len()).filter(|i| i.at <= id) {
                let i = outputs.len();
                let mut given = vec![false; inst.module.ports.len()];
                for (port, n) in &inst.inputs {
                    given[*port] = rests[*n];
                }
                let path = format!("{path}{}.", inst.name);
                let mut inner = vec![];
                let (to, from) = (&layout.instances[i], &ranges.instances[i]);
                outputs.push(add(&inst.module, to, from, &path, &given, &mut inner));
                below.push(inner);
            }
            let Some(node) = module.nodes.get(id) else {
                break;
            };
            let port = |(i, p): (usize, &crate::node::Port)| !p.output && p.node == id && inputs[i];
            rests[id] |= match &node.op {
                Op::Input => module.ports.iter().enumerate().any(port),
                Op::InstanceOut(i, port) => outputs[*i][*port],
                Op::Reg { .. } if held(id).is_some() => false,
                Op::ReadSync(..) | Op::ReadAsync(..) => false,
                op => {
                    let mut from = op.operands();
                    from.extend(op.edge_operands());
                    from.iter().any(|n| rests[*n])
                }
            };
        }
        if before == rests {
            break;
        }
    }
    let live = live(module);
    for (id, node) in module.nodes.iter().enumerate().filter(|(id, _)| live[*id]) {
        let range = &ranges.values[id];
        if rests[id] || *range == Interval::all(node.ty) || matches!(node.op, Op::Lit(_)) {
            continue;
        }
        let why = held(id).map_or("which was proven", String::as_str);
        let port = || module.ports.iter().find(|p| p.node == id).map(|p| &p.name);
        let name = node.name.as_ref().or_else(port);
        let name = name.map_or_else(|| format!("node {id}"), Clone::clone);
        watches.push(Watch {
            signal: format!("{path}{name}"),
            slot: layout.slots[id],
            range: range.clone(),
            why: declared(module, id).unwrap_or(why).to_owned(),
        });
    }
    watches.extend(below.into_iter().flatten());
    module.ports.iter().map(|p| rests[p.node]).collect()
}

fn declared(module: &Module, id: usize) -> Option<&str> {
    module.contracts.iter().find_map(|c| match c {
        Contract::Range { node, why, .. } if *node == id => Some(why.as_str()),
        _ => None,
    })
}
