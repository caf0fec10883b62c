//! Registers and memories.

use num_bigint::BigInt;

use super::ModuleBuilder;
use crate::node::{MemId, Memory, Op, Signal, Ty};

impl ModuleBuilder {
    /// A register with a reset value.
    pub fn reg(&mut self, name: &str, ty: Ty, reset: impl Into<BigInt>) -> Signal {
        let (mut reset, ty) = (reset.into(), self.legal(ty));
        if reset < ty.min() || reset > ty.max() {
            self.fail(name, format!("reset value {reset} does not fit {ty}"));
            reset = BigInt::ZERO;
        }
        self.register(name, ty, Some(reset))
    }

    /// A register without a reset, for data: nothing depends on it before it is written.
    ///
    /// It starts with any value, and keeps what it holds, or takes its next value, in reset.
    pub fn data_reg(&mut self, name: &str, ty: Ty) -> Signal {
        let ty = self.legal(ty);
        self.register(name, ty, None)
    }

    fn register(&mut self, name: &str, ty: Ty, reset: Option<BigInt>) -> Signal {
        let s = self.node(
            Op::Reg {
                reset,
                next: None,
                enable: None,
            },
            ty,
        );
        self.module.nodes[s.id].name = Some(name.to_owned());
        s
    }

    /// Sets the next value of a register, taken at every clock edge.
    pub fn set_next(&mut self, reg: Signal, value: Signal) {
        self.drive(reg, None, value);
    }

    /// Sets the next value of a register, taken at clock edges with `enable` set.
    pub fn set_next_if(&mut self, reg: Signal, enable: Signal, value: Signal) {
        if enable.ty == Ty::bit() {
            let always = matches!(&self.module.nodes[enable.id].op, Op::Lit(v) if *v == 1.into());
            self.drive(reg, (!always).then_some(enable.id), value);
        } else {
            let of = self.describe(enable);
            self.fail(
                "set_next_if",
                format!("enable {of} is not one unsigned bit"),
            );
        }
    }

    fn drive(&mut self, reg: Signal, by: Option<usize>, value: Signal) {
        let what = self.describe(reg);
        if !self.agree(&what, reg, value) {
            return;
        }
        let problem = match &mut self.module.nodes[reg.id].op {
            Op::Reg { next: Some(_), .. } => "driven twice",
            Op::Reg { next, enable, .. } => {
                *next = Some(value.id);
                *enable = by;
                return;
            }
            _ => "not a register",
        };
        self.fail(&what, problem.to_owned());
    }

    /// A memory that tools can infer from an array.
    pub fn memory(&mut self, name: &str, depth: u32, width: u32, doc: &str) -> MemId {
        let fits = (1..=65_536).contains(&width);
        if depth < 2 || !fits {
            let found = format!("memory of {depth} rows of {width} bits");
            self.fail(
                name,
                format!("{found}: expected 2 rows at least, of 1 to 65536 bits"),
            );
        }
        self.module.memories.push(Memory {
            name: name.to_owned(),
            depth: depth.max(2),
            width: if fits { width } else { 1 },
            doc: doc.to_owned(),
            at: self.module.nodes.len(),
            writes: vec![],
        });
        MemId(self.module.memories.len() - 1)
    }

    fn address(&mut self, mem: MemId, addr: Signal) -> bool {
        let memory = &self.module.memories[mem.0];
        let bits = (memory.depth - 1).ilog2() + 1;
        let right = addr.ty == Ty::u(bits);
        if !right {
            let (name, of) = (memory.name.clone(), self.describe(addr));
            self.fail(&name, format!("address {of}: expected u{bits}"));
        }
        right
    }

    /// Writes at the clock edge when `en` is set. Writes to addresses past the depth are ignored.
    pub fn mem_write(&mut self, mem: MemId, en: Signal, addr: Signal, data: Signal) {
        let width = self.module.memories[mem.0].width;
        if self.address(mem, addr) && data.ty == Ty::u(width) && en.ty == Ty::bit() {
            self.module.memories[mem.0]
                .writes
                .push((en.id, addr.id, data.id));
        } else if data.ty != Ty::u(width) || en.ty != Ty::bit() {
            let of = self.describe(data);
            self.fail(
                "mem_write",
                format!("data {of} (expected u{width}) or enable is of the wrong type"),
            );
        }
    }

    /// Reads at the clock edge when `en` is set; the old value if the row is written at the same
    /// edge. The output is held otherwise, and has no reset.
    pub fn mem_read(&mut self, mem: MemId, en: Signal, addr: Signal, name: &str) -> Signal {
        let width = self.module.memories[mem.0].width;
        if en.ty != Ty::bit() {
            let of = self.describe(en);
            self.fail(name, format!("enable {of} is not one unsigned bit"));
        }
        if !self.address(mem, addr) {
            return self.zero(Ty::u(width));
        }
        let s = self.node(Op::ReadSync(mem.0, en.id, addr.id), Ty::u(width));
        self.module.nodes[s.id].name = Some(name.to_owned());
        s
    }

    /// Reads combinationally.
    pub fn mem_read_async(&mut self, mem: MemId, addr: Signal) -> Signal {
        let width = self.module.memories[mem.0].width;
        if !self.address(mem, addr) {
            return self.zero(Ty::u(width));
        }
        self.node(Op::ReadAsync(mem.0, addr.id), Ty::u(width))
    }
}
