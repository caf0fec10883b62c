//! Random modules with every kind of node.

use std::sync::Arc;

use potamoi_formats::fixed::Rounding;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::{MemId, Module, ModuleBuilder, Signal, Ty};

/// Types of the values that nodes are made from.
const TYPES: [Ty; 3] = [Ty::u(8), Ty::s(8), Ty::bit()];
/// Nodes of a random module.
const STEPS: usize = 60;

/// A register of eight bits.
pub(super) fn child(name: &str, reset: u32) -> Arc<Module> {
    let mut m = ModuleBuilder::new(name);
    let d = m.input("d", Ty::u(8), "what it takes");
    let q = m.reg("held", Ty::u(8), reset);
    m.set_next(q, d);
    m.output("q", q, "what it holds");
    m.finish().unwrap()
}

struct Making {
    m: ModuleBuilder,
    r: Pcg64Mcg,
    values: Vec<Signal>,
    memories: Vec<MemId>,
    child: Arc<Module>,
    names: usize,
}

impl Making {
    fn any(&mut self) -> Signal {
        self.values[self.r.random_range(0..self.values.len())]
    }

    fn name(&mut self, stem: &str) -> String {
        self.names += 1;
        format!("{stem}_{}", self.names)
    }

    /// A value made to fit a type.
    fn any_as(&mut self, ty: Ty) -> Signal {
        let s = self.any();
        let sized = if s.width() < ty.width {
            self.m.extend(s, ty.width)
        } else {
            self.m.truncate(s, ty.width)
        };
        match ty.signed {
            true => self.m.as_signed(sized),
            false => self.m.as_unsigned(sized),
        }
    }

    fn pair(&mut self) -> (Signal, Signal) {
        let ty = TYPES[self.r.random_range(0..2)];
        (self.any_as(ty), self.any_as(ty))
    }

    fn step(&mut self) -> Signal {
        let byte = Ty::u(8);
        let m = |own: &mut Self, make: fn(&mut ModuleBuilder, Signal, Signal) -> Signal| {
            let (a, b) = own.pair();
            make(&mut own.m, a, b)
        };
        match self.r.random_range(0..30) {
            0 => m(self, ModuleBuilder::and),
            1 => m(self, ModuleBuilder::or),
            2 => m(self, ModuleBuilder::xor),
            3 => m(self, ModuleBuilder::add),
            4 => m(self, ModuleBuilder::sub),
            5 => m(self, ModuleBuilder::mul),
            6 => m(self, ModuleBuilder::eq),
            7 => m(self, ModuleBuilder::ne),
            8 => m(self, ModuleBuilder::lt),
            9 => m(self, ModuleBuilder::le),
            10 => m(self, |m, a, _| m.not(a)),
            11 => m(self, |m, a, _| m.neg(a)),
            12 => m(self, |m, a, _| m.any(a)),
            13 => m(self, |m, a, _| m.all(a)),
            14 => m(self, |m, a, _| m.parity(a)),
            15 => {
                let (a, by) = (self.any(), self.any_as(Ty::u(3)));
                self.m.shl(a, by)
            }
            16 => {
                let (a, by) = (self.any(), self.any_as(Ty::u(3)));
                self.m.shr(a, by)
            }
            17 => {
                let (a, low) = (self.any_as(byte), self.r.random_range(0..6));
                self.m.slice(a, low, 2)
            }
            18 => m(self, |m, a, b| m.cat(&[a, b])),
            19 => {
                let (a, count) = (self.any_as(Ty::u(2)), self.r.random_range(2..5));
                self.m.repeat(a, count)
            }
            20 => m(self, |m, a, _| m.extend(a, 11)),
            21 => m(self, |m, a, _| match a.signed() {
                true => m.as_unsigned(a),
                false => m.as_signed(a),
            }),
            22 => {
                let (a, bits) = (self.any_as(Ty::s(8)), self.r.random_range(1..5));
                let modes = [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven];
                let mode = modes[self.r.random_range(0..3)];
                self.m.round(a, bits, mode)
            }
            23 => m(self, |m, a, _| m.saturate(a, Ty::s(5))),
            24 => {
                let condition = self.any_as(Ty::bit());
                let (a, b) = self.pair();
                self.m.mux(condition, a, b)
            }
            25 => {
                let index = self.any_as(Ty::u(2));
                let options = [0; 4].map(|_| self.any_as(byte));
                self.m.select(index, &options)
            }
            26 => {
                let value = self.r.random_range(0..256u32);
                self.m.lit(value, byte)
            }
            27 => {
                let memory = self.memories[self.r.random_range(0..2)];
                let (enable, address) = (self.any_as(Ty::bit()), self.any_as(Ty::u(3)));
                let name = self.name("read");
                self.m.mem_read(memory, enable, address, &name)
            }
            28 => {
                let memory = self.memories[self.r.random_range(0..2)];
                let address = self.any_as(Ty::u(3));
                self.m.mem_read_async(memory, address)
            }
            _ => {
                let (d, name) = (self.any_as(byte), self.name("part"));
                let child = self.child.clone();
                let instance = self.m.instance(&name, &child, &[("d", d)]);
                self.m.out(instance, "q")
            }
        }
    }
}

/// A random module `random` over a module `child`.
pub(super) fn random(seed: u64) -> Arc<Module> {
    let mut m = ModuleBuilder::new("random");
    m.doc("nodes by chance");
    let mut values = vec![];
    for (at, ty) in TYPES.into_iter().enumerate() {
        let input = m.input(&format!("in_{at}"), ty, "anything");
        m.unused(input, "chance may have left it out");
        values.push(input);
    }
    let registers = [0, 1].map(|at| m.reg(&format!("state_{at}"), TYPES[at], at as u32));
    let data = m.data_reg("data", TYPES[0]);
    values.extend(registers);
    values.push(data);
    let memories = [5, 8].map(|depth| m.memory(&format!("rows_{depth}"), depth, 8, "rows"));
    let mut own = Making {
        m,
        r: Pcg64Mcg::seed_from_u64(seed),
        values,
        memories: memories.to_vec(),
        child: child("child", 3),
        names: 0,
    };
    for at in 0..STEPS {
        if at % 20 == 0 {
            own.m.section(&format!("part {at}"));
        }
        let s = own.step();
        let name = own.name("wire");
        let s = if at % 3 == 0 { own.m.name(s, &name) } else { s };
        own.m.note(s, "of a kind");
        own.values.push(s);
    }
    for at in 0..2 {
        let (enable, address) = (own.any_as(Ty::bit()), own.any_as(Ty::u(3)));
        for _ in 0..2 {
            let data = own.any_as(Ty::u(8));
            own.m.mem_write(memories[at], enable, address, data);
        }
        let next = own.any_as(TYPES[at]);
        match at {
            0 => own.m.set_next_if(registers[at], enable, next),
            _ => own.m.set_next(registers[at], next),
        }
    }
    let next = own.any_as(data.ty());
    own.m.set_next(data, next);
    let up = own.any_as(Ty::bit());
    own.m.output_low_in_reset("ready", up, "one bit");
    for at in 0..6 {
        let shown = own.any();
        own.m.output(&format!("out_{at}"), shown, "any value");
    }
    own.m.finish().unwrap()
}
