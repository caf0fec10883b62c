//! Sums of products as two addends, which a register stage holds between a multiplication and its sum.
//!
//! A product is rows of bits, one for each bit of a factor. Three rows become two with the same sum,
//! without a carry that runs through them, until two are left. Sums that never meet share their rows.

use std::collections::VecDeque;

use num_bigint::BigInt;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

/// Rows of alternatives; the sum of the rows is that of the alternative that is on, modulo 2^width.
pub(super) struct Rows<'a> {
    name: &'a str,
    width: u32,
    alternatives: Vec<Alternative>,
}

/// Rows that are 0 unless they are on.
struct Alternative {
    on: Signal,
    rows: Vec<Signal>,
    /// The sum of the rows' constants.
    constant: BigInt,
}

impl<'a> Rows<'a> {
    /// No rows yet. Signals are named after `name`.
    pub(super) fn new(name: &'a str, width: u32) -> Self {
        Self {
            name,
            width,
            alternatives: vec![],
        }
    }

    /// Rows of one sum, which is always on.
    pub(super) fn always(name: &'a str, width: u32, m: &mut ModuleBuilder) -> Self {
        let mut own = Self::new(name, width);
        let on = m.lit(1, Ty::bit());
        own.or_if(on);
        own
    }

    /// Begins another alternative. At most one is on in a clock.
    pub(super) fn or_if(&mut self, on: Signal) {
        self.alternatives.push(Alternative {
            on,
            rows: vec![],
            constant: BigInt::ZERO,
        });
    }

    /// Adds a constant.
    pub(super) fn constant(&mut self, value: &BigInt) {
        if let Some(own) = self.alternatives.last_mut() {
            own.constant += value;
        }
    }

    /// Adds a value, which is 0 where its alternative is not on.
    pub(super) fn value(&mut self, m: &mut ModuleBuilder, value: Signal) {
        let width = value.width();
        if !value.ty().signed || width >= self.width {
            let bits = m.as_unsigned(value);
            self.row(m, bits, 0);
            return;
        }
        // A sign of weight -2^p is its complement of weight 2^p, and -2^p.
        let (low, sign) = (m.slice(value, 0, width - 1), m.bit(value, width - 1));
        let plus = self.complement(m, sign);
        let bits = m.cat(&[plus, low]);
        self.row(m, bits, 0);
        self.weigh(-1, width - 1);
    }

    /// Adds an unsigned value times 2^at, which is 0 where its alternative is not on.
    pub(super) fn shifted(&mut self, m: &mut ModuleBuilder, value: Signal, at: u32) {
        self.row(m, value, at);
    }

    /// Subtracts the product of two unsigned factors: -v of n bits is its complement, 1 and -2^n.
    pub(super) fn minus_product(&mut self, m: &mut ModuleBuilder, x: Signal, y: Signal) {
        for at in 0..y.width() {
            let bits = masked(m, x, y, at);
            let bits = self.complement(m, bits);
            self.row(m, bits, at);
            self.weigh(1, at);
            self.weigh(-1, at + x.width());
        }
    }

    /// Adds the product of an unsigned factor and a constant.
    pub(super) fn multiple(&mut self, m: &mut ModuleBuilder, x: Signal, factor: &BigInt) {
        for at in (0..factor.bits()).filter(|at| factor.bit(*at)) {
            self.row(m, x, at as u32);
        }
    }

    /// Adds the product of two signed factors of at least two bits (Baugh and Wooley): signs have a
    /// negative weight, as in [`Rows::value`].
    pub(super) fn signed_product(&mut self, m: &mut ModuleBuilder, x: Signal, y: Signal) {
        let y = self.only(m, y);
        let (sign, last) = (x.width() - 1, y.width() - 1);
        let low = m.slice(x, 0, sign);
        let high = m.bit(x, sign);
        for at in 0..last {
            let bits = masked(m, low, y, at);
            let own = masked(m, high, y, at);
            let own = self.complement(m, own);
            let bits = m.cat(&[own, bits]);
            self.row(m, bits, at);
            self.weigh(-1, sign + at);
        }
        let bits = masked(m, low, y, last);
        let bits = self.complement(m, bits);
        let own = masked(m, high, y, last);
        let bits = m.cat(&[own, bits]);
        self.row(m, bits, last);
        self.weigh(1, last);
        self.weigh(-1, sign + last);
    }

    /// Adds the square of a signed value of at least two bits: half the bits of a product, since
    /// each pair of bits meets once, with twice the weight.
    pub(super) fn square(&mut self, m: &mut ModuleBuilder, z: Signal) {
        let z = self.only(m, z);
        let sign = z.width() - 1;
        let (low, high) = (m.slice(z, 0, sign), m.bit(z, sign));
        // (u - s 2^n)^2 = u^2 - s u 2^(n + 1) + s 2^(2 n).
        let crossed = masked(m, low, high, 0);
        let crossed = self.complement(m, crossed);
        self.row(m, crossed, sign + 1);
        self.weigh(1, sign + 1);
        self.weigh(-1, 2 * sign + 1);
        // Row i ends below row i + half, so that both are one; the last of them below the sign's.
        let half = z.width().div_ceil(2);
        let fits = half < sign;
        for i in 0..half.min(sign) {
            let mut bits = self.pairs(m, low, i);
            if i + half < sign {
                let other = self.pairs(m, low, i + half);
                bits = m.or(bits, other);
            }
            if i == 0 && fits && 2 * sign < self.width {
                let own = self.placed(m, high, 2 * sign);
                bits = m.or(bits, own);
            }
            self.row(m, bits, 0);
        }
        if !fits {
            self.row(m, high, 2 * sign);
        }
    }

    /// Bit i of a square by itself and with the bits above it, at its place.
    fn pairs(&self, m: &mut ModuleBuilder, low: Signal, i: u32) -> Signal {
        let own = m.bit(low, i);
        let above = low.width() - i - 1;
        let bits = match above {
            0 => own,
            _ => {
                let higher = m.slice(low, i + 1, above);
                let met = masked(m, higher, low, i);
                let none = m.lit(0, Ty::bit());
                m.cat(&[met, none, own])
            }
        };
        self.placed(m, bits, 2 * i)
    }

    /// The value where the alternative is on, otherwise 0.
    fn only(&self, m: &mut ModuleBuilder, value: Signal) -> Signal {
        let bits = m.as_unsigned(value);
        let Some(own) = self.alternatives.last() else {
            return bits;
        };
        let mask = m.repeat(own.on, value.width());
        m.and(bits, mask)
    }

    /// The complement of bits, 0 where the alternative is not on.
    fn complement(&self, m: &mut ModuleBuilder, bits: Signal) -> Signal {
        let bits = m.not(bits);
        self.only(m, bits)
    }

    fn row(&mut self, m: &mut ModuleBuilder, bits: Signal, at: u32) {
        if at < self.width {
            let row = self.placed(m, bits, at);
            if let Some(own) = self.alternatives.last_mut() {
                own.rows.push(row);
            }
        }
    }

    /// Bits at their place in a row; those above it fall off.
    fn placed(&self, m: &mut ModuleBuilder, bits: Signal, at: u32) -> Signal {
        let bits = m.truncate(bits, bits.width().min(self.width - at));
        let bits = match at {
            0 => bits,
            _ => {
                let none = m.lit(0, Ty::u(at));
                m.cat(&[bits, none])
            }
        };
        m.extend(bits, self.width)
    }

    fn weigh(&mut self, sign: i32, at: u32) {
        self.constant(&(BigInt::from(sign) << at));
    }

    /// The rows of all alternatives, each named: one that is not on is 0.
    fn joined(&self, m: &mut ModuleBuilder) -> VecDeque<Signal> {
        let most = self.alternatives.iter().map(|own| own.rows.len()).max();
        let mut joined = VecDeque::new();
        for at in 0..most.unwrap_or(0) {
            let here = self.alternatives.iter().filter_map(|own| own.rows.get(at));
            let row = here.copied().reduce(|all, row| m.or(all, row));
            let named = row.map(|row| m.name(row, &format!("{}_row{at}", self.name)));
            joined.extend(named);
        }
        let modulus = BigInt::from(1) << self.width;
        let mut constants = vec![];
        for own in &self.alternatives {
            let constant = ((&own.constant % &modulus) + &modulus) % &modulus;
            if constant != BigInt::ZERO {
                let constant = m.lit(constant, Ty::u(self.width));
                let mask = m.repeat(own.on, self.width);
                constants.push(m.and(constant, mask));
            }
        }
        let constant = constants.into_iter().reduce(|all, own| m.or(all, own));
        joined.extend(constant.map(|own| m.name(own, &format!("{}_constant", self.name))));
        joined
    }

    /// Two addends with the sum of the rows.
    pub(super) fn two(self, m: &mut ModuleBuilder) -> [Signal; 2] {
        let mut queue = self.joined(m);
        let mut step = 0;
        while let [a, b, c, ..] = *queue.make_contiguous() {
            queue.drain(..3);
            let named = |m: &mut ModuleBuilder, s, kind: &str| {
                m.name(s, &format!("{}_{kind}{step}", self.name))
            };
            let either = m.xor(a, b);
            let either = named(m, either, "xor");
            let sum = m.xor(either, c);
            let sum = named(m, sum, "sum");
            let (both, third) = (m.and(a, b), m.and(either, c));
            let carry = m.or(both, third);
            let carry = m.truncate(carry, self.width - 1);
            let none = m.lit(0, Ty::bit());
            let carry = m.cat(&[carry, none]);
            let carry = named(m, carry, "carry");
            queue.extend([sum, carry]);
            step += 1;
        }
        let zero = m.lit(0, Ty::u(self.width));
        [0, 1].map(|i| queue.get(i).copied().unwrap_or(zero))
    }
}

/// `x` where bit `at` of `y` is set, otherwise 0.
fn masked(m: &mut ModuleBuilder, x: Signal, y: Signal, at: u32) -> Signal {
    let bit = m.bit(y, at);
    let mask = m.repeat(bit, x.width());
    let x = m.as_unsigned(x);
    m.and(x, mask)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_netlist::Interpreter;

    /// The sum of the two addends for all values of two inputs.
    fn every(
        widths: [u32; 2],
        signed: bool,
        out: u32,
        build: impl Fn(&mut ModuleBuilder, &mut Rows<'_>, Signal, Signal),
        expected: impl Fn(i64, i64) -> i64,
    ) {
        let mut m = ModuleBuilder::new("adder");
        let ty = |width| Ty { width, signed };
        let (x, y) = (
            m.input("x", ty(widths[0]), ""),
            m.input("y", ty(widths[1]), ""),
        );
        let mut rows = Rows::always("rows", out, &mut m);
        build(&mut m, &mut rows, x, y);
        let [a, b] = rows.two(&mut m);
        let sum = m.add(a, b);
        m.output("sum", sum, "");
        let module = m.finish().unwrap();
        let mut run = Interpreter::new(&module, 1);
        let [x, y, sum] = ["x", "y", "sum"].map(|name| run.port(name).unwrap());
        let mask = (1u64 << out) - 1;
        let value = |code: u64, width: u32| match signed {
            true => (code as i64) << (64 - width) >> (64 - width),
            false => code as i64,
        };
        for i in 0..1 << widths[0] {
            for j in 0..1 << widths[1] {
                run.set_u64(x, i).unwrap();
                run.set_u64(y, j).unwrap();
                run.eval().unwrap();
                let wanted = expected(value(i, widths[0]), value(j, widths[1])) as u64 & mask;
                assert_eq!(run.get_u64(sum).unwrap(), wanted, "{widths:?} {i} {j}");
            }
        }
    }

    #[test]
    fn products_are_those_of_integers() {
        for widths in [[2, 2], [2, 5], [5, 2], [6, 4]] {
            let out = widths[0] + widths[1];
            // Also where high bits fall off.
            for out in [out - 2, out, out + 3] {
                every(
                    widths,
                    true,
                    out,
                    |m, r, x, y| r.signed_product(m, x, y),
                    |x, y| x * y,
                );
            }
        }
        every(
            [5, 4],
            false,
            14,
            |m, r, x, y| {
                r.minus_product(m, x, y);
                r.shifted(m, x, 6);
            },
            |x, y| 64 * x - x * y,
        );
        every(
            [5, 1],
            false,
            12,
            |m, r, x, y| {
                r.multiple(m, x, &BigInt::from(45));
                r.value(m, y);
                r.constant(&BigInt::from(-3));
            },
            |x, y| 45 * x + y - 3,
        );
    }

    #[test]
    fn squares_are_those_of_integers() {
        for n in 2..=8 {
            for out in [2 * n - 1, 2 * n, 2 * n + 1] {
                every(
                    [n, 3],
                    true,
                    out,
                    |m, r, x, y| {
                        r.square(m, x);
                        r.value(m, y);
                    },
                    |x, y| x * x + y,
                );
            }
        }
    }

    /// A product, a square, a value or nothing, by what is on.
    #[test]
    fn alternatives_share_their_rows() {
        let mut m = ModuleBuilder::new("adder");
        let ons = ["product", "square", "value"].map(|name| m.input(name, Ty::bit(), ""));
        let (x, y) = (m.input("x", Ty::s(5), ""), m.input("y", Ty::s(4), ""));
        let mut rows = Rows::new("rows", 12);
        rows.or_if(ons[0]);
        rows.signed_product(&mut m, x, y);
        rows.or_if(ons[1]);
        rows.square(&mut m, x);
        rows.square(&mut m, y);
        rows.or_if(ons[2]);
        let held = rows.only(&mut m, x);
        let held = m.as_signed(held);
        rows.value(&mut m, held);
        let [a, b] = rows.two(&mut m);
        let sum = m.add(a, b);
        m.output("sum", sum, "");
        let module = m.finish().unwrap();
        let mut run = Interpreter::new(&module, 1);
        let [x, y, sum] = ["x", "y", "sum"].map(|name| run.port(name).unwrap());
        let ons = ["product", "square", "value"].map(|name| run.port(name).unwrap());
        for chosen in 0..4 {
            for (at, on) in ons.into_iter().enumerate() {
                run.set_u64(on, u64::from(at == chosen)).unwrap();
            }
            for i in -16i64..16 {
                for j in -8i64..8 {
                    run.set_u64(x, i as u64 & 31).unwrap();
                    run.set_u64(y, j as u64 & 15).unwrap();
                    run.eval().unwrap();
                    let wanted = [i * j, i * i + j * j, i, 0][chosen] as u64 & 0xfff;
                    assert_eq!(run.get_u64(sum).unwrap(), wanted, "{chosen} {i} {j}");
                }
            }
        }
    }
}
