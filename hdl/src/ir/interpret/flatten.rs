//! A hierarchy as one list of operations in the order of their dependence.

use num_bigint::BigInt;
use num_traits::One;

use super::memory::{Rows, scramble};
use super::step::{Code, Slot, Step};
use super::words;
use crate::ir::Module;
use crate::ir::node::{Op, Ty};

/// Where the nodes of a module and of the instances below it lie.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub(super) slots: Vec<Slot>,
    pub(super) instances: Vec<Layout>,
}

/// What a register takes over at an edge.
#[derive(Debug, Clone)]
pub(super) enum Next {
    Value {
        reset: Vec<u64>,
        from: Slot,
        enable: Option<Slot>,
    },
    Row {
        memory: usize,
        enable: Slot,
        address: Slot,
    },
}

/// A value that is kept from one cycle to the next.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) slot: Slot,
    pub(super) next: Next,
}

#[derive(Debug, Clone)]
pub(super) struct Write {
    pub(super) memory: usize,
    pub(super) enable: Slot,
    pub(super) address: Slot,
    pub(super) data: Slot,
}

/// The flat machine.
#[derive(Debug, Clone)]
pub(super) struct Flat {
    pub(super) values: Vec<u64>,
    pub(super) steps: Vec<Step>,
    pub(super) states: Vec<State>,
    pub(super) writes: Vec<Write>,
    pub(super) memories: Vec<Rows>,
    seed: u64,
}

/// The low words of a value's two's complement, `width` bits of them.
pub(super) fn code(value: &BigInt, width: u32) -> Vec<u64> {
    let modulus = BigInt::one() << width;
    let positive = ((value % &modulus) + &modulus) % &modulus;
    let mut digits = positive.magnitude().to_u64_digits();
    digits.resize(words::count(width), 0);
    digits
}

impl Flat {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            values: vec![],
            steps: vec![],
            states: vec![],
            writes: vec![],
            memories: vec![],
            seed,
        }
    }

    /// Room for a value past all others, which is 0.
    pub(super) fn allocate(&mut self, ty: Ty) -> Slot {
        let slot = Slot {
            at: self.values.len(),
            ty,
        };
        self.values.resize(slot.at + slot.words(), 0);
        slot
    }

    fn random(&mut self, ty: Ty) -> Slot {
        let slot = self.allocate(ty);
        for at in slot.at..self.values.len() {
            self.values[at] = scramble(self.seed, at as u64);
        }
        words::trim(&mut self.values[slot.at..], ty.width);
        slot
    }

    /// Adds a module whose inputs come from `inputs`, by port.
    pub(super) fn add(&mut self, module: &Module, inputs: &[(usize, Slot)]) -> Layout {
        let mut layout = Layout {
            slots: Vec::with_capacity(module.nodes.len()),
            instances: vec![],
        };
        let first_memory = self.memories.len();
        for memory in &module.memories {
            let seed = scramble(self.seed, (self.memories.len() as u64) << 40);
            self.memories
                .push(Rows::new(memory.depth, memory.width, seed));
        }
        for (id, node) in module.nodes.iter().enumerate() {
            self.instances_before(module, id, &mut layout);
            let slot = |n: &usize| layout.slots[*n];
            let step = match &node.op {
                Op::Input => {
                    let port = inputs.iter().find(|(p, _)| module.ports[*p].node == id);
                    let given = port.map(|(_, s)| *s);
                    layout
                        .slots
                        .push(given.unwrap_or_else(|| self.allocate(node.ty)));
                    continue;
                }
                Op::Lit(value) => {
                    let s = self.allocate(node.ty);
                    self.values[s.at..].copy_from_slice(&code(value, node.ty.width));
                    layout.slots.push(s);
                    continue;
                }
                Op::Reg { .. } | Op::ReadSync(..) => {
                    layout.slots.push(self.random(node.ty));
                    continue;
                }
                Op::InstanceOut(i, port) => {
                    let inner = module.instances[*i].module.ports[*port].node;
                    layout.slots.push(layout.instances[*i].slots[inner]);
                    continue;
                }
                Op::Cast(a) => {
                    let s = Slot {
                        at: slot(a).at,
                        ty: node.ty,
                    };
                    layout.slots.push(s);
                    continue;
                }
                Op::Unary(op, a) => Code::Unary(*op, slot(a)),
                Op::Binary(op, a, b) => Code::Binary(*op, slot(a), slot(b)),
                Op::Shl(a, n) => Code::Shl(slot(a), slot(n)),
                Op::Shr(a, n) => Code::Shr(slot(a), slot(n)),
                Op::Slice(a, low) => Code::Extract(slot(a), *low),
                Op::Extend(a) => Code::Extract(slot(a), 0),
                Op::Cat(parts) => Code::Cat(parts.iter().map(slot).collect()),
                Op::Repeat(a, n) => Code::Repeat(slot(a), *n),
                Op::Round(a, bits, rounding) => Code::Round(slot(a), *bits, *rounding),
                Op::Saturate(a) => Code::Saturate(slot(a)),
                Op::Mux(c, t, e) => Code::Mux(slot(c), slot(t), slot(e)),
                Op::Select(i, options) => Code::Select(slot(i), options.iter().map(slot).collect()),
                Op::ReadAsync(m, addr) => Code::Read(first_memory + m, slot(addr)),
            };
            let out = self.allocate(node.ty);
            self.steps.push(Step::new(step, out));
            layout.slots.push(out);
        }
        self.instances_before(module, module.nodes.len(), &mut layout);
        self.connect(module, &layout, first_memory);
        layout
    }

    fn instances_before(&mut self, module: &Module, id: usize, layout: &mut Layout) {
        while let Some(inst) = module
            .instances
            .get(layout.instances.len())
            .filter(|i| i.at <= id)
        {
            let inputs: Vec<_> = inst
                .inputs
                .iter()
                .map(|(port, n)| (*port, layout.slots[*n]))
                .collect();
            layout.instances.push(self.add(&inst.module, &inputs));
        }
    }

    /// What happens at the edge.
    fn connect(&mut self, module: &Module, layout: &Layout, first_memory: usize) {
        let slot = |n: &usize| layout.slots[*n];
        for (id, node) in module.nodes.iter().enumerate() {
            let next = match &node.op {
                Op::Reg {
                    reset,
                    next,
                    enable,
                } => Next::Value {
                    reset: code(reset, node.ty.width),
                    // A register that nothing drives, which the checks refuse, holds.
                    from: next.as_ref().map_or(slot(&id), slot),
                    enable: enable.as_ref().map(slot),
                },
                Op::ReadSync(m, en, addr) => Next::Row {
                    memory: first_memory + m,
                    enable: slot(en),
                    address: slot(addr),
                },
                _ => continue,
            };
            self.states.push(State {
                slot: slot(&id),
                next,
            });
        }
        for (i, memory) in module.memories.iter().enumerate() {
            self.writes
                .extend(memory.writes.iter().map(|(en, addr, data)| Write {
                    memory: first_memory + i,
                    enable: slot(en),
                    address: slot(addr),
                    data: slot(data),
                }));
        }
    }
}
