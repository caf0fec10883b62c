//! Flattens a hierarchy to one list of operations in topological order.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_traits::One;

use super::memory::{Rows, scramble};
use super::step::{Code, Slot, Step};
use super::words;
use crate::Module;
use crate::node::{Op, Ty};
use crate::tree::{Tree, Unit};

/// Slots of the nodes of a module and of its instances.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub(super) slots: Vec<Slot>,
    pub(super) instances: Vec<Layout>,
}

/// Next value of a state.
#[derive(Debug, Clone)]
pub(super) enum Next {
    Value {
        reset: Option<Vec<u64>>,
        from: Slot,
        enable: Option<Slot>,
    },
    Row {
        memory: usize,
        enable: Slot,
        address: Slot,
    },
}

/// State held from one cycle to the next.
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
    /// `rst_n` of all modules.
    pub(super) reset: Option<Slot>,
    seed: u64,
}

/// The low `width` bits of a value in two's complement, as words.
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
            reset: None,
            seed,
        }
    }

    /// Allocates a new slot, initially 0.
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

    /// Adds a module with inputs from `inputs`, by node.
    pub(super) fn add(&mut self, module: &Module, inputs: &BTreeMap<usize, Slot>) -> Layout {
        let mut tree = Tree::default();
        tree.add(module, None);
        let mut slots: Vec<Option<Slot>> = vec![None; tree.unit_of.len()];
        for unit in &tree.units {
            for memory in &unit.module.memories {
                let seed = scramble(self.seed, (self.memories.len() as u64) << 40);
                let rows = Rows::new(memory.depth, memory.width, seed);
                self.memories.push(rows);
            }
        }
        // What a node needs comes before it, across the hierarchy: the checks
        // left no loop.
        let mut stack: Vec<(usize, bool)> = vec![];
        for start in 0..slots.len() {
            stack.push((start, false));
            while let Some((node, ready)) = stack.pop() {
                if slots[node].is_some() {
                    continue;
                }
                if ready {
                    slots[node] = Some(self.place(&tree, node, inputs, &slots));
                } else {
                    stack.push((node, true));
                    let needed = tree.needs(node).into_iter().rev();
                    stack.extend(needed.map(|n| (n, false)));
                }
            }
        }
        let slots: Vec<Slot> = slots.into_iter().flatten().collect();
        for unit in &tree.units {
            self.connect(unit, &slots[unit.first_node..]);
        }
        layout(&tree, 0, &slots)
    }

    /// Allocates a slot for a node, and adds its operation.
    fn place(
        &mut self,
        tree: &Tree<'_>,
        node: usize,
        inputs: &BTreeMap<usize, Slot>,
        slots: &[Option<Slot>],
    ) -> Slot {
        let (unit, id) = tree.find(node);
        let ty = unit.module.nodes[id].ty;
        let at = |n: usize| slots[n].unwrap_or(Slot { at: 0, ty });
        let slot = |n: &usize| at(unit.first_node + n);
        let code = match &unit.module.nodes[id].op {
            Op::Input | Op::InstanceOut(..) => {
                let source = tree.needs(node).first().map(|n| at(*n));
                let given = source.or_else(|| inputs.get(&id).copied());
                return given.unwrap_or_else(|| self.allocate(ty));
            }
            Op::OutOfReset => return self.reset.unwrap_or_else(|| self.allocate(ty)),
            Op::Lit(value) => {
                let s = self.allocate(ty);
                self.values[s.at..].copy_from_slice(&code(value, ty.width));
                return s;
            }
            Op::Reg { .. } | Op::ReadSync(..) => return self.random(ty),
            Op::Cast(a) => return Slot { at: slot(a).at, ty },
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
            Op::ReadAsync(m, addr) => Code::Read(unit.first_memory + m, slot(addr)),
        };
        let out = self.allocate(ty);
        self.steps.push(Step::new(code, out));
        out
    }

    /// Gives registers their reset values, and 0 to those that have none.
    pub(super) fn reset_registers(&mut self) {
        for state in &self.states {
            if let Next::Value { reset, .. } = &state.next {
                let out = &mut self.values[state.slot.at..][..state.slot.words()];
                match reset {
                    Some(reset) => out.copy_from_slice(reset),
                    None => out.fill(0),
                }
            }
        }
    }

    /// Adds the updates at the clock edge.
    fn connect(&mut self, unit: &Unit<'_>, slots: &[Slot]) {
        let slot = |n: &usize| slots[*n];
        for (id, node) in unit.module.nodes.iter().enumerate() {
            let next = match &node.op {
                Op::Reg {
                    reset,
                    next,
                    enable,
                } => Next::Value {
                    reset: reset.as_ref().map(|value| code(value, node.ty.width)),
                    // A register that nothing drives, which the checks refuse, holds.
                    from: next.as_ref().map_or(slot(&id), slot),
                    enable: enable.as_ref().map(slot),
                },
                Op::ReadSync(m, en, addr) => Next::Row {
                    memory: unit.first_memory + m,
                    enable: slot(en),
                    address: slot(addr),
                },
                _ => continue,
            };
            let slot = slot(&id);
            self.states.push(State { slot, next });
        }
        for (i, memory) in unit.module.memories.iter().enumerate() {
            let writes = memory.writes.iter().map(|(en, addr, data)| Write {
                memory: unit.first_memory + i,
                enable: slot(en),
                address: slot(addr),
                data: slot(data),
            });
            self.writes.extend(writes);
        }
    }
}

fn layout(tree: &Tree<'_>, unit: usize, slots: &[Slot]) -> Layout {
    let unit = &tree.units[unit];
    let nodes = unit.first_node..unit.first_node + unit.module.nodes.len();
    Layout {
        slots: slots[nodes].to_vec(),
        instances: unit
            .children
            .iter()
            .map(|c| layout(tree, *c, slots))
            .collect(),
    }
}
