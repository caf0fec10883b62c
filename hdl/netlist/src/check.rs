//! Structural checks of modules.
//!
//! A node can only refer to earlier nodes, so within a module only registers and memories close
//! loops. Instances may be connected later; combinational paths from their inputs to their outputs
//! are followed through the hierarchy.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::keywords::is_keyword;
use super::node::Op;
use super::{IrError, Module};

/// Live nodes: those that reach an output or an instance, through memories too. Other nodes are not
/// printed, nor are memories that no live node reads.
pub(crate) fn live(module: &Module) -> Vec<bool> {
    let mut live = vec![false; module.nodes.len()];
    let mut queue: Vec<usize> = module
        .ports
        .iter()
        .filter(|p| p.output)
        .map(|p| p.node)
        .collect();
    for inst in &module.instances {
        queue.extend(inst.inputs.iter().map(|(_, n)| *n));
    }
    // The text of an array has the vector itself, of which its instances have parts.
    for (_, fed) in module.arrays.iter().flat_map(|array| &array.inputs) {
        queue.push(fed.node);
    }
    let mut read = vec![false; module.memories.len()];
    while let Some(id) = queue.pop() {
        if std::mem::replace(&mut live[id], true) {
            continue;
        }
        let op = &module.nodes[id].op;
        queue.extend(op.operands());
        queue.extend(op.edge_operands());
        // The text of rearranged bits has their vector, of which the operands are bits.
        let rearranged = module.rearranged.iter().find(|of| of.node == id);
        queue.extend(rearranged.map(|of| of.from));
        if let Op::ReadSync(m, ..) | Op::ReadAsync(m, _) = op
            && !std::mem::replace(&mut read[*m], true)
        {
            for (en, addr, data) in &module.memories[*m].writes {
                queue.extend([*en, *addr, *data]);
            }
        }
    }
    live
}

/// The memories that a live node reads.
pub(crate) fn read_memories(module: &Module, live: &[bool]) -> Vec<bool> {
    let mut read = vec![false; module.memories.len()];
    for (node, _) in module.nodes.iter().zip(live).filter(|(_, live)| **live) {
        if let Op::ReadSync(m, ..) | Op::ReadAsync(m, _) = node.op {
            read[m] = true;
        }
    }
    read
}

/// Whether the module or its hierarchy has a live clocked node, and whether it has one that is reset.
pub(crate) fn state(module: &Module) -> (bool, bool) {
    let live = live(module);
    let nodes = || {
        module
            .nodes
            .iter()
            .zip(&live)
            .filter(|(_, live)| **live)
            .map(|(n, _)| n)
    };
    let read = read_memories(module, &live);
    let mut memories = module.memories.iter().zip(&read);
    let registers = nodes()
        .any(|n| matches!(n.op, Op::Reg { reset: Some(_), .. } | Op::OutOfReset))
        || module.instances.iter().any(|i| i.module.has_reset());
    let clocked = registers
        || nodes().any(|n| matches!(n.op, Op::ReadSync(..) | Op::Reg { .. }))
        || memories.any(|(m, read)| *read && !m.writes.is_empty())
        || module.instances.iter().any(|i| i.module.is_clocked());
    (clocked, registers)
}

pub(crate) fn check(module: &Module) -> Vec<IrError> {
    let mut errors = vec![];
    let mut fail = |node: &str, problem: String| {
        errors.push(IrError {
            module: module.name.clone(),
            node: node.to_owned(),
            problem,
        });
    };
    let live = live(module);
    for (id, node) in module.nodes.iter().enumerate() {
        let name = node.name.as_deref().unwrap_or("an unnamed node");
        if matches!(node.op, Op::Reg { next: None, .. }) {
            fail(
                name,
                "register is never driven: call set_next or set_next_if".to_owned(),
            );
        }
        if node.op.operands().iter().any(|o| *o >= id) {
            fail(name, "reads a later node: a combinational loop".to_owned());
        }
        if matches!(node.op, Op::Input) && !live[id] && !module.unused.contains_key(&id) {
            fail(
                name,
                "input is not read: use it, or give the reason with unused()".to_owned(),
            );
        }
    }
    for inst in &module.instances {
        for (i, p) in inst.module.ports.iter().enumerate() {
            if !p.output && !inst.inputs.iter().any(|(c, _)| *c == i) {
                fail(
                    &inst.name,
                    format!("port `{}` of {} is not connected", p.name, inst.module.name),
                );
            }
        }
    }
    if let Err(name) = same_cycle_inputs(module) {
        fail(
            &name,
            "is part of a combinational loop through an instance: put a register on the way"
                .to_owned(),
        );
    }
    let mut names: BTreeMap<&str, &str> = BTreeMap::new();
    let mut claim = |name: &'static str, found: String| fail(name, found);
    let all = module
        .memories
        .iter()
        .map(|m| (m.name.as_str(), "memory"))
        .chain(
            module
                .instances
                .iter()
                .map(|i| (i.name.as_str(), "instance")),
        )
        .chain(module.arrays.iter().map(|a| (a.name.as_str(), "array")))
        .chain(loop_variables(module))
        .chain(module.ports.iter().map(|p| (p.name.as_str(), "port")))
        .chain(std::iter::once((module.name.as_str(), "module")));
    for (name, kind) in all {
        if !legal(name) {
            claim(
                "a name",
                format!("{kind} `{name}` is no plain Verilog identifier, or a keyword"),
            );
        } else if let Some(other) = names.insert(name, kind) {
            claim("a name", format!("`{name}` names a {other} and a {kind}"));
        }
    }
    let mut named: BTreeMap<&str, usize> = BTreeMap::new();
    for (id, node) in module.nodes.iter().enumerate() {
        let Some(name) = node.name.as_deref() else {
            continue;
        };
        let own_port = module.ports.iter().any(|p| p.name == name && p.node == id);
        if !legal(name) {
            claim(
                "a name",
                format!("signal `{name}` is no plain Verilog identifier, or a keyword"),
            );
        } else if named.insert(name, id).is_some() || (names.contains_key(name) && !own_port) {
            claim("a name", format!("`{name}` is given twice"));
        }
    }
    let mut modules = BTreeMap::new();
    same_names(module, &mut modules, &mut |name| {
        claim(
            "a name",
            format!("two different modules are called `{name}`"),
        );
    });
    errors
}

/// For every output port, by index, the input ports with a combinational path to it. The error
/// names a node of a combinational loop.
pub(crate) fn same_cycle_inputs(
    module: &Module,
) -> Result<BTreeMap<usize, BTreeSet<usize>>, String> {
    let below: Vec<_> = module
        .instances
        .iter()
        .map(|i| same_cycle_inputs(&i.module))
        .collect::<Result<_, _>>()?;
    let sources = |id: usize| -> Vec<usize> {
        match &module.nodes[id].op {
            Op::InstanceOut(i, port) => {
                let wanted = below[*i].get(port);
                let inputs = module.instances[*i].inputs.iter();
                inputs
                    .filter(|(p, _)| wanted.is_some_and(|w| w.contains(p)))
                    .map(|(_, n)| *n)
                    .collect()
            }
            op => op.operands(),
        }
    };
    // Depth first, with an explicit stack: 0 unseen, 1 on the way, 2 done.
    let mut state = vec![0u8; module.nodes.len()];
    let mut inputs: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); module.nodes.len()];
    for start in 0..module.nodes.len() {
        let mut stack = vec![(start, false)];
        while let Some((id, finished)) = stack.pop() {
            if finished {
                state[id] = 2;
                let mut all = BTreeSet::new();
                if let Some(port) = module.ports.iter().position(|p| !p.output && p.node == id) {
                    all.insert(port);
                }
                for s in sources(id) {
                    all.extend(inputs[s].iter().copied());
                }
                inputs[id] = all;
            } else if state[id] == 0 {
                state[id] = 1;
                stack.push((id, true));
                for s in sources(id) {
                    match state[s] {
                        0 => stack.push((s, false)),
                        1 => {
                            return Err(module.nodes[s]
                                .name
                                .clone()
                                .unwrap_or_else(|| "an unnamed node".to_owned()));
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    let outputs = module.ports.iter().enumerate().filter(|(_, p)| p.output);
    Ok(outputs.map(|(i, p)| (i, inputs[p.node].clone())).collect())
}

/// Variables of the loops of arrays and of rearranged bits, each once: arrays may share them, and so
/// may rearranged bits.
fn loop_variables(module: &Module) -> impl Iterator<Item = (&str, &'static str)> {
    let loops = module.arrays.iter().flat_map(|a| &a.loops);
    let loops = loops.map(|(variable, _)| (variable.as_str(), "loop variable"));
    let bits = module.rearranged.iter().flat_map(|of| &of.loops);
    let bits = bits.map(|own| (own.variable.as_str(), "index of rearranged bits"));
    let all: BTreeSet<_> = loops.chain(bits).collect();
    all.into_iter()
}

fn same_names(
    module: &Module,
    seen: &mut BTreeMap<String, Arc<Module>>,
    clash: &mut dyn FnMut(&str),
) {
    for inst in &module.instances {
        match seen.get(&inst.module.name) {
            Some(other) if is_same(other, &inst.module) => continue,
            Some(_) => clash(&inst.module.name),
            None => {}
        }
        seen.insert(inst.module.name.clone(), inst.module.clone());
        same_names(&inst.module, seen, clash);
    }
}

/// Whether two modules of one name are one, or made alike.
fn is_same(a: &Arc<Module>, b: &Arc<Module>) -> bool {
    Arc::ptr_eq(a, b) || a.doc == b.doc && a.digest() == b.digest()
}

fn legal(name: &str) -> bool {
    let mut bytes = name.bytes();
    let start = bytes
        .next()
        .is_some_and(|b| b.is_ascii_alphabetic() || b == b'_');
    start
        && bytes.all(|b| b.is_ascii_alphanumeric() || b == b'_')
        && !is_keyword(name)
        && name != "clk"
        && name != "rst_n"
}
