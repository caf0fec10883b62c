//! Random modules, and what they are made of.

use std::collections::BTreeSet;
use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::fixed::Rounding;
use potamoi_hdl::ir::{Module, ModuleBuilder, Signal, Ty};

/// Widths around every limit of the simulators' words.
pub(crate) const WIDTHS: [u32; 15] = [
    1, 2, 31, 32, 33, 63, 64, 65, 127, 128, 129, 511, 512, 513, 1024,
];

/// Widths of the amounts of a shift: up to a word of 32 bits, up to one of 64, and beyond.
pub(crate) const AMOUNTS: [&[u32]; 3] = [&[1, 3, 9, 11, 32], &[33, 40, 63, 64], &[65, 70, 130]];

/// Every kind of node.
pub(crate) const KINDS: [&str; 34] = [
    "lit",
    "not",
    "neg",
    "any",
    "all",
    "parity",
    "and",
    "or",
    "xor",
    "add",
    "sub",
    "mul",
    "eq",
    "ne",
    "lt",
    "le",
    "shl",
    "shr",
    "slice",
    "cat",
    "repeat",
    "extend",
    "cast",
    "floor",
    "half_up",
    "half_even",
    "saturate",
    "mux",
    "select",
    "reg",
    "reg_enable",
    "read_sync",
    "read_async",
    "instance",
];

/// What a width is near to.
pub(crate) fn class(width: u32) -> &'static str {
    match width {
        0..=33 => "small",
        34..=65 => "at 64",
        _ => "wide",
    }
}

/// Kinds of nodes that were made, with the operand's type.
pub(crate) type Made = BTreeSet<(&'static str, u32, bool)>;

/// Random numbers of a seed.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub(crate) fn flip(&mut self) -> bool {
        self.next() & 1 == 1
    }

    pub(crate) fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    /// Bits with long runs of ones and zeros, or a single bit, or anything.
    pub(crate) fn words(&mut self, width: u32) -> Vec<u32> {
        let mut words: Vec<u32> = (0..width.div_ceil(32))
            .map(|_| self.next() as u32)
            .collect();
        match self.below(10) {
            0 => words.fill(0),
            1 => words.fill(u32::MAX),
            2 => {
                words.fill(0);
                let bit = self.below(width as usize);
                words[bit / 32] = 1 << (bit % 32);
            }
            3 => {
                words.fill(u32::MAX);
                words[(width as usize - 1) / 32] = !(1 << ((width - 1) % 32));
            }
            4 => words.iter_mut().for_each(|w| *w &= 0x8000_0001),
            5 => {
                words.fill(u32::MAX);
                let bit = self.below(width as usize);
                words[bit / 32] = !(1 << (bit % 32));
            }
            6 => {
                // A narrower number with its sign, or none.
                let from = self.below(width as usize);
                let ones = self.flip();
                for bit in from..width as usize {
                    words[bit / 32] &= !(1 << (bit % 32));
                    words[bit / 32] |= u32::from(ones) << (bit % 32);
                }
            }
            _ => {}
        }
        if !width.is_multiple_of(32)
            && let Some(last) = words.last_mut()
        {
            *last &= (1 << (width % 32)) - 1;
        }
        words
    }

    /// A value of a type.
    fn value(&mut self, ty: Ty) -> BigInt {
        let words = self.words(ty.width);
        let code = BigInt::from(num_bigint::BigUint::new(words));
        if ty.signed && code.bit(u64::from(ty.width - 1)) {
            code - (BigInt::from(1) << ty.width)
        } else {
            code
        }
    }
}

/// The inputs that the wrapper shares among its modules: their names and types.
pub(crate) fn pool() -> Vec<(String, Ty)> {
    let mut all = vec![];
    for width in WIDTHS {
        for signed in [false, true] {
            for copy in 0..2 {
                let ty = Ty { width, signed };
                all.push((format!("in_{ty}_{copy}"), ty));
            }
        }
    }
    for bits in AMOUNTS.into_iter().flatten() {
        all.push((format!("amount_{bits}"), Ty::u(*bits)));
    }
    all.push(("init".to_owned(), Ty::bit()));
    all.push(("init_row".to_owned(), Ty::u(3)));
    all
}

/// A module that is being made.
struct Making<'a> {
    b: ModuleBuilder,
    random: &'a mut Random,
    made: &'a mut Made,
    /// Inputs that are used so far.
    inputs: Vec<(String, Signal)>,
    /// Every value, in order.
    values: Vec<Signal>,
    /// Values that something reads.
    used: Vec<Signal>,
    registers: Vec<(Signal, bool)>,
    names: usize,
}

impl Making<'_> {
    fn note(&mut self, kind: &'static str, of: Signal) {
        self.made.insert((kind, of.width(), of.signed()));
    }

    fn fresh(&mut self, stem: &str) -> String {
        self.names += 1;
        format!("{stem}_{}", self.names)
    }

    fn input(&mut self, name: &str, ty: Ty) -> Signal {
        if let Some((_, s)) = self.inputs.iter().find(|(n, _)| n == name) {
            return *s;
        }
        let s = self.b.input(name, ty, "");
        self.inputs.push((name.to_owned(), s));
        s
    }

    /// A value of a type: one that is there, or a new input or constant.
    fn value(&mut self, ty: Ty) -> Signal {
        let there: Vec<_> = self
            .values
            .iter()
            .copied()
            .filter(|s| s.ty() == ty)
            .collect();
        if !there.is_empty() && self.random.below(4) > 0 {
            let s = self.random.of(&there);
            self.used.push(s);
            return s;
        }
        let s = if self.random.below(5) == 0 {
            let value = self.random.value(ty);
            let s = self.b.lit(value, ty);
            self.note("lit", s);
            s
        } else if WIDTHS.contains(&ty.width) {
            let copy = self.random.below(2);
            self.input(&format!("in_{ty}_{copy}"), ty)
        } else {
            // No input has this width: a part of a wider one, or more of a narrower one.
            let wide = WIDTHS.into_iter().find(|w| *w > ty.width);
            let signed = ty.signed;
            let s = match wide {
                Some(width) => {
                    let whole = self.value(Ty { width, signed });
                    self.b.truncate(whole, ty.width)
                }
                None => {
                    let part = self.value(Ty {
                        width: 1024,
                        signed,
                    });
                    self.b.extend(part, ty.width)
                }
            };
            self.values.push(s);
            return s;
        };
        self.values.push(s);
        s
    }

    fn bit(&mut self) -> Signal {
        self.value(Ty::bit())
    }

    /// A value shifted by an amount of each class of width, all in one.
    fn shifted(&mut self, a: Signal, left: bool) -> Signal {
        let each = AMOUNTS.map(|widths| {
            let bits = self.random.of(widths);
            let n = self.input(&format!("amount_{bits}"), Ty::u(bits));
            if left {
                self.b.shl(a, n)
            } else {
                self.b.shr(a, n)
            }
        });
        let two = self.b.xor(each[0], each[1]);
        self.b.xor(two, each[2])
    }

    /// One node of a kind whose operand has a type.
    fn node(&mut self, kind: &'static str, ty: Ty) {
        let a = self.value(ty);
        self.note(kind, a);
        let s = match kind {
            "lit" => {
                let value = self.random.value(ty);
                self.b.lit(value, ty)
            }
            "not" => self.b.not(a),
            "neg" => self.b.neg(a),
            "any" => self.b.any(a),
            "all" => self.b.all(a),
            "parity" => self.b.parity(a),
            "and" | "or" | "xor" | "add" | "sub" | "mul" | "eq" | "ne" | "lt" | "le" => {
                let b = self.value(ty);
                match kind {
                    "and" => self.b.and(a, b),
                    "or" => self.b.or(a, b),
                    "xor" => self.b.xor(a, b),
                    "add" => self.b.add(a, b),
                    "sub" => self.b.sub(a, b),
                    "mul" => self.product(a),
                    "eq" => self.b.eq(a, b),
                    "ne" => self.b.ne(a, b),
                    "lt" => self.b.lt(a, b),
                    _ => self.b.le(a, b),
                }
            }
            "shl" => self.shifted(a, true),
            "shr" => self.shifted(a, false),
            "slice" => self.part(a),
            "cat" => {
                let (width, signed) = (self.random.of(&WIDTHS[..11]), self.random.flip());
                let (b, c) = (self.value(Ty { width, signed }), self.bit());
                self.b.cat(&[c, a, b])
            }
            "repeat" => {
                // Verilator 5.006 assigns constants of more than 2048 bits wrongly:
                // VL_CONSTHI_W_* clears words past the variable's end.
                let most = (2048 / a.width()).min(5) as usize;
                let count = 2 + self.random.below(most - 1) as u32;
                self.b.repeat(a, count)
            }
            "extend" => {
                let more = 1 + self.random.below(70) as u32;
                self.b.extend(a, ty.width + more)
            }
            "cast" if ty.signed => self.b.as_unsigned(a),
            "cast" => self.b.as_signed(a),
            "floor" => self.rounded(a, Rounding::Floor),
            "half_up" => self.rounded(a, Rounding::HalfUp),
            "half_even" => self.rounded(a, Rounding::HalfEven),
            "saturate" => self.saturated(a),
            "mux" => {
                let (c, b) = (self.bit(), self.value(ty));
                self.b.mux(c, a, b)
            }
            "select" => {
                let count = 2 + self.random.below(6);
                let mut options = vec![a];
                options.extend((1..count).map(|_| self.value(ty)));
                let index = self.input("amount_3", Ty::u(3));
                self.b.select(index, &options)
            }
            "reg" | "reg_enable" => {
                let name = self.fresh("reg");
                let reset = self.random.value(ty);
                let s = self.b.reg(&name, ty, reset);
                self.registers.push((s, kind == "reg_enable"));
                s
            }
            "read_sync" | "read_async" => self.memory(kind == "read_sync", a),
            _ => self.instance(a),
        };
        self.values.push(s);
    }

    /// Factors of any two widths, as long as the product is no wider than the
    /// simulators take.
    fn product(&mut self, a: Signal) -> Signal {
        let signed = a.signed();
        let width = self.random.of(&WIDTHS[..11]);
        let b = self.value(Ty { width, signed });
        if self.random.flip() {
            self.b.mul(a, b)
        } else {
            self.b.mul(b, a)
        }
    }

    fn part(&mut self, a: Signal) -> Signal {
        let low = self.random.below(a.width() as usize) as u32;
        let width = 1 + self.random.below((a.width() - low) as usize) as u32;
        self.b.slice(a, low, width)
    }

    fn rounded(&mut self, a: Signal, how: Rounding) -> Signal {
        let a = if a.width() == 1 {
            self.b.extend(a, 2)
        } else {
            a
        };
        // Few bits mostly, so that there are ties.
        let most = a.width() as usize - 1;
        let most = if self.random.below(4) > 0 {
            most.min(2)
        } else {
            most
        };
        let bits = 1 + self.random.below(most) as u32;
        self.b.round(a, bits, how)
    }

    fn saturated(&mut self, a: Signal) -> Signal {
        // Widths that hold every value of the operand make another node.
        let width = 1 + self.random.below(a.width() as usize) as u32;
        let signed = if width == a.width() {
            !a.signed()
        } else {
            self.random.flip()
        };
        let to = Ty { width, signed };
        // Next to where it begins to saturate, every other time.
        let near = if self.random.flip() {
            to.max() + self.random.below(3)
        } else {
            to.min() - self.random.below(3)
        };
        let a = if near >= a.ty().min() && near <= a.ty().max() {
            let near = self.b.lit(near, a.ty());
            let pick = self.bit();
            self.b.mux(pick, near, a)
        } else {
            a
        };
        let flag = self.b.saturated(a, to);
        self.values.push(flag);
        self.b.saturate(a, to)
    }

    /// A memory whose rows are all written while `init` is set, read within
    /// its depth, of this data.
    fn memory(&mut self, sync: bool, data: Signal) -> Signal {
        let depth = 2 + self.random.below(7) as u32;
        let bits = (depth - 1).ilog2() + 1;
        let name = self.fresh("rows");
        let mem = self.b.memory(&name, depth, data.width(), "");
        let (init, row) = (
            self.input("init", Ty::bit()),
            self.input("init_row", Ty::u(3)),
        );
        let data = self.b.as_unsigned(data);
        let fixed = self.input(
            &format!("in_{}_0", Ty::u(data.width())),
            Ty::u(data.width()),
        );
        let mut data = self.b.mux(init, fixed, data);
        for _ in 0..=self.random.below(2) {
            let addr = self.address(init, row, depth, bits);
            let en = self.bit();
            let en = self.b.or(init, en);
            self.b.mem_write(mem, en, addr, data);
            // Two writes to one row are told apart.
            data = self.b.not(data);
        }
        let addr = self.address(init, row, depth, bits);
        if sync {
            let en = self.bit();
            let en = self.b.or(init, en);
            let name = self.fresh("read");
            self.b.mem_read(mem, en, addr, &name)
        } else {
            self.b.mem_read_async(mem, addr)
        }
    }

    fn address(&mut self, init: Signal, row: Signal, depth: u32, bits: u32) -> Signal {
        let any = self.input("amount_3", Ty::u(3));
        let turn = self.bit();
        let turn = self.b.extend(turn, 3);
        let any = self.b.add(any, turn);
        let addr = self.b.mux(init, row, any);
        let last = self.b.lit(depth - 1, Ty::u(3));
        let past = self.b.gt(addr, last);
        let none = self.b.lit(0, Ty::u(3));
        let addr = self.b.mux(past, none, addr);
        self.b.truncate(addr, bits)
    }

    /// An instance of a small module of its own, with a way through it and a
    /// register.
    fn instance(&mut self, a: Signal) -> Signal {
        let name = self.fresh("below");
        let mut inner = ModuleBuilder::new(&format!("inner_{}_{:x}", a.ty(), self.random.next()));
        let (x, y) = (inner.input("x", a.ty(), ""), inner.input("y", a.ty(), ""));
        let kept = inner.reg("kept", a.ty(), 0);
        let sum = inner.add(x, kept);
        inner.set_next(kept, y);
        inner.output("sum", sum, "");
        inner.output("old", kept, "");
        let inner = inner.finish().unwrap();
        let late = self.random.flip();
        let inst = if late {
            self.b.instance(&name, &inner, &[("x", a)])
        } else {
            let y = self.value(a.ty());
            self.b.instance(&name, &inner, &[("y", y), ("x", a)])
        };
        let (sum, old) = (self.b.out(inst, "sum"), self.b.out(inst, "old"));
        self.values.push(old);
        if late {
            // What follows from an output comes back in.
            let back = self.b.xor(sum, a);
            self.b.connect(inst, "y", back);
        }
        sum
    }

    fn finish(mut self) -> Arc<Module> {
        for (reg, enabled) in std::mem::take(&mut self.registers) {
            let next = self.value(reg.ty());
            if enabled {
                let en = self.bit();
                self.b.set_next_if(reg, en, next);
            } else {
                self.b.set_next(reg, next);
            }
        }
        // Not all that is read, so that expressions are printed into others.
        for (i, s) in self.values.clone().into_iter().enumerate() {
            if !self.used.contains(&s) || self.random.below(4) == 0 {
                self.b.output(&format!("out_{i}"), s, "");
            }
        }
        for (_, s) in std::mem::take(&mut self.inputs) {
            self.b.unused(s, "not every input is used");
        }
        self.b
            .finish()
            .unwrap_or_else(|e| panic!("a random module is refused: {e}"))
    }
}

/// One random module of these nodes.
pub(crate) fn module(
    name: &str,
    nodes: &[(&'static str, Ty)],
    random: &mut Random,
    made: &mut Made,
) -> Arc<Module> {
    let mut making = Making {
        b: ModuleBuilder::new(name),
        random,
        made,
        inputs: vec![],
        values: vec![],
        used: vec![],
        registers: vec![],
        names: 0,
    };
    for (kind, ty) in nodes {
        making.node(kind, *ty);
    }
    making.finish()
}

/// Kinds with the types they are made for: each kind in each width, signed and
/// not by turns, in random order.
pub(crate) fn plan(random: &mut Random) -> Vec<(&'static str, Ty)> {
    let mut all = vec![];
    for kind in KINDS {
        let first = random.flip();
        for (i, width) in WIDTHS.into_iter().enumerate() {
            let signed = first ^ (i % 2 == 1);
            all.push((kind, Ty { width, signed }));
        }
    }
    for i in (1..all.len()).rev() {
        all.swap(i, random.below(i + 1));
    }
    all
}

/// All modules side by side: the inputs are one vector, the outputs one each.
pub(crate) fn wrapper(modules: &[Arc<Module>]) -> Arc<Module> {
    let mut b = ModuleBuilder::new("all_random");
    let pool = pool();
    let inputs: Vec<_> = pool
        .iter()
        .map(|(name, ty)| (name.clone(), b.input(name, *ty, "")))
        .collect();
    for (i, module) in modules.iter().enumerate() {
        let ports = module.ports();
        let given: Vec<_> = ports
            .iter()
            .filter(|p| !p.output)
            .filter_map(|p| inputs.iter().find(|(n, _)| *n == p.name))
            .map(|(n, s)| (n.as_str(), *s))
            .collect();
        let name = format!("m{i}");
        let inst = b.instance(&name, module, &given);
        for port in ports.iter().filter(|p| p.output) {
            let s = b.out(inst, &port.name);
            b.output(&format!("{name}_{}", port.name), s, "");
        }
    }
    for (_, s) in inputs {
        b.unused(s, "shared by random modules");
    }
    b.finish()
        .unwrap_or_else(|e| panic!("the wrapper is refused: {e}"))
}
