//! Evaluation order of nodes.

use std::collections::BTreeSet;

use crate::Module;
use crate::node::Op;

/// Nodes in topological order, and inputs of instances for which none exists.
pub(super) fn order(module: &Module) -> (Vec<usize>, BTreeSet<(usize, usize)>) {
    #[derive(Clone, Copy, PartialEq)]
    enum Visit {
        Not,
        OnTheWay,
        Done,
    }
    let mut seen = vec![Visit::Not; module.nodes.len()];
    let (mut order, mut looped) = (vec![], BTreeSet::new());
    let mut stack: Vec<(usize, bool)> = vec![];
    for start in 0..seen.len() {
        stack.push((start, false));
        while let Some((id, ready)) = stack.pop() {
            if ready {
                // The outputs of an instance are on the way, and done, together.
                if seen[id] != Visit::Done {
                    seen[id] = Visit::Done;
                    order.push(id);
                }
            } else if seen[id] == Visit::Not {
                seen[id] = Visit::OnTheWay;
                stack.push((id, true));
                match &module.nodes[id].op {
                    Op::InstanceOut(i, _) => {
                        let inputs = module.instances[*i].inputs.iter();
                        for (port, n) in inputs {
                            if seen[*n] == Visit::OnTheWay || leads_to(module, *n, *i) {
                                looped.insert((*i, *port));
                            } else {
                                stack.push((*n, false));
                            }
                        }
                    }
                    op => stack.extend(op.operands().into_iter().map(|n| (n, false))),
                }
            }
        }
    }
    (order, looped)
}

/// Whether a node has a combinational path from an output of this instance.
fn leads_to(module: &Module, id: usize, instance: usize) -> bool {
    let mut seen = vec![false; module.nodes.len()];
    let mut stack = vec![id];
    while let Some(n) = stack.pop() {
        if std::mem::replace(&mut seen[n], true) {
            continue;
        }
        match &module.nodes[n].op {
            Op::InstanceOut(i, _) if *i == instance => return true,
            Op::InstanceOut(i, _) => stack.extend(module.instances[*i].inputs.iter().map(|p| p.1)),
            op => stack.extend(op.operands()),
        }
    }
    false
}
