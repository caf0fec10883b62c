//! Identifiers of nodes.

use std::collections::BTreeSet;

use crate::Module;
use crate::check::{live, read_memories};
use crate::checks::Source;
use crate::node::{Binary, Op, Unary};
use crate::repetition::picked;

/// Printed nodes of a module, with their names.
pub(super) struct Names<'a> {
    pub(super) module: &'a Module,
    pub(super) live: Vec<bool>,
    /// Memories that are printed.
    pub(super) read: Vec<bool>,
    /// Instances that an array prints.
    pub(super) in_array: Vec<bool>,
    /// Identifier of each node, if any.
    of: Vec<Option<String>>,
}

fn in_array(module: &Module) -> Vec<bool> {
    let mut all = vec![false; module.instances.len()];
    for array in &module.arrays {
        all[array.first..array.first + array.count()].fill(true);
    }
    all
}

/// Uses of each node.
struct Needs {
    uses: Vec<u32>,
    /// Sliced, which requires a name.
    sliced: Vec<bool>,
    /// Used as the index of a memory.
    index: Vec<bool>,
}

impl<'a> Names<'a> {
    pub(super) fn new(module: &'a Module) -> Self {
        let live = live(module);
        let mut this = Self {
            module,
            read: read_memories(module, &live),
            in_array: in_array(module),
            live,
            of: vec![None; module.nodes.len()],
        };
        this.assign(&this.needs());
        this
    }

    /// Names what drives an output after its port.
    pub(super) fn name_outputs_as_ports(&mut self) {
        for port in self.module.ports.iter().filter(|port| port.output) {
            self.of[port.node] = Some(port.name.clone());
        }
    }

    /// The identifier of a node, if it has one.
    pub(super) fn ident(&self, id: usize) -> Option<&str> {
        self.of[id].as_deref()
    }

    /// Whether a node or a port has this identifier.
    pub(super) fn is_taken(&self, name: &str) -> bool {
        let ports = self.module.ports.iter();
        self.of.iter().flatten().any(|own| own == name) || ports.map(|p| &p.name).any(|p| p == name)
    }

    /// The node whose identifier holds this one's bits.
    pub(super) fn base(&self, id: usize) -> usize {
        match (&self.of[id], &self.module.nodes[id].op) {
            (None, Op::Cast(a)) => self.base(*a),
            _ => id,
        }
    }

    /// Writes to memories that are printed: enable, address and data.
    pub(super) fn writes(&self) -> impl Iterator<Item = [usize; 3]> {
        let memories = self.module.memories.iter().zip(&self.read);
        memories
            .filter(|(_, read)| **read)
            .flat_map(|(m, _)| &m.writes)
            .map(|(enable, address, data)| [*enable, *address, *data])
    }

    /// Names of what only checks use, in a module with their ghosts among its nodes, which has the
    /// names of `hardware` otherwise.
    pub(super) fn of_checks(joined: &'a Module, hardware: &Names<'_>) -> Self {
        let mut of = hardware.of.clone();
        of.resize(joined.nodes.len(), None);
        for (id, node) in joined.nodes.iter().enumerate().skip(hardware.of.len()) {
            if let Op::InstanceOut(instance, port) = node.op {
                let of_it = |n: &crate::node::Node| matches!(n.op, Op::InstanceOut(i, p) if (i, p) == (instance, port));
                let known = joined.nodes[..hardware.of.len()].iter().position(of_it);
                let known = known.and_then(|known| hardware.of[known].clone());
                let child = &joined.instances[instance];
                let unread = format!("unused_{}_{}", child.name, child.module.ports[port].name);
                of[id] = Some(known.unwrap_or(unread));
            }
        }
        let mut live = vec![false; joined.nodes.len()];
        let mut queue: Vec<usize> = joined.checks.list.iter().map(|c| c.node).collect();
        while let Some(id) = queue.pop() {
            let known = of[id].is_some();
            if known || std::mem::replace(&mut live[id], true) {
                continue;
            }
            let op = &joined.nodes[id].op;
            queue.extend(op.operands());
            queue.extend(op.edge_operands());
            let source = joined.checks.sources.get(&id);
            queue.extend(source.into_iter().flat_map(Source::operands));
        }
        let mut this = Self {
            module: joined,
            read: vec![false; joined.memories.len()],
            in_array: in_array(joined),
            live,
            of,
        };
        let mut taken = this.reserved();
        taken.extend(this.of.iter().flatten().cloned());
        taken.extend(joined.nodes.iter().filter_map(|n| n.name.clone()));
        let fixed = ["checking", "check_reset", "unused_checks"];
        taken.extend(fixed.map(str::to_owned));
        this.assign_from(&this.needs(), taken);
        this
    }

    fn needs(&self) -> Needs {
        let nodes = &self.module.nodes;
        let mut uses = vec![0u32; nodes.len()];
        let mut sliced = vec![false; nodes.len()];
        for (id, node) in nodes.iter().enumerate() {
            if !self.live[id] {
                continue;
            }
            for o in node
                .op
                .operands()
                .into_iter()
                .chain(node.op.edge_operands())
            {
                uses[o] += 1;
            }
            match &node.op {
                Op::Slice(a, _) | Op::Round(a, ..) | Op::Saturate(a) => sliced[*a] = true,
                Op::Extend(a) if nodes[*a].ty.signed => sliced[*a] = true,
                Op::Binary(Binary::Mul, a, b) => (sliced[*a], sliced[*b]) = (true, true),
                _ => {}
            }
        }
        for inst in &self.module.instances {
            for (_, n) in &inst.inputs {
                uses[*n] += 1;
            }
        }
        for (_, fed) in self.module.arrays.iter().flat_map(|a| &a.inputs) {
            sliced[fed.node] |= !fed.over.is_empty();
        }
        for rearranged in &self.module.rearranged {
            sliced[rearranged.from] = true;
        }
        for n in self.writes().flatten() {
            uses[n] += 1;
        }
        for port in self.module.ports.iter().filter(|p| p.output) {
            uses[port.node] += 1;
        }
        // Icarus 11 does not keep an index that is computed in place to its own
        // width: 1'd0 - 1'd1 would be below every row. A name does.
        let mut index = vec![false; nodes.len()];
        for [_, address, _] in self.writes() {
            index[address] = true;
        }
        for node in nodes {
            if let Op::ReadSync(_, _, address) | Op::ReadAsync(_, address) = node.op {
                index[address] = true;
            }
            if let Op::Select(by, _) = &node.op
                && picked(nodes, node).is_some()
            {
                index[*by] = true;
            }
        }
        // A reinterpretation without a name is its operand.
        for (id, node) in nodes.iter().enumerate().rev() {
            if let (Op::Cast(a), None) = (&node.op, &node.name) {
                uses[*a] += uses[id].saturating_sub(1);
                sliced[*a] |= sliced[id];
                index[*a] |= index[id];
            }
        }
        Needs {
            uses,
            sliced,
            index,
        }
    }

    fn assign(&mut self, needs: &Needs) {
        let mut taken = self.reserved();
        taken.extend(self.module.nodes.iter().filter_map(|n| n.name.clone()));
        self.assign_from(needs, taken);
    }

    /// Names of ports, memories, instances and loops.
    fn reserved(&self) -> BTreeSet<String> {
        let mut taken: BTreeSet<String> = ["clk", "rst_n", "unused_ok"].map(str::to_owned).into();
        taken.extend(self.module.ports.iter().map(|p| p.name.clone()));
        taken.extend(self.module.memories.iter().map(|m| m.name.clone()));
        taken.extend(self.module.instances.iter().map(|i| i.name.clone()));
        for array in &self.module.arrays {
            taken.insert(array.name.clone());
            taken.extend(array.loops.iter().map(|(variable, _)| variable.clone()));
        }
        for of in &self.module.rearranged {
            taken.extend(of.loops.iter().map(|own| own.variable.clone()));
        }
        taken
    }

    /// Names what has no name yet.
    fn assign_from(&mut self, needs: &Needs, mut taken: BTreeSet<String>) {
        let nodes = &self.module.nodes;
        for (id, node) in nodes.iter().enumerate() {
            let printed = self.live[id] || matches!(node.op, Op::Input);
            if !printed || self.of[id].is_some() {
                continue;
            }
            if let Some(name) = &node.name {
                self.of[id] = Some(name.clone());
                continue;
            }
            let shared = needs.uses[id] > 1
                && !matches!(
                    node.op,
                    Op::Lit(_) | Op::Cast(_) | Op::Slice(..) | Op::Repeat(..) | Op::OutOfReset
                );
            let needed = match &node.op {
                Op::Select(..) => needs.sliced[id] || picked(nodes, node).is_none(),
                Op::ReadAsync(..) => true,
                Op::Binary(Binary::Mul, ..) | Op::Shr(..) => node.ty.signed || needs.sliced[id],
                Op::Lit(_) | Op::Cast(_) | Op::OutOfReset => false,
                Op::Slice(..) | Op::Cat(_) | Op::Repeat(..) => needs.sliced[id],
                _ => needs.sliced[id] || needs.index[id],
            };
            // A literal under a slice is the one thing that a name must be made for.
            let literal = matches!(node.op, Op::Lit(_)) && needs.sliced[id];
            if shared || needed || literal {
                let wish = self.derive(id);
                let name = unique(&wish, &mut taken);
                self.of[id] = Some(name);
            }
        }
    }

    /// Derives a name for an unnamed node.
    fn derive(&self, id: usize) -> String {
        let of = |n: &usize| self.short(*n);
        let name = match &self.module.nodes[id].op {
            Op::Lit(v) => format!("const_{}", v.magnitude()),
            Op::Unary(Unary::Not, a) => format!("not_{}", of(a)),
            Op::Unary(Unary::Neg, a) => format!("minus_{}", of(a)),
            Op::Unary(Unary::Any, a) => format!("any_{}", of(a)),
            Op::Unary(Unary::All, a) => format!("all_{}", of(a)),
            Op::Unary(Unary::Parity, a) => format!("parity_{}", of(a)),
            Op::Binary(op, a, b) => {
                let word = match op {
                    Binary::And => "and",
                    Binary::Or => "or",
                    Binary::Xor => "xor",
                    Binary::Add => "plus",
                    Binary::Sub => "minus",
                    Binary::Mul => "times",
                    Binary::Eq => "is",
                    Binary::Ne => "is_not",
                    Binary::Lt => "below",
                    Binary::Le => "up_to",
                };
                format!("{}_{word}_{}", of(a), of(b))
            }
            Op::Shl(a, _) | Op::Shr(a, _) => format!("{}_shifted", of(a)),
            Op::Slice(a, _) => format!("{}_part", of(a)),
            Op::Cat(parts) => joined(parts.iter().map(of)),
            Op::Repeat(a, _) => format!("{}_mask", of(a)),
            Op::Extend(a) => format!("{}_wide", of(a)),
            Op::Round(a, ..) => format!("{}_rounded", of(a)),
            Op::Saturate(a) => format!("{}_held", of(a)),
            Op::Mux(c, ..) => format!("by_{}", of(c)),
            Op::Select(i, _) => format!("picked_by_{}", of(i)),
            Op::ReadAsync(m, _) => format!("{}_out", self.module.memories[*m].name),
            Op::Cast(a) => of(a),
            _ => "signal".to_owned(),
        };
        let mut name: String = name.chars().take(32).collect();
        while name.ends_with('_') {
            name.pop();
        }
        name
    }

    fn short(&self, id: usize) -> String {
        if let Some(name) = &self.of[id] {
            return name.clone();
        }
        match &self.module.nodes[id].op {
            Op::Lit(v) => v.magnitude().to_string(),
            Op::Slice(a, low) => format!("{}_{low}", self.short(*a)),
            Op::Cast(a) | Op::Extend(a) | Op::Repeat(a, _) => self.short(*a),
            Op::Unary(Unary::Not, a) => format!("no_{}", self.short(*a)),
            Op::Binary(Binary::Add, a, _) => format!("{}_sum", self.short(*a)),
            Op::Binary(_, a, _) | Op::Unary(_, a) | Op::Round(a, ..) | Op::Saturate(a) => {
                self.short(*a)
            }
            Op::Mux(_, a, _) | Op::Shl(a, _) | Op::Shr(a, _) => self.short(*a),
            Op::Cat(parts) => parts.first().map_or_else(String::new, |p| self.short(*p)),
            _ => "value".to_owned(),
        }
    }
}

/// Name of a vector of values: their stem where they differ in their numbers alone.
fn joined(mut parts: impl Iterator<Item = String>) -> String {
    let first = parts.next().unwrap_or_default();
    let stem = |name: &str| {
        name.trim_end_matches(|c: char| c.is_ascii_digit())
            .to_owned()
    };
    let own = stem(&first);
    match parts.all(|part| stem(&part) == own) && !own.is_empty() {
        true => own,
        false => format!("{first}_joined"),
    }
}

fn unique(wish: &str, taken: &mut BTreeSet<String>) -> String {
    let wish = if wish.is_empty() || wish.starts_with(|c: char| c.is_ascii_digit()) {
        format!("v_{wish}")
    } else {
        wish.to_owned()
    };
    let mut name = wish.clone();
    let mut n = 1;
    while !taken.insert(name.clone()) {
        n += 1;
        name = format!("{wish}_{n}");
    }
    name
}
