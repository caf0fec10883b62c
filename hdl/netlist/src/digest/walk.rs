//! Walk over a module from its outputs, which numbers what it meets in an order of its own.

use std::collections::{BTreeMap, VecDeque};

use super::Digest;
use super::encoding::Encoding;
use crate::Module;
use crate::node::{Op, Port};

/// Stands for the number of a node where a constant follows.
const CONSTANT: usize = usize::MAX;

/// A part of a module, by index there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Node(usize),
    Memory(usize),
    Instance(usize),
}

/// Parts in the order in which the walk met them.
struct Walk<'a> {
    module: &'a Module,
    /// Names of input ports by node.
    inputs: BTreeMap<usize, &'a str>,
    numbers: BTreeMap<Part, usize>,
    met: VecDeque<Part>,
    to: &'a mut Encoding,
}

/// Encodes a module; `children` are the digests of its instances' modules.
pub(super) fn encode(module: &Module, children: &[Digest], to: &mut Encoding) {
    let inputs = module.ports.iter().filter(|port| !port.output);
    let mut walk = Walk {
        module,
        inputs: inputs.map(|port| (port.node, &*port.name)).collect(),
        numbers: BTreeMap::new(),
        met: VecDeque::new(),
        to,
    };
    walk.to.flag(module.clocked);
    walk.to.flag(module.registers);
    let mut ports: Vec<&Port> = module.ports.iter().collect();
    ports.sort_by(|a, b| a.name.cmp(&b.name));
    walk.to.number(ports.len());
    for port in ports {
        walk.to.text(&port.name);
        walk.to.flag(port.output);
        walk.to.ty(module.nodes[port.node].ty);
        if port.output {
            walk.node(port.node);
        }
    }
    walk.run(children);
    walk.unread(children);
    let count = walk.numbers.len();
    walk.to.number(count);
}

impl Walk<'_> {
    /// Encodes instances none of whose outputs is read: always the one whose own encoding has the
    /// lowest hash, so that the order in which they were made does not count.
    fn unread(&mut self, children: &[Digest]) {
        let mut others: Vec<usize> = (0..self.module.instances.len()).collect();
        loop {
            others.retain(|at| !self.numbers.contains_key(&Part::Instance(*at)));
            let first = others
                .iter()
                .copied()
                .min_by_key(|at| self.tried(*at, children));
            let Some(first) = first else { return };
            self.number(Part::Instance(first));
            self.run(children);
        }
    }

    /// Hash of an instance's encoding after what is encoded so far.
    fn tried(&self, instance: usize, children: &[Digest]) -> [u8; 32] {
        let mut to = Encoding::new("");
        let mut walk = Walk {
            module: self.module,
            inputs: self.inputs.clone(),
            numbers: self.numbers.clone(),
            met: VecDeque::new(),
            to: &mut to,
        };
        walk.number(Part::Instance(instance));
        walk.run(children);
        *to.finish().as_bytes()
    }

    /// Encodes the number of a part, which it gets here if it was not met before.
    fn number(&mut self, part: Part) {
        let next = self.numbers.len();
        let number = *self.numbers.entry(part).or_insert(next);
        if number == next {
            self.met.push_back(part);
        }
        self.to.number(number);
    }

    /// Encodes the number of a node, past its aliases; a constant by its type and value, however
    /// many nodes share it.
    fn node(&mut self, mut id: usize) {
        let nodes = &self.module.nodes;
        while let Op::Cast(of) = nodes[id].op
            && nodes[of].ty == nodes[id].ty
        {
            id = of;
        }
        if let Op::Lit(value) = &nodes[id].op {
            self.to.number(CONSTANT);
            self.to.ty(nodes[id].ty);
            self.to.big(value);
            return;
        }
        self.number(Part::Node(id));
    }

    fn nodes(&mut self, ids: &[usize]) {
        self.to.number(ids.len());
        for id in ids {
            self.node(*id);
        }
    }

    /// Encodes all parts that are met.
    fn run(&mut self, children: &[Digest]) {
        while let Some(part) = self.met.pop_front() {
            match part {
                Part::Node(id) => self.operation(id),
                Part::Memory(at) => self.memory(at),
                Part::Instance(at) => self.instance(at, children[at]),
            }
        }
    }

    /// The tag of an operation, its type, its numbers and its operands. The `match` names every
    /// operation: a new one does not compile until it has a tag.
    fn operation(&mut self, id: usize) {
        let module = self.module;
        let node = &module.nodes[id];
        self.to.tag(b'n');
        self.to.ty(node.ty);
        match &node.op {
            Op::Input => {
                self.to.tag(0);
                let name = self.inputs.get(&id).copied().unwrap_or_default();
                self.to.text(name);
            }
            Op::OutOfReset => self.to.tag(1),
            // Encoded where it is used.
            Op::Lit(_) => self.to.tag(2),
            Op::Unary(operator, a) => {
                self.to.tag(3);
                self.to.unary(*operator);
                self.node(*a);
            }
            Op::Binary(operator, a, b) => {
                self.to.tag(4);
                self.to.binary(*operator);
                self.nodes(&[*a, *b]);
            }
            Op::Shl(a, amount) => {
                self.to.tag(5);
                self.nodes(&[*a, *amount]);
            }
            Op::Shr(a, amount) => {
                self.to.tag(6);
                self.nodes(&[*a, *amount]);
            }
            Op::Slice(a, low) => {
                self.to.tag(7);
                self.to.number(*low as usize);
                self.node(*a);
            }
            Op::Cat(parts) => {
                self.to.tag(8);
                self.nodes(parts);
            }
            Op::Repeat(a, count) => {
                self.to.tag(9);
                self.to.number(*count as usize);
                self.node(*a);
            }
            Op::Extend(a) => {
                self.to.tag(10);
                self.node(*a);
            }
            Op::Cast(a) => {
                self.to.tag(11);
                self.node(*a);
            }
            Op::Round(a, dropped, rounding) => {
                self.to.tag(12);
                self.to.number(*dropped as usize);
                self.to.rounding(*rounding);
                self.node(*a);
            }
            Op::Saturate(a) => {
                self.to.tag(13);
                self.node(*a);
            }
            Op::Mux(condition, then, other) => {
                self.to.tag(14);
                self.nodes(&[*condition, *then, *other]);
            }
            Op::Select(index, options) => {
                self.to.tag(15);
                self.node(*index);
                self.nodes(options);
            }
            Op::Reg {
                reset,
                next,
                enable,
            } => {
                match reset {
                    Some(reset) => {
                        self.to.tag(16);
                        self.to.big(reset);
                    }
                    None => self.to.tag(20),
                }
                for operand in [next, enable] {
                    self.nodes(operand.as_slice());
                }
            }
            Op::ReadSync(memory, enable, address) => {
                self.to.tag(17);
                self.number(Part::Memory(*memory));
                self.nodes(&[*enable, *address]);
            }
            Op::ReadAsync(memory, address) => {
                self.to.tag(18);
                self.number(Part::Memory(*memory));
                self.node(*address);
            }
            Op::InstanceOut(instance, port) => {
                self.to.tag(19);
                self.number(Part::Instance(*instance));
                self.to
                    .text(&module.instances[*instance].module.ports[*port].name);
            }
        }
    }

    /// A memory; later writes have priority, so that their order counts.
    fn memory(&mut self, at: usize) {
        let module = self.module;
        let memory = &module.memories[at];
        self.to.tag(b'm');
        self.to.number(memory.depth as usize);
        self.to.number(memory.width as usize);
        self.to.number(memory.writes.len());
        for (enable, address, data) in &memory.writes {
            self.nodes(&[*enable, *address, *data]);
        }
    }

    fn instance(&mut self, at: usize, digest: Digest) {
        let module = self.module;
        let instance = &module.instances[at];
        self.to.tag(b'i');
        self.to.hash(digest.0);
        let ports = &instance.module.ports;
        let mut inputs: Vec<(&str, usize)> = (instance.inputs.iter())
            .map(|(port, node)| (&*ports[*port].name, *node))
            .collect();
        inputs.sort_unstable();
        self.to.number(inputs.len());
        for (port, node) in inputs {
            self.to.text(port);
            self.node(node);
        }
    }
}
