//! One operation on the flat store of values.

use std::cmp::Ordering;

use potamoi_formats::fixed::Rounding;

use super::memory::Rows;
use super::words;
use crate::node::{Binary, Ty, Unary};

/// Location and type of a value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot {
    pub(super) at: usize,
    pub(super) ty: Ty,
}

impl Slot {
    pub(super) fn words(self) -> usize {
        words::count(self.ty.width)
    }

    pub(super) fn of(self, values: &[u64]) -> &[u64] {
        &values[self.at..self.at + self.words()]
    }

    fn is_narrow(self) -> bool {
        self.ty.width <= 64
    }
}

/// An operation.
#[derive(Debug, Clone)]
pub(super) enum Code {
    Unary(Unary, Slot),
    Binary(Binary, Slot, Slot),
    Shl(Slot, Slot),
    Shr(Slot, Slot),
    /// Bits from an index on, extended with the sign or zeros.
    Extract(Slot, u32),
    /// High part first.
    Cat(Vec<Slot>),
    Repeat(Slot, u32),
    Round(Slot, u32, Rounding),
    Saturate(Slot),
    Mux(Slot, Slot, Slot),
    Select(Slot, Vec<Slot>),
    Read(usize, Slot),
}

/// An operation with its result slot, which is after all its operands.
#[derive(Debug, Clone)]
pub(super) struct Step {
    code: Code,
    out: Slot,
    narrow: bool,
}

impl Step {
    pub(super) fn new(code: Code, out: Slot) -> Self {
        let narrow = out.is_narrow()
            && match &code {
                Code::Unary(_, a)
                | Code::Extract(a, _)
                | Code::Round(a, ..)
                | Code::Repeat(a, _)
                | Code::Saturate(a) => a.is_narrow(),
                Code::Binary(_, a, b) | Code::Shl(a, b) | Code::Shr(a, b) => {
                    a.is_narrow() && b.is_narrow()
                }
                Code::Mux(..) | Code::Cat(_) => true,
                Code::Select(index, _) => index.is_narrow(),
                Code::Read(..) => false,
            };
        Self { code, out, narrow }
    }

    pub(super) fn run(&self, values: &mut [u64], memories: &[Rows]) {
        let (before, rest) = values.split_at_mut(self.out.at);
        if self.narrow {
            rest[0] = self.word(before) & words::mask(self.out.ty.width);
        } else {
            self.wide(before, &mut rest[..self.out.words()], memories);
        }
    }

    /// The untruncated result, where everything fits in a word.
    fn word(&self, v: &[u64]) -> u64 {
        let raw = |s: &Slot| v[s.at];
        let value = |s: &Slot| {
            if s.ty.signed {
                sign_extended(v[s.at], s.ty.width)
            } else {
                v[s.at]
            }
        };
        match &self.code {
            Code::Unary(op, a) => match op {
                Unary::Not => !raw(a),
                Unary::Neg => raw(a).wrapping_neg(),
                Unary::Any => u64::from(raw(a) != 0),
                Unary::All => u64::from(raw(a) == words::mask(a.ty.width)),
                Unary::Parity => u64::from(raw(a).count_ones() & 1),
            },
            Code::Binary(op, a, b) => {
                let (x, y) = (raw(a), raw(b));
                match op {
                    Binary::And => x & y,
                    Binary::Or => x | y,
                    Binary::Xor => x ^ y,
                    Binary::Add => x.wrapping_add(y),
                    Binary::Sub => x.wrapping_sub(y),
                    Binary::Mul => value(a).wrapping_mul(value(b)),
                    Binary::Eq => u64::from(x == y),
                    Binary::Ne => u64::from(x != y),
                    Binary::Lt if a.ty.signed => u64::from((value(a) as i64) < value(b) as i64),
                    Binary::Le if a.ty.signed => u64::from(value(a) as i64 <= value(b) as i64),
                    Binary::Lt => u64::from(x < y),
                    Binary::Le => u64::from(x <= y),
                }
            }
            Code::Shl(a, n) => {
                if raw(n) < 64 {
                    raw(a) << raw(n)
                } else {
                    0
                }
            }
            Code::Shr(a, n) => shifted(value(a), a.ty.signed, raw(n)),
            Code::Extract(a, low) => shifted(value(a), a.ty.signed, u64::from(*low)),
            Code::Cat(parts) => parts.iter().fold(0, |all, p| {
                if p.ty.width < 64 {
                    all << p.ty.width | raw(p)
                } else {
                    raw(p)
                }
            }),
            Code::Repeat(a, n) => (0..*n).fold(0, |all, _| {
                if a.ty.width < 64 {
                    all << a.ty.width | raw(a)
                } else {
                    raw(a)
                }
            }),
            Code::Round(a, bits, rounding) => {
                let floor = shifted(value(a), a.ty.signed, u64::from(*bits));
                let guard = raw(a) >> (bits - 1) & 1 == 1;
                let sticky = raw(a) & words::mask(bits - 1) != 0;
                floor.wrapping_add(u64::from(rounds_up(
                    *rounding,
                    guard,
                    sticky,
                    floor & 1 == 1,
                )))
            }
            Code::Saturate(a) => {
                let to = self.out.ty;
                let max = words::mask(to.width - u32::from(to.signed));
                if a.ty.signed && (value(a) as i64) < 0 {
                    let min = if to.signed { !max } else { 0 };
                    if (value(a) as i64) < min as i64 {
                        min
                    } else {
                        value(a)
                    }
                } else {
                    raw(a).min(max)
                }
            }
            Code::Mux(c, t, e) => {
                if raw(c) == 1 {
                    raw(t)
                } else {
                    raw(e)
                }
            }
            Code::Select(index, options) => {
                raw(&options[raw(index).min(options.len() as u64 - 1) as usize])
            }
            Code::Read(..) => 0,
        }
    }

    fn wide(&self, v: &[u64], out: &mut [u64], memories: &[Rows]) {
        let width = self.out.ty.width;
        match &self.code {
            Code::Unary(op, a) => unary(*op, a.of(v), a.ty.width, out),
            Code::Binary(op, a, b) => binary(*op, (a, a.of(v)), (b, b.of(v)), out),
            Code::Shl(a, n) => {
                out.fill(0);
                words::deposit(out, a.of(v), words::amount(n.of(v), width));
            }
            Code::Shr(a, n) => {
                let by = words::amount(n.of(v), width);
                words::extract(out, width, a.of(v), a.ty.width, a.ty.signed, by);
            }
            Code::Extract(a, low) => {
                words::extract(out, width, a.of(v), a.ty.width, a.ty.signed, *low)
            }
            Code::Cat(parts) => {
                out.fill(0);
                let mut at = 0;
                for p in parts.iter().rev() {
                    words::deposit(out, p.of(v), at);
                    at += p.ty.width;
                }
            }
            Code::Repeat(a, n) => {
                out.fill(0);
                for i in 0..*n {
                    words::deposit(out, a.of(v), i * a.ty.width);
                }
            }
            Code::Round(a, bits, rounding) => {
                let from = a.of(v);
                words::extract(out, width, from, a.ty.width, a.ty.signed, *bits);
                let below = bits - 1;
                let sticky = (0..below.div_ceil(64))
                    .any(|i| from[i as usize] & words::mask((below - i * 64).min(64)) != 0);
                if rounds_up(*rounding, words::bit(from, below), sticky, out[0] & 1 == 1) {
                    words::increment(out);
                }
            }
            Code::Saturate(a) => saturate(a.of(v), a.ty, self.out.ty, out),
            Code::Mux(c, t, e) => out.copy_from_slice(if v[c.at] == 1 { t.of(v) } else { e.of(v) }),
            Code::Select(index, options) => {
                let last = options.len() as u32 - 1;
                out.copy_from_slice(options[words::amount(index.of(v), last) as usize].of(v));
            }
            Code::Read(mem, addr) => memories[*mem].read(words::amount(addr.of(v), u32::MAX), out),
        }
        words::trim(out, width);
    }
}

fn sign_extended(word: u64, width: u32) -> u64 {
    let unused = 64 - width.min(64);
    ((word << unused) as i64 >> unused) as u64
}

fn shifted(value: u64, signed: bool, by: u64) -> u64 {
    match (signed, by) {
        (true, _) => (value as i64 >> by.min(63)) as u64,
        (false, 0..=63) => value >> by,
        (false, _) => 0,
    }
}

fn rounds_up(rounding: Rounding, guard: bool, sticky: bool, odd: bool) -> bool {
    match rounding {
        Rounding::Floor => false,
        Rounding::HalfUp => guard,
        Rounding::HalfEven => guard && (sticky || odd),
    }
}

fn unary(op: Unary, a: &[u64], width: u32, out: &mut [u64]) {
    match op {
        Unary::Not => out.iter_mut().zip(a).for_each(|(o, x)| *o = !x),
        Unary::Neg => {
            out.iter_mut().zip(a).for_each(|(o, x)| *o = !x);
            words::increment(out);
        }
        Unary::Any => out[0] = u64::from(a.iter().any(|x| *x != 0)),
        Unary::All => out[0] = u64::from(words::all_from(a, width, 0)),
        Unary::Parity => out[0] = u64::from(a.iter().map(|x| x.count_ones()).sum::<u32>() & 1),
    }
}

fn binary(op: Binary, (sa, a): (&Slot, &[u64]), (sb, b): (&Slot, &[u64]), out: &mut [u64]) {
    let order = || words::compare(a, b, sa.ty.width, sa.ty.signed);
    let mut bitwise = |f: fn(u64, u64) -> u64| {
        out.iter_mut()
            .zip(a.iter().zip(b))
            .for_each(|(o, (x, y))| *o = f(*x, *y))
    };
    match op {
        Binary::And => bitwise(|x, y| x & y),
        Binary::Or => bitwise(|x, y| x | y),
        Binary::Xor => bitwise(|x, y| x ^ y),
        Binary::Add => words::add(out, a, b),
        Binary::Sub => words::sub(out, a, b),
        Binary::Mul => words::mul(out, (a, sa.ty.width), (b, sb.ty.width), sa.ty.signed),
        Binary::Eq => out[0] = u64::from(a == b),
        Binary::Ne => out[0] = u64::from(a != b),
        Binary::Lt => out[0] = u64::from(order() == Ordering::Less),
        Binary::Le => out[0] = u64::from(order() != Ordering::Greater),
    }
}

fn saturate(a: &[u64], from: Ty, to: Ty, out: &mut [u64]) {
    // Bits of the target below its sign.
    let kept = to.width - u32::from(to.signed);
    if !words::negative(a, from.width, from.signed) {
        if words::any_from(a, from.width, kept) {
            out.fill(u64::MAX);
            if to.signed {
                words::clear(out, kept);
            }
        } else {
            words::extract(out, to.width, a, from.width, false, 0);
        }
    } else if !to.signed {
        out.fill(0);
    } else if words::all_from(a, from.width, kept) {
        words::extract(out, to.width, a, from.width, true, 0);
    } else {
        out.fill(0);
        words::set(out, kept);
    }
}
