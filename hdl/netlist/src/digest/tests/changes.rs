//! Modules with one change.

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::fixed::Rounding;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;

use super::random::child;
use crate::Module;
use crate::check;
use crate::node::{Binary, Node, Op, Ty, Unary};

/// All operands of an operation.
pub(super) fn operands(op: &mut Op) -> Vec<&mut usize> {
    match op {
        Op::Input | Op::OutOfReset | Op::Lit(_) | Op::InstanceOut(..) => vec![],
        Op::Unary(_, a)
        | Op::Slice(a, _)
        | Op::Repeat(a, _)
        | Op::Extend(a)
        | Op::Cast(a)
        | Op::Round(a, ..)
        | Op::Saturate(a)
        | Op::ReadAsync(_, a) => vec![a],
        Op::Binary(_, a, b) | Op::Shl(a, b) | Op::Shr(a, b) | Op::ReadSync(_, a, b) => vec![a, b],
        Op::Mux(a, b, c) => vec![a, b, c],
        Op::Cat(all) => all.iter_mut().collect(),
        Op::Select(index, options) => std::iter::once(index).chain(options).collect(),
        Op::Reg { next, enable, .. } => next.iter_mut().chain(enable).collect(),
    }
}

/// Other names and texts everywhere but at ports, and no declared ranges.
pub(super) fn renamed(module: &Module) -> Module {
    let mut own = module.clone();
    let other = |name: &mut String| *name = format!("z_{name}");
    other(&mut own.name);
    other(&mut own.doc);
    own.sections.iter_mut().for_each(other);
    own.unused.clear();
    own.contracts.clear();
    for (at, node) in own.nodes.iter_mut().enumerate() {
        if !matches!(node.op, Op::Input) {
            // Named where it was not, and the other way round.
            node.name = node.name.is_none().then(|| format!("n{at}"));
        }
        node.note = node.note.is_none().then(|| "noted".to_owned());
        node.section = at % own.sections.len();
        node.exact = !node.exact;
    }
    for port in &mut own.ports {
        other(&mut port.doc);
    }
    for memory in &mut own.memories {
        other(&mut memory.name);
        other(&mut memory.doc);
    }
    for instance in &mut own.instances {
        other(&mut instance.name);
        instance.module = Arc::new(renamed(&instance.module));
    }
    own
}

/// A permutation: the new place of each old one.
fn shuffled(count: usize, random: &mut Pcg64Mcg) -> Vec<usize> {
    let mut places: Vec<usize> = (0..count).collect();
    places.shuffle(random);
    places
}

fn permuted<T: Clone>(from: &[T], places: &[usize]) -> Vec<T> {
    let mut order: Vec<usize> = (0..from.len()).collect();
    order.sort_by_key(|at| places[*at]);
    order.into_iter().map(|at| from[at].clone()).collect()
}

/// The same netlist with its nodes, ports, memories and instances in another order, and with nodes
/// that nothing reads.
pub(super) fn otherwise_built(module: &Module, seed: u64) -> Module {
    let mut own = module.clone();
    let random = &mut Pcg64Mcg::seed_from_u64(seed);
    let wide = Ty::u(9);
    let unread = [
        Op::Lit(BigInt::from(seed)),
        Op::Unary(Unary::Not, own.nodes.len()),
    ];
    for op in unread {
        own.nodes.push(Node {
            op,
            ty: wide,
            name: None,
            note: None,
            section: 0,
            exact: false,
            values: None,
            indexed: false,
        });
    }
    let nodes = shuffled(own.nodes.len(), random);
    let memories = shuffled(own.memories.len(), random);
    let instances = shuffled(own.instances.len(), random);
    for node in &mut own.nodes {
        for operand in operands(&mut node.op) {
            *operand = nodes[*operand];
        }
        match &mut node.op {
            Op::ReadSync(memory, ..) | Op::ReadAsync(memory, _) => *memory = memories[*memory],
            Op::InstanceOut(instance, _) => *instance = instances[*instance],
            _ => {}
        }
    }
    for memory in &mut own.memories {
        for (enable, address, data) in &mut memory.writes {
            for node in [enable, address, data] {
                *node = nodes[*node];
            }
        }
    }
    for instance in &mut own.instances {
        for (_, node) in &mut instance.inputs {
            *node = nodes[*node];
        }
        instance.inputs.reverse();
    }
    for port in &mut own.ports {
        port.node = nodes[port.node];
    }
    own.nodes = permuted(&own.nodes, &nodes);
    own.memories = permuted(&own.memories, &memories);
    own.instances = permuted(&own.instances, &instances);
    own.ports.shuffle(random);
    own
}

type Changed = Vec<(String, Module)>;

fn with(module: &Module, change: impl FnOnce(&mut Module)) -> Module {
    let mut own = module.clone();
    change(&mut own);
    own
}

/// One change of a node each: its type, each operand, and whatever else it holds. The `match` names
/// every operation.
pub(super) fn of_node(module: &Module, id: usize) -> Changed {
    let mut found: Changed = vec![];
    let mut change = |what: &str, change: &dyn Fn(&mut Node)| {
        let changed = with(module, |own| change(&mut own.nodes[id]));
        found.push((what.to_owned(), changed));
    };
    let is_alias =
        matches!(module.nodes[id].op, Op::Cast(a) if module.nodes[a].ty == module.nodes[id].ty);
    if !is_alias {
        change("wider", &|n| n.ty.width += 1);
        change("signedness", &|n| n.ty.signed = !n.ty.signed);
    }
    match module.nodes[id].op {
        Op::Lit(_) => change("value", &|n| {
            if let Op::Lit(value) = &mut n.op {
                *value += 1;
            }
        }),
        Op::Unary(now, _) => {
            for other in [
                Unary::Not,
                Unary::Neg,
                Unary::Any,
                Unary::All,
                Unary::Parity,
            ] {
                if other != now {
                    change("operator", &|n| {
                        if let Op::Unary(operator, _) = &mut n.op {
                            *operator = other;
                        }
                    });
                }
            }
        }
        Op::Binary(now, ..) => {
            use Binary::{Add, And, Eq, Le, Lt, Mul, Ne, Or, Sub, Xor};
            for other in [And, Or, Xor, Add, Sub, Mul, Eq, Ne, Lt, Le] {
                if other != now {
                    change("operator", &|n| {
                        if let Op::Binary(operator, ..) = &mut n.op {
                            *operator = other;
                        }
                    });
                }
            }
        }
        Op::Shl(a, by) => change("direction", &|n| n.op = Op::Shr(a, by)),
        Op::Shr(a, by) => change("direction", &|n| n.op = Op::Shl(a, by)),
        Op::Slice(a, low) => change("lowest bit", &|n| n.op = Op::Slice(a, low + 1)),
        Op::Repeat(a, count) => change("count", &|n| n.op = Op::Repeat(a, count + 1)),
        Op::Extend(a) => change("saturates", &|n| n.op = Op::Saturate(a)),
        Op::Saturate(a) => change("extends", &|n| n.op = Op::Extend(a)),
        Op::Round(a, bits, now) => {
            change("dropped bits", &|n| n.op = Op::Round(a, bits + 1, now));
            for other in [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven] {
                if other != now {
                    change("mode", &|n| n.op = Op::Round(a, bits, other));
                }
            }
        }
        Op::Reg {
            ref reset, enable, ..
        } => {
            let is_reset = reset.is_some();
            change("reset value", &|n| {
                if let Op::Reg { reset, .. } = &mut n.op {
                    *reset = Some(reset.take().unwrap_or_default() + 1);
                }
            });
            if is_reset {
                change("whether it is reset", &|n| {
                    if let Op::Reg { reset, .. } = &mut n.op {
                        *reset = None;
                    }
                });
            }
            let other = enable.is_none().then_some(0);
            change("whether it is enabled", &|n| {
                if let Op::Reg { enable, .. } = &mut n.op {
                    *enable = other;
                }
            });
        }
        Op::ReadSync(m, enable, address) => {
            change("memory", &|n| n.op = Op::ReadSync(1 - m, enable, address));
            change("clock", &|n| n.op = Op::ReadAsync(m, address));
        }
        Op::ReadAsync(m, address) => {
            change("memory", &|n| n.op = Op::ReadAsync(1 - m, address));
        }
        Op::Cat(_) | Op::Select(..) => change("one operand less", &|n| {
            if let Op::Cat(all) | Op::Select(_, all) = &mut n.op {
                all.pop();
            }
        }),
        Op::Input | Op::OutOfReset | Op::Cast(_) | Op::Mux(..) | Op::InstanceOut(..) => {}
    }
    let count = operands(&mut module.nodes[id].op.clone()).len();
    for at in 0..count {
        // A constant that is nowhere else.
        let changed = with(module, |own| {
            let new = own.nodes.len();
            let ty = Ty::u(77);
            own.nodes.push(Node {
                op: Op::Lit(BigInt::from(1)),
                ty,
                ..own.nodes[0].clone()
            });
            *operands(&mut own.nodes[id].op)[at] = new;
        });
        found.push((format!("operand {at}"), changed));
    }
    found
}

/// One change of a port, of a memory that is read, or of an instance each.
pub(super) fn of_parts(module: &Module) -> Changed {
    let mut found: Changed = vec![];
    let mut change = |what: &str, change: &dyn Fn(&mut Module)| {
        found.push((what.to_owned(), with(module, |own| change(own))));
    };
    for at in 0..module.ports.len() {
        change("name of a port", &|m| m.ports[at].name += "x");
        change("a port less", &|m| drop(m.ports.remove(at)));
    }
    change("clk", &|m| m.clocked = !m.clocked);
    change("rst_n", &|m| m.registers = !m.registers);
    let read = check::read_memories(module, &check::live(module));
    for at in (0..module.memories.len()).filter(|at| read[*at]) {
        change("depth", &|m| m.memories[at].depth += 1);
        change("width", &|m| m.memories[at].width += 1);
        change("a write less", &|m| m.memories[at].writes.truncate(1));
    }
    let other = child("child", 4);
    for at in 0..module.instances.len() {
        change("module below", &|m| m.instances[at].module = other.clone());
    }
    found
}
