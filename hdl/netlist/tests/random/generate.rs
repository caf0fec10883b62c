//! Random modules, and what they are made of.

use std::collections::BTreeSet;
use std::sync::Arc;

use potamoi_formats::fixed::Rounding;
use potamoi_netlist::{Module, ModuleBuilder, Signal, Ty};

use crate::choices::Random;

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

/// A module that is being made.
pub(crate) struct Making<'a> {
    pub(crate) b: ModuleBuilder,
    pub(crate) random: &'a mut Random,
    pub(crate) made: &'a mut Made,
    /// Inputs that are used so far.
    pub(crate) inputs: Vec<(String, Signal)>,
    /// Every value, in order.
    pub(crate) values: Vec<Signal>,
    /// Values that something reads.
    pub(crate) used: Vec<Signal>,
    pub(crate) registers: Vec<(Signal, bool)>,
    pub(crate) names: usize,
}

impl Making<'_> {
    fn note(&mut self, kind: &'static str, of: Signal) {
        self.made.insert((kind, of.width(), of.signed()));
    }

    pub(crate) fn fresh(&mut self, stem: &str) -> String {
        self.names += 1;
        format!("{stem}_{}", self.names)
    }

    pub(crate) fn input(&mut self, name: &str, ty: Ty) -> Signal {
        if let Some((_, s)) = self.inputs.iter().find(|(n, _)| n == name) {
            return *s;
        }
        let s = self.b.input(name, ty, "");
        self.inputs.push((name.to_owned(), s));
        s
    }

    /// A value of a type: one that is there, or a new input or constant.
    pub(crate) fn value(&mut self, ty: Ty) -> Signal {
        let there: Vec<_> = self
            .values
            .iter()
            .copied()
            .filter(|s| s.ty() == ty)
            .collect();
        if !there.is_empty() && self.random.below(4) > 0 {
            let s = self.random.pick(&there);
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

    pub(crate) fn bit(&mut self) -> Signal {
        self.value(Ty::bit())
    }

    /// A value shifted by an amount of each class of width, all in one.
    fn shifted(&mut self, a: Signal, left: bool) -> Signal {
        let each = AMOUNTS.map(|widths| {
            let bits = self.random.pick(widths);
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
                let (width, signed) = (self.random.pick(&WIDTHS[..11]), self.random.flip());
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
        let width = self.random.pick(&WIDTHS[..11]);
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
