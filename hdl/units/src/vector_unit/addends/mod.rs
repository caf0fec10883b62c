//! Sums of products as two addends, which a register stage holds between a multiplication and its sum.
//!
//! A product is rows of bits, one for each bit of a factor. Three rows become two with the same sum,
//! without a carry that runs through them, until two are left. Sums that never meet share their rows.

mod products;
#[cfg(test)]
mod tests;

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
