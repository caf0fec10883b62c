//! Builds a module node by node.

use std::collections::BTreeMap;
use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::fixed::Rounding;

use super::node::{
    Binary, Contract, Inst, Instance, MemId, Memory, Node, Op, Port, Signal, Ty, Unary,
};
use super::{IrError, IrErrors, Module, check};

/// Builds one module. Misuse never panics: it is recorded, a well-typed
/// stand-in is returned, and [`ModuleBuilder::finish`] reports it.
#[derive(Debug)]
pub struct ModuleBuilder {
    module: Module,
    errors: Vec<IrError>,
    section: usize,
}

impl ModuleBuilder {
    /// An empty module.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self {
            module: Module {
                name: name.to_owned(),
                doc: String::new(),
                nodes: vec![],
                ports: vec![],
                memories: vec![],
                instances: vec![],
                contracts: vec![],
                sections: vec![String::new()],
                unused: BTreeMap::new(),
                clocked: false,
                registers: false,
            },
            errors: vec![],
            section: 0,
        }
    }

    /// What the module is, for its header.
    pub fn doc(&mut self, text: &str) {
        text.clone_into(&mut self.module.doc);
    }

    /// Starts a commented section of the printed body.
    pub fn section(&mut self, title: &str) {
        self.section = self.module.sections.len();
        self.module.sections.push(title.to_owned());
    }

    pub(crate) fn fail(&mut self, what: &str, problem: String) {
        self.errors.push(IrError {
            module: self.module.name.clone(),
            node: what.to_owned(),
            problem,
        });
    }

    /// The type, or one bit if no node can have it.
    fn legal(&mut self, ty: Ty) -> Ty {
        if (1..=65_536).contains(&ty.width) {
            return ty;
        }
        self.fail("a node", format!("width {}: expected 1 to 65536", ty.width));
        Ty { width: 1, ..ty }
    }

    fn node(&mut self, op: Op, ty: Ty) -> Signal {
        let ty = self.legal(ty);
        self.module.nodes.push(Node {
            op,
            ty,
            name: None,
            note: None,
            section: self.section,
            exact: false,
        });
        Signal {
            id: self.module.nodes.len() - 1,
            ty,
        }
    }

    fn describe(&self, s: Signal) -> String {
        match self.module.nodes.get(s.id).and_then(|n| n.name.as_ref()) {
            Some(name) => format!("{name}: {}", s.ty),
            None => format!("unnamed: {}", s.ty),
        }
    }

    fn zero(&mut self, ty: Ty) -> Signal {
        self.node(Op::Lit(BigInt::ZERO), ty)
    }

    fn agree(&mut self, what: &str, a: Signal, b: Signal) -> bool {
        if a.ty == b.ty {
            return true;
        }
        let (a, b) = (self.describe(a), self.describe(b));
        self.fail(
            what,
            format!("operands differ: {a} and {b}; extend, truncate or reinterpret one"),
        );
        false
    }

    /// An input port.
    pub fn input(&mut self, name: &str, ty: Ty, doc: &str) -> Signal {
        let s = self.node(Op::Input, ty);
        self.module.nodes[s.id].name = Some(name.to_owned());
        self.port(name, s, false, doc);
        s
    }

    /// An output port.
    pub fn output(&mut self, name: &str, s: Signal, doc: &str) {
        self.port(name, s, true, doc);
    }

    fn port(&mut self, name: &str, s: Signal, output: bool, doc: &str) {
        self.module.ports.push(Port {
            name: name.to_owned(),
            node: s.id,
            output,
            doc: doc.to_owned(),
        });
    }

    /// Says why an input is not read, so that it is no mistake.
    pub fn unused(&mut self, s: Signal, why: &str) {
        self.module.unused.insert(s.id, why.to_owned());
    }

    /// A constant.
    pub fn lit(&mut self, value: impl Into<BigInt>, ty: Ty) -> Signal {
        let (value, ty) = (value.into(), self.legal(ty));
        if value < ty.min() || value > ty.max() {
            self.fail("a constant", format!("{value} does not fit {ty}"));
            return self.zero(ty);
        }
        self.node(Op::Lit(value), ty)
    }

    /// A constant that prints as a `localparam`.
    pub fn param(&mut self, name: &str, value: impl Into<BigInt>, ty: Ty, doc: &str) -> Signal {
        let s = self.lit(value, ty);
        self.module.nodes[s.id].name = Some(name.to_owned());
        self.note(s, doc);
        s
    }

    /// Gives a signal its name in the Verilog.
    pub fn name(&mut self, s: Signal, name: &str) -> Signal {
        let node = &mut self.module.nodes[s.id];
        match &node.name {
            None => node.name = Some(name.to_owned()),
            Some(old) if old == name => {}
            // A second name for one value is a wire of its own.
            Some(_) => {
                let alias = self.node(Op::Cast(s.id), s.ty);
                self.module.nodes[alias.id].name = Some(name.to_owned());
                return alias;
            }
        }
        s
    }

    /// Adds a comment at a signal's declaration.
    pub fn note(&mut self, s: Signal, text: &str) -> Signal {
        self.module.nodes[s.id].note = Some(text.to_owned()).filter(|t| !t.is_empty());
        s
    }

    /// Claims that the node's result never wraps; the range analysis proves it.
    pub fn exact(&mut self, s: Signal) -> Signal {
        self.module.nodes[s.id].exact = true;
        s
    }

    fn binary(&mut self, what: &str, op: Binary, a: Signal, b: Signal, ty: Ty) -> Signal {
        if self.agree(what, a, b) {
            self.node(Op::Binary(op, a.id, b.id), ty)
        } else {
            self.zero(ty)
        }
    }

    /// Bitwise and.
    pub fn and(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("and", Binary::And, a, b, a.ty)
    }

    /// Bitwise or.
    pub fn or(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("or", Binary::Or, a, b, a.ty)
    }

    /// Bitwise exclusive or.
    pub fn xor(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("xor", Binary::Xor, a, b, a.ty)
    }

    /// Bitwise complement.
    pub fn not(&mut self, a: Signal) -> Signal {
        self.node(Op::Unary(Unary::Not, a.id), a.ty)
    }

    /// Two's complement negation, wrapping.
    pub fn neg(&mut self, a: Signal) -> Signal {
        self.node(Op::Unary(Unary::Neg, a.id), a.ty)
    }

    /// Whether any bit is set.
    pub fn any(&mut self, a: Signal) -> Signal {
        self.node(Op::Unary(Unary::Any, a.id), Ty::bit())
    }

    /// Whether all bits are set.
    pub fn all(&mut self, a: Signal) -> Signal {
        self.node(Op::Unary(Unary::All, a.id), Ty::bit())
    }

    /// Exclusive or of all bits.
    pub fn parity(&mut self, a: Signal) -> Signal {
        self.node(Op::Unary(Unary::Parity, a.id), Ty::bit())
    }

    /// Sum of the operands' type, wrapping.
    pub fn add(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("add", Binary::Add, a, b, a.ty)
    }

    /// Difference of the operands' type, wrapping.
    pub fn sub(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("sub", Binary::Sub, a, b, a.ty)
    }

    /// Full product: the widths add up. Both signed or both unsigned.
    pub fn mul(&mut self, a: Signal, b: Signal) -> Signal {
        let ty = Ty {
            width: a.ty.width + b.ty.width,
            signed: a.ty.signed,
        };
        if a.ty.signed == b.ty.signed {
            self.node(Op::Binary(Binary::Mul, a.id, b.id), ty)
        } else {
            let (x, y) = (self.describe(a), self.describe(b));
            self.fail("mul", format!("signedness differs: {x} and {y}"));
            self.zero(ty)
        }
    }

    /// Equal.
    pub fn eq(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("eq", Binary::Eq, a, b, Ty::bit())
    }

    /// Not equal.
    pub fn ne(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("ne", Binary::Ne, a, b, Ty::bit())
    }

    /// Less.
    pub fn lt(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("lt", Binary::Lt, a, b, Ty::bit())
    }

    /// Less or equal.
    pub fn le(&mut self, a: Signal, b: Signal) -> Signal {
        self.binary("le", Binary::Le, a, b, Ty::bit())
    }

    /// Greater.
    pub fn gt(&mut self, a: Signal, b: Signal) -> Signal {
        self.lt(b, a)
    }

    /// Greater or equal.
    pub fn ge(&mut self, a: Signal, b: Signal) -> Signal {
        self.le(b, a)
    }

    /// Shift left by an unsigned signal; the width stays.
    pub fn shl(&mut self, a: Signal, amount: Signal) -> Signal {
        let amount = self.shift_amount("shl", amount);
        self.node(Op::Shl(a.id, amount.id), a.ty)
    }

    /// Shift right by an unsigned signal, arithmetic when signed.
    pub fn shr(&mut self, a: Signal, amount: Signal) -> Signal {
        let amount = self.shift_amount("shr", amount);
        self.node(Op::Shr(a.id, amount.id), a.ty)
    }

    /// The amount in at most 32 bits: any above shifts everything out. Verilator
    /// 5.006 shifts values of up to 64 bits by amounts of more than 64 wrongly.
    fn shift_amount(&mut self, what: &str, amount: Signal) -> Signal {
        if amount.ty.signed {
            self.fail(what, "the amount is signed".to_owned());
            return amount;
        }
        if amount.width() <= 32 {
            return amount;
        }
        let above = self.slice(amount, 32, amount.width() - 32);
        let far = self.any(above);
        let near = self.slice(amount, 0, 32);
        let all = self.lit(u32::MAX, Ty::u(32));
        self.mux(far, all, near)
    }

    /// Shift left by a constant below the width; the width stays.
    pub fn shl_const(&mut self, a: Signal, by: u32) -> Signal {
        if by == 0 {
            return a;
        }
        if by >= a.width() {
            return self.zero(a.ty);
        }
        let low = self.slice(a, 0, a.width() - by);
        let zeros = self.zero(Ty::u(by));
        let both = self.cat(&[low, zeros]);
        self.cast(both, a.ty.signed)
    }

    /// Shift right by a constant, arithmetic when signed; the width stays.
    pub fn shr_const(&mut self, a: Signal, by: u32) -> Signal {
        if by == 0 {
            return a;
        }
        let by = if a.signed() {
            by.min(a.width() - 1)
        } else {
            by
        };
        if by >= a.width() {
            return self.zero(a.ty);
        }
        let high = self.slice(a, by, a.width() - by);
        let high = self.cast(high, a.ty.signed);
        self.extend(high, a.width())
    }

    /// Bits `low .. low + width`, unsigned.
    pub fn slice(&mut self, a: Signal, low: u32, width: u32) -> Signal {
        if width == 0 || low.checked_add(width).is_none_or(|end| end > a.width()) {
            let of = self.describe(a);
            self.fail("slice", format!("bits {low}+{width} of {of}"));
            return self.zero(Ty::u(width.max(1)));
        }
        if low == 0 && width == a.width() {
            return self.as_unsigned(a);
        }
        self.node(Op::Slice(a.id, low), Ty::u(width))
    }

    /// One bit.
    pub fn bit(&mut self, a: Signal, index: u32) -> Signal {
        self.slice(a, index, 1)
    }

    /// Concatenation, high part first; unsigned.
    pub fn cat(&mut self, parts: &[Signal]) -> Signal {
        match parts {
            [] => {
                self.fail("cat", "no parts".to_owned());
                self.zero(Ty::bit())
            }
            [one] => self.as_unsigned(*one),
            _ => {
                let widths = parts.iter().map(|p| p.width());
                let width = widths.fold(0, u32::saturating_add);
                self.node(Op::Cat(parts.iter().map(|p| p.id).collect()), Ty::u(width))
            }
        }
    }

    /// `count` copies side by side.
    pub fn repeat(&mut self, a: Signal, count: u32) -> Signal {
        if count == 1 {
            return self.as_unsigned(a);
        }
        if count == 0 {
            let of = self.describe(a);
            self.fail("repeat", format!("0 copies of {of}: expected 1 at least"));
            return self.as_unsigned(a);
        }
        let width = a.width().saturating_mul(count);
        self.node(Op::Repeat(a.id, count), Ty::u(width))
    }

    /// Widens, by zeros or by the sign.
    pub fn extend(&mut self, a: Signal, width: u32) -> Signal {
        if width == a.width() {
            return a;
        }
        if width < a.width() {
            let of = self.describe(a);
            self.fail(
                "extend",
                format!("{of} to {width} bits is narrower: truncate, round or saturate"),
            );
            return self.zero(Ty { width, ..a.ty });
        }
        self.node(Op::Extend(a.id), Ty { width, ..a.ty })
    }

    /// Cuts off high bits; the signedness stays.
    pub fn truncate(&mut self, a: Signal, width: u32) -> Signal {
        if width == a.width() {
            return a;
        }
        let cut = self.slice(a, 0, width);
        self.cast(cut, a.ty.signed)
    }

    fn cast(&mut self, a: Signal, signed: bool) -> Signal {
        if a.ty.signed == signed {
            return a;
        }
        self.node(Op::Cast(a.id), Ty { signed, ..a.ty })
    }

    /// The same bits as two's complement.
    pub fn as_signed(&mut self, a: Signal) -> Signal {
        self.cast(a, true)
    }

    /// The same bits as unsigned.
    pub fn as_unsigned(&mut self, a: Signal) -> Signal {
        self.cast(a, false)
    }

    /// Drops `bits` low bits, rounded. One bit wider than what is left, so
    /// that it cannot overflow.
    pub fn round(&mut self, a: Signal, bits: u32, rounding: Rounding) -> Signal {
        if bits == 0 {
            return self.extend(a, a.width() + 1);
        }
        if bits >= a.width() {
            let of = self.describe(a);
            self.fail("round", format!("{bits} bits off {of}"));
            return self.zero(Ty { width: 1, ..a.ty });
        }
        let ty = Ty {
            width: a.width() - bits + 1,
            ..a.ty
        };
        self.node(Op::Round(a.id, bits, rounding), ty)
    }

    /// The nearest value of another type.
    pub fn saturate(&mut self, a: Signal, ty: Ty) -> Signal {
        let ty = self.legal(ty);
        if ty == a.ty {
            return a;
        }
        if ty.min() <= a.ty.min() && ty.max() >= a.ty.max() {
            let wide = self.extend(a, ty.width);
            return self.cast(wide, ty.signed);
        }
        self.node(Op::Saturate(a.id), ty)
    }

    /// Whether saturating to `ty` changes the value.
    pub fn saturated(&mut self, a: Signal, ty: Ty) -> Signal {
        let ty = self.legal(ty);
        let mut outside = vec![];
        if ty.max() < a.ty.max() {
            let max = self.lit(ty.max(), a.ty);
            outside.push(self.gt(a, max));
        }
        if ty.min() > a.ty.min() {
            let min = self.lit(ty.min(), a.ty);
            outside.push(self.lt(a, min));
        }
        self.any_of(&outside)
    }

    /// `condition ? then : other`.
    pub fn mux(&mut self, condition: Signal, then: Signal, other: Signal) -> Signal {
        if condition.ty != Ty::bit() {
            let of = self.describe(condition);
            self.fail("mux", format!("condition {of} is not one unsigned bit"));
            return then;
        }
        if !self.agree("mux", then, other) {
            return then;
        }
        if then == other {
            return then;
        }
        self.node(Op::Mux(condition.id, then.id, other.id), then.ty)
    }

    /// `options[index]`; past the list the last one.
    pub fn select(&mut self, index: Signal, options: &[Signal]) -> Signal {
        let Some(first) = options.first().copied() else {
            self.fail("select", "no options".to_owned());
            return self.zero(Ty::bit());
        };
        if index.ty.signed {
            self.fail("select", "the index is signed".to_owned());
        }
        for o in options {
            if !self.agree("select", first, *o) {
                return first;
            }
        }
        let reachable = 1usize.checked_shl(index.width()).unwrap_or(usize::MAX);
        let options = &options[..options.len().min(reachable)];
        if options.iter().all(|o| *o == first) {
            return first;
        }
        self.node(
            Op::Select(index.id, options.iter().map(|o| o.id).collect()),
            first.ty,
        )
    }

    fn fold(
        &mut self,
        bits: &[Signal],
        empty: u8,
        op: fn(&mut Self, Signal, Signal) -> Signal,
    ) -> Signal {
        let mut all = bits.iter().copied();
        match all.next() {
            None => self.lit(empty, Ty::bit()),
            Some(first) => all.fold(first, |sum, bit| op(self, sum, bit)),
        }
    }

    /// Whether any of these bits is set.
    pub fn any_of(&mut self, bits: &[Signal]) -> Signal {
        self.fold(bits, 0, Self::or)
    }

    /// Whether all of these bits are set.
    pub fn all_of(&mut self, bits: &[Signal]) -> Signal {
        self.fold(bits, 1, Self::and)
    }

    /// A register with a reset value.
    pub fn reg(&mut self, name: &str, ty: Ty, reset: impl Into<BigInt>) -> Signal {
        let (mut reset, ty) = (reset.into(), self.legal(ty));
        if reset < ty.min() || reset > ty.max() {
            self.fail(name, format!("reset value {reset} does not fit {ty}"));
            reset = BigInt::ZERO;
        }
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

    /// What the register takes over at every clock edge.
    pub fn set_next(&mut self, reg: Signal, value: Signal) {
        self.drive(reg, None, value);
    }

    /// What the register takes over at clock edges at which `enable` is set.
    pub fn set_next_if(&mut self, reg: Signal, enable: Signal, value: Signal) {
        if enable.ty == Ty::bit() {
            self.drive(reg, Some(enable.id), value);
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

    /// A plain inferable array.
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

    /// Writes at the clock edge when `en` is set. Addresses past the depth
    /// write nothing.
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

    /// Reads at the clock edge when `en` is set, what was there before it;
    /// holds its output otherwise. No reset.
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

    /// Reads in the same cycle.
    pub fn mem_read_async(&mut self, mem: MemId, addr: Signal) -> Signal {
        let width = self.module.memories[mem.0].width;
        if !self.address(mem, addr) {
            return self.zero(Ty::u(width));
        }
        self.node(Op::ReadAsync(mem.0, addr.id), Ty::u(width))
    }

    /// An instance of a module, its inputs connected by port name. Inputs that
    /// depend on its own outputs are connected later, with
    /// [`ModuleBuilder::connect`].
    pub fn instance(
        &mut self,
        name: &str,
        module: &Arc<Module>,
        inputs: &[(&str, Signal)],
    ) -> Instance {
        self.module.instances.push(Inst {
            name: name.to_owned(),
            module: module.clone(),
            inputs: vec![],
            at: self.module.nodes.len(),
        });
        let instance = Instance(self.module.instances.len() - 1);
        for (port, s) in inputs {
            self.connect(instance, port, *s);
        }
        instance
    }

    /// Connects an input of an instance.
    pub fn connect(&mut self, instance: Instance, port: &str, s: Signal) {
        let inst = &self.module.instances[instance.0];
        let (name, module) = (inst.name.clone(), inst.module.clone());
        match module
            .ports
            .iter()
            .position(|p| p.name == port && !p.output)
        {
            None => self.fail(
                &name,
                format!("module {} has no input `{port}`", module.name),
            ),
            Some(i) if module.nodes[module.ports[i].node].ty != s.ty => {
                let (want, got) = (module.nodes[module.ports[i].node].ty, self.describe(s));
                self.fail(
                    &name,
                    format!("port `{port}` is {want}, connected to {got}"),
                );
            }
            Some(i)
                if self.module.instances[instance.0]
                    .inputs
                    .iter()
                    .any(|(p, _)| *p == i) =>
            {
                self.fail(&name, format!("port `{port}` is connected twice"));
            }
            Some(i) => self.module.instances[instance.0].inputs.push((i, s.id)),
        }
    }

    /// An output of an instance.
    pub fn out(&mut self, instance: Instance, port: &str) -> Signal {
        let inst = &self.module.instances[instance.0];
        let (name, module) = (inst.name.clone(), inst.module.clone());
        let Some(i) = module.ports.iter().position(|p| p.name == port && p.output) else {
            self.fail(
                &name,
                format!("module {} has no output `{port}`", module.name),
            );
            return self.zero(Ty::bit());
        };
        let known = self
            .module
            .nodes
            .iter()
            .position(|n| matches!(n.op, Op::InstanceOut(a, b) if a == instance.0 && b == i));
        let ty = module.nodes[module.ports[i].node].ty;
        if let Some(id) = known {
            return Signal { id, ty };
        }
        let s = self.node(Op::InstanceOut(instance.0, i), ty);
        self.module.nodes[s.id].name = Some(format!("{name}_{port}"));
        s
    }

    /// Declares bounds of an input.
    pub fn assume_range(
        &mut self,
        s: Signal,
        low: impl Into<BigInt>,
        high: impl Into<BigInt>,
        why: &str,
    ) {
        self.module.contracts.push(Contract::Range {
            node: s.id,
            low: low.into(),
            high: high.into(),
            why: why.to_owned(),
        });
    }

    /// Declares that a register holds at most `most` terms at a time.
    pub fn accumulator(&mut self, reg: Signal, term: Signal, most: u32, why: &str) {
        self.module.contracts.push(Contract::Terms {
            reg: reg.id,
            term: term.id,
            most,
            why: why.to_owned(),
        });
    }

    /// Declares that a register holds features weighted by non-negative codes
    /// that sum to at most `total`.
    pub fn weighted_accumulator(
        &mut self,
        reg: Signal,
        feature: Signal,
        total: impl Into<BigInt>,
        why: &str,
    ) {
        self.module.contracts.push(Contract::Weighted {
            reg: reg.id,
            feature: feature.id,
            total: total.into(),
            why: why.to_owned(),
        });
    }

    /// Checks the module and shares it.
    ///
    /// # Errors
    /// Everything that was recorded, or that the checks find.
    pub fn finish(mut self) -> Result<Arc<Module>, IrErrors> {
        let mut errors = self.errors;
        (self.module.clocked, self.module.registers) = check::state(&self.module);
        if errors.is_empty() {
            errors = check::check(&self.module);
        }
        if errors.is_empty() {
            Ok(Arc::new(self.module))
        } else {
            Err(IrErrors(errors))
        }
    }
}
