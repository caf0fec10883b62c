//! The kinds of nodes, each with operands that chance picks.

use potamoi_netlist::{Signal, Ty};

use super::every_kind::ROUNDINGS;
use super::grow::Grower;

/// No value of a random module gets wider.
const WIDEST: u32 = 2048;

/// What a step adds.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind {
    And,
    Or,
    Xor,
    Not,
    Any,
    All,
    Parity,
    Add,
    Sub,
    Mul,
    Neg,
    Eq,
    Ne,
    Lt,
    Le,
    Gt,
    Ge,
    Shl,
    Shr,
    ShlConst,
    ShrConst,
    Slice,
    Bit,
    Cat,
    Repeat,
    Extend,
    Truncate,
    Cast,
    Round,
    Saturate,
    Saturated,
    Mux,
    Select,
    AnyOf,
    AllOf,
    Lit,
    Param,
    Name,
    ReadSync,
    ReadAsync,
    Instance,
    Array,
    Pick,
    Values,
    Transpose,
    Every,
    Spread,
}

pub(crate) const KINDS: [Kind; 47] = {
    use Kind::*;
    [
        And, Or, Xor, Not, Any, All, Parity, Add, Sub, Mul, Neg, Eq, Ne, Lt, Le, Gt, Ge, Shl, Shr,
        ShlConst, ShrConst, Slice, Bit, Cat, Repeat, Extend, Truncate, Cast, Round, Saturate,
        Saturated, Mux, Select, AnyOf, AllOf, Lit, Param, Name, ReadSync, ReadAsync, Instance,
        Array, Pick, Values, Transpose, Every, Spread,
    ]
};

impl Grower {
    /// Adds a node of this kind; none where it would be too wide, or where
    /// there is nothing to read or to instantiate.
    pub(crate) fn step(&mut self, kind: Kind) -> Option<Signal> {
        let s = match kind {
            Kind::And => {
                let (a, b) = self.pair();
                self.m.and(a, b)
            }
            Kind::Or => {
                let (a, b) = self.pair();
                self.m.or(a, b)
            }
            Kind::Xor => {
                let (a, b) = self.pair();
                self.m.xor(a, b)
            }
            Kind::Add => {
                let (a, b) = self.pair();
                self.m.add(a, b)
            }
            Kind::Sub => {
                let (a, b) = self.pair();
                self.m.sub(a, b)
            }
            Kind::Eq => {
                let (a, b) = self.pair();
                self.m.eq(a, b)
            }
            Kind::Ne => {
                let (a, b) = self.pair();
                self.m.ne(a, b)
            }
            Kind::Lt => {
                let (a, b) = self.pair();
                self.m.lt(a, b)
            }
            Kind::Le => {
                let (a, b) = self.pair();
                self.m.le(a, b)
            }
            Kind::Gt => {
                let (a, b) = self.pair();
                self.m.gt(a, b)
            }
            Kind::Ge => {
                let (a, b) = self.pair();
                self.m.ge(a, b)
            }
            Kind::Mul => {
                let a = self.any();
                let width = self.width();
                let b = self.any_as(Ty { width, ..a.ty() });
                if a.width() + width > WIDEST {
                    return None;
                }
                self.m.mul(a, b)
            }
            Kind::Not => {
                let a = self.any();
                self.m.not(a)
            }
            Kind::Neg => {
                let a = self.any();
                self.m.neg(a)
            }
            Kind::Any => {
                let a = self.any();
                self.m.any(a)
            }
            Kind::All => {
                let a = self.any();
                self.m.all(a)
            }
            Kind::Parity => {
                let a = self.any();
                self.m.parity(a)
            }
            Kind::Shl | Kind::Shr => {
                let (a, amount) = (self.any(), self.any());
                let far = if self.r.chance(30) {
                    amount.width()
                } else {
                    32 - a.width().leading_zeros()
                };
                let amount = self.fit(amount, Ty::u(far));
                if matches!(kind, Kind::Shl) {
                    self.m.shl(a, amount)
                } else {
                    self.m.shr(a, amount)
                }
            }
            Kind::ShlConst => {
                let a = self.any();
                let by = self.up_to(a.width());
                self.m.shl_const(a, by)
            }
            Kind::ShrConst => {
                let a = self.any();
                let by = self.up_to(a.width());
                self.m.shr_const(a, by)
            }
            Kind::Slice => {
                let a = self.any();
                let low = self.up_to(a.width() - 1);
                let width = 1 + self.up_to(a.width() - low - 1);
                self.m.slice(a, low, width)
            }
            Kind::Bit => {
                let a = self.any();
                let at = self.up_to(a.width() - 1);
                self.m.bit(a, at)
            }
            Kind::Cat => {
                let parts: Vec<_> = (0..2 + self.r.below(3)).map(|_| self.any()).collect();
                if parts.iter().map(|p| p.width()).sum::<u32>() > WIDEST {
                    return None;
                }
                self.m.cat(&parts)
            }
            Kind::Repeat => {
                let a = self.any();
                let count = 1 + self.up_to(4);
                if a.width() * count > WIDEST {
                    return None;
                }
                self.m.repeat(a, count)
            }
            Kind::Extend => {
                let a = self.any();
                let more = self.up_to(70);
                self.m.extend(a, (a.width() + more).min(WIDEST))
            }
            Kind::Truncate => {
                let a = self.any();
                let width = 1 + self.up_to(a.width() - 1);
                self.m.truncate(a, width)
            }
            Kind::Cast => {
                let a = self.any();
                if a.signed() {
                    self.m.as_unsigned(a)
                } else {
                    self.m.as_signed(a)
                }
            }
            Kind::Round => {
                let a = self.any();
                let drop = self.up_to(a.width() - 1);
                let rounding = self.r.pick(&ROUNDINGS);
                self.m.round(a, drop, rounding)
            }
            Kind::Saturate => {
                let a = self.any();
                let ty = self.ty();
                self.m.saturate(a, ty)
            }
            Kind::Saturated => {
                let a = self.any();
                let ty = self.ty();
                self.m.saturated(a, ty)
            }
            Kind::Mux => {
                let c = self.any_as(Ty::bit());
                let (a, b) = self.pair();
                self.m.mux(c, a, b)
            }
            Kind::Select => {
                let first = self.any();
                let mut options = vec![first];
                for _ in 0..self.r.below(6) {
                    options.push(self.any_as(first.ty()));
                }
                let bits = 1 + self.up_to(4);
                let index = self.any_as(Ty::u(bits));
                self.m.select(index, &options)
            }
            Kind::AnyOf | Kind::AllOf => {
                let bits: Vec<_> = (0..1 + self.r.below(4))
                    .map(|_| self.any_as(Ty::bit()))
                    .collect();
                if matches!(kind, Kind::AnyOf) {
                    self.m.any_of(&bits)
                } else {
                    self.m.all_of(&bits)
                }
            }
            Kind::Lit => {
                let (value, ty) = self.constant();
                self.m.lit(value, ty)
            }
            Kind::Param => {
                let name = self.fresh("PARAM");
                let (value, ty) = self.constant();
                self.m.param(&name, value, ty, "a constant")
            }
            Kind::Name => {
                let (a, name) = (self.any(), self.fresh("wire"));
                self.m.name(a, &name)
            }
            Kind::ReadSync | Kind::ReadAsync => return self.read(matches!(kind, Kind::ReadSync)),
            Kind::Instance => return self.instance(),
            Kind::Array => return self.array(),
            Kind::Pick => {
                // Values at equal distances, one for each code.
                let bits = 1 + self.up_to(3);
                let (width, base) = (1 + self.up_to(40), self.up_to(9));
                let stride = width + self.up_to(2) * self.up_to(7);
                let codes = 1 << bits;
                let vector = self.any_as(Ty::u(stride * (codes - 1) + base + width));
                let index = self.any_as(Ty::u(bits));
                let all: Vec<_> = (0..codes)
                    .map(|i| self.m.slice(vector, base + stride * i, width))
                    .collect();
                let picked = self.m.select(index, &all);
                self.m.indexed(picked)
            }
            Kind::Transpose => {
                let [rows, columns] = [1 + self.up_to(6), 1 + self.up_to(6)];
                let matrix = self.any_as(Ty::u(rows * columns));
                let name = self.fresh("turned");
                let [row, column] = ["r", "c"].map(|stem| self.fresh(stem));
                self.m
                    .transpose(&name, matrix, (&row, rows), (&column, columns))
            }
            Kind::Every => {
                let [distance, count] = [1 + self.up_to(9), 1 + self.up_to(9)];
                let width = distance * (count - 1) + 1 + self.up_to(distance - 1);
                let vector = self.any_as(Ty::u(width));
                let (name, variable) = (self.fresh("every"), self.fresh("e"));
                self.m.every(&name, vector, distance, (&variable, count))
            }
            Kind::Spread => {
                let [bits, times] = [1 + self.up_to(9), 1 + self.up_to(9)];
                let vector = self.any_as(Ty::u(bits));
                let (name, variable) = (self.fresh("spread"), self.fresh("s"));
                self.m.spread(&name, vector, times, &variable)
            }
            Kind::Values => {
                let (width, count) = (1 + self.up_to(70), 1 + self.up_to(5));
                let (code, _) = self.constant();
                let ty = Ty::u(width * count);
                let code = code & ty.max();
                let name = self.fresh("VALUES");
                let constant = self.m.param(&name, code, ty, "");
                self.m.as_values(constant, width)
            }
        };
        Some(s)
    }
}
