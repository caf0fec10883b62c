//! Rows of products and squares.

use num_bigint::BigInt;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::Rows;

impl Rows<'_> {
    /// Subtracts the product of two unsigned factors: -v of n bits is its complement, 1 and -2^n.
    pub(in crate::vector_unit) fn minus_product(
        &mut self,
        m: &mut ModuleBuilder,
        x: Signal,
        y: Signal,
    ) {
        for at in 0..y.width() {
            let bits = masked(m, x, y, at);
            let bits = self.complement(m, bits);
            self.row(m, bits, at);
            self.weigh(1, at);
            self.weigh(-1, at + x.width());
        }
    }

    /// Adds the product of an unsigned factor and a constant.
    pub(in crate::vector_unit) fn multiple(
        &mut self,
        m: &mut ModuleBuilder,
        x: Signal,
        factor: &BigInt,
    ) {
        for at in (0..factor.bits()).filter(|at| factor.bit(*at)) {
            self.row(m, x, at as u32);
        }
    }

    /// Adds the product of two signed factors of at least two bits (Baugh and Wooley): signs have a
    /// negative weight, as in [`Rows::value`].
    pub(in crate::vector_unit) fn signed_product(
        &mut self,
        m: &mut ModuleBuilder,
        x: Signal,
        y: Signal,
    ) {
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
    pub(in crate::vector_unit) fn square(&mut self, m: &mut ModuleBuilder, z: Signal) {
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
}

/// `x` where bit `at` of `y` is set, otherwise 0.
fn masked(m: &mut ModuleBuilder, x: Signal, y: Signal, at: u32) -> Signal {
    let bit = m.bit(y, at);
    let mask = m.repeat(bit, x.width());
    let x = m.as_unsigned(x);
    m.and(x, mask)
}
