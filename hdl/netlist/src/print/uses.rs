//! Unread bits of named nodes.

use potamoi_formats::fixed::Rounding;

use super::expr::range;
use super::names::Names;
use crate::node::Op;

/// Unread parts of identifiers, which go into a sink to satisfy linters.
pub(super) fn unread(names: &Names<'_>) -> Vec<String> {
    let all: Vec<usize> = (0..names.module.nodes.len()).collect();
    unread_of(names, &all)
}

/// Unread parts of these nodes.
pub(super) fn unread_of(names: &Names<'_>, ids: &[usize]) -> Vec<String> {
    let mut parts = vec![];
    let used = used(names);
    for id in ids.iter().copied() {
        let node = &names.module.nodes[id];
        let Some(name) = names.ident(id) else {
            continue;
        };
        if matches!(node.op, Op::Lit(_)) {
            continue;
        }
        let used = &used[id];
        let mut low = 0;
        while low < used.len() {
            let run = used[low..].iter().take_while(|u| **u == used[low]).count();
            if !used[low] {
                let whole = run == used.len();
                parts.push(if whole {
                    name.to_owned()
                } else {
                    range(name, low as u32, run as u32, node.ty.width)
                });
            }
            low += run;
        }
    }
    parts
}

/// Read bits of each node.
fn used(names: &Names<'_>) -> Vec<Vec<bool>> {
    let module = names.module;
    let nodes = &module.nodes;
    let mut reads: Vec<(usize, u32, u32)> = vec![];
    for (id, node) in nodes.iter().enumerate() {
        if !names.live[id] {
            continue;
        }
        match &node.op {
            Op::Slice(a, low) => reads.push((*a, *low, node.ty.width)),
            Op::Cast(_) if names.ident(id).is_none() => {}
            Op::InstanceOut(..) => {}
            // Rounding down or half-up does not look below the dropped bit.
            Op::Round(a, bits, Rounding::Floor) => {
                reads.push((*a, *bits, nodes[*a].ty.width - bits))
            }
            Op::Round(a, bits, Rounding::HalfUp) => {
                reads.push((*a, bits - 1, nodes[*a].ty.width - bits + 1))
            }
            op => reads.extend(
                op.operands()
                    .into_iter()
                    .chain(op.edge_operands())
                    .map(|o| (o, 0, nodes[o].ty.width)),
            ),
        }
    }
    let whole = |n: usize| (n, 0, nodes[n].ty.width);
    reads.extend(
        module
            .instances
            .iter()
            .flat_map(|i| &i.inputs)
            .map(|(_, n)| whole(*n)),
    );
    reads.extend(names.writes().flatten().map(whole));
    reads.extend(
        module
            .ports
            .iter()
            .filter(|p| p.output)
            .map(|p| whole(p.node)),
    );
    let mut used: Vec<_> = nodes
        .iter()
        .map(|n| vec![false; n.ty.width as usize])
        .collect();
    for (id, low, width) in reads {
        for bit in &mut used[names.base(id)][low as usize..(low + width) as usize] {
            *bit = true;
        }
    }
    used
}
