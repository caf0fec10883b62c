//! Sigmoid and softplus: two and three passes through the engine's registers.
//!
//! An exponential of `-|x|`; then `ln(1 + e)` by the factors that bring `1 + e`
//! up towards 2, whose logarithms are the constants of `SR_sub`; for sigmoid an
//! exponential again. Bits: `docs/reference/vector-unit.md`.

use num_bigint::BigInt;
use potamoi_formats::fixed::Rounding;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::constants::ln_one_plus;
use super::form::{State, Widths};

/// An exponent of up to 16, from which sigmoid or softplus starts an exponential.
#[derive(Clone, Copy)]
pub(super) struct Size {
    /// The exponent with the constants' fraction bits, one bit wider than `R_remain`.
    pub(super) aligned: Signal,
    /// Whether it is at least 8.
    pub(super) large: Signal,
    /// Whether the exponential starts from it.
    pub(super) given: Signal,
}

impl Size {
    /// This exponent where given, otherwise the operand of one-minus-exp.
    pub(super) fn or(
        self,
        m: &mut ModuleBuilder,
        depth: Option<(Signal, Signal)>,
    ) -> (Signal, Signal) {
        match depth {
            Some((aligned, large)) => (
                m.mux(self.given, self.aligned, aligned),
                m.mux(self.given, self.large, large),
            ),
            None => (self.aligned, self.large),
        }
    }
}

/// Control of a lane for the logistic operations.
#[derive(Clone, Copy)]
pub(super) struct Passes {
    /// Whether the operands are those of sigmoid or softplus.
    logistic: Signal,
    /// Whether the operands are those of sigmoid; `None` if only one of the two is built.
    sigmoid: Option<Signal>,
    /// Whether this cycle's steps are the logarithm's.
    pub(super) log: Signal,
    /// Whether they are the logarithm's first. In a registered unit, whether the registers take its
    /// start at the clock edge.
    pub(super) begin_log: Signal,
    /// Whether this cycle's steps are the first of sigmoid's second exponential. In a registered
    /// unit, whether the registers take its start at the clock edge.
    pub(super) again: Option<Signal>,
    /// In a registered unit, whether the sum with the logarithm is registered at the clock edge.
    take_sum: Option<Signal>,
}

impl Passes {
    /// Declares the ports, where the operations are built.
    pub(super) fn declare(
        m: &mut ModuleBuilder,
        widths: &Widths,
        registered: bool,
    ) -> Option<Self> {
        let kinds = widths.kinds;
        if !kinds.logistic() {
            return None;
        }
        let (begin_log, again) = match registered {
            true => (
                (
                    "load_log",
                    "takes the start of the logarithm at the clock edge",
                ),
                (
                    "load_again",
                    "takes the start of sigmoid's second power at the clock edge",
                ),
            ),
            false => (
                (
                    "begin_log",
                    "they are its first: from the power in the registers",
                ),
                (
                    "begin_again",
                    "this cycle's steps are the first of sigmoid's second power",
                ),
            ),
        };
        let mut port = |(name, doc): (&str, &str)| m.input(name, Ty::bit(), doc);
        Some(Self {
            logistic: port(("logistic", "of the operands: sigmoid or softplus")),
            sigmoid: (kinds.sigmoid && kinds.softplus)
                .then(|| port(("sigmoid", "of the operands: 1 / (1 + exp(-a))"))),
            log: port(("log", "this cycle's steps are the logarithm's")),
            begin_log: port(begin_log),
            again: kinds.sigmoid.then(|| port(again)),
            take_sum: registered.then(|| {
                port((
                    "take_sum",
                    "takes the sum with the logarithm at the clock edge",
                ))
            }),
        })
    }

    /// Holds `max(x, 0)`, or `max(-x, 0)` for sigmoid, from `taken` on, and adds the logarithm.
    /// Also returns the exponent from which an exponential starts.
    pub(super) fn sum(
        &self,
        m: &mut ModuleBuilder,
        widths: &Widths,
        a: Signal,
        taken: Signal,
        regs: State,
    ) -> (Size, Signal) {
        let (kinds, bits) = (widths.kinds, widths.engine.constant_bits);
        let frac = widths.exp.input.frac_bits();
        let negative = m.bit(a, 31);
        let negated = m.neg(a);
        let size = m.mux(negative, negated, a);
        let size = m.as_unsigned(size);
        let size = m.name(size, "size");
        m.note(size, "|a|, 2^31 included");
        let linear = match self.sigmoid {
            Some(sigmoid) => {
                let apart = m.xor(negative, sigmoid);
                m.not(apart)
            }
            None if kinds.sigmoid => negative,
            None => m.not(negative),
        };
        let mask = m.repeat(linear, 32);
        let linear = m.and(size, mask);
        let held = m.data_reg("r_linear", Ty::u(32));
        m.note(held, "max(a, 0) of softplus, max(-a, 0) of sigmoid");
        m.set_next_if(held, taken, linear);

        let mut sum = self.add(m, widths, held, regs);
        if let Some(take) = self.take_sum {
            let held = m.data_reg("r_softplus", sum.ty());
            m.set_next_if(held, take, sum);
            sum = held;
        }
        let near = m.saturate(size, Ty::u(4 + frac));
        let near = m.name(near, "size_held");
        let mut large = m.bit(near, 3 + frac);
        let width = widths.remain.width + 1;
        let wide = m.extend(near, width);
        let mut aligned = m.shl_const(wide, bits - frac);
        let mut given = self.logistic;
        if let Some(again) = self.again {
            let second = m.saturate(sum, Ty::u(4 + bits));
            let second = m.name(second, "softplus_held");
            let high = m.bit(second, 3 + bits);
            let second = m.extend(second, width);
            aligned = m.mux(again, second, aligned);
            large = m.mux(again, high, large);
            given = m.or(again, given);
            given = m.name(given, "takes_size");
        }
        (
            Size {
                aligned,
                large,
                given,
            },
            sum,
        )
    }

    /// `linear + ln(1 + e)` with the constants' fraction bits, signed: it may be about one unit
    /// below 0.
    fn add(&self, m: &mut ModuleBuilder, widths: &Widths, linear: Signal, regs: State) -> Signal {
        let engine = widths.engine;
        // Half of R_accum: what it lacks of 2 is its own logarithm.
        let (from, to) = (engine.accumulator_bits + 1, engine.constant_bits);
        let half = if from > to {
            m.slice(regs.accum, from - to, regs.accum.width() - (from - to))
        } else {
            let wide = m.extend(regs.accum, regs.accum.width() + to - from);
            m.shl_const(wide, to - from)
        };
        let half = m.extend(half, widths.remain.width);
        let log = m.add(regs.remain, half);
        let log = m.as_signed(log);
        let log = m.name(log, "logarithm");
        let frac = widths.exp.input.frac_bits();
        let width = (33 + to - frac).max(widths.remain.width) + 1;
        let linear = m.extend(linear, width);
        let linear = m.shl_const(linear, to - frac);
        let linear = m.as_signed(linear);
        let log = m.extend(log, width);
        let sum = m.add(linear, log);
        m.name(sum, "softplus")
    }
}

impl Widths {
    /// Start of the logarithm: `1 + e` and the constant, from the power in the registers.
    pub(super) fn start_log(&self, m: &mut ModuleBuilder, power: Signal, digits: Signal) -> State {
        let width = self.accum.width;
        let e = m.slice(power, 1, width);
        let up = m.bit(power, 0);
        let up = m.extend(up, width);
        let one = m.lit(BigInt::from(1) << self.engine.accumulator_bits, self.accum);
        let y = m.add(one, e);
        let y = m.add(y, up);
        let modulus = BigInt::from(1) << self.remain.width;
        let start = (self.log_start() + &modulus) % modulus;
        State {
            remain: m.param(
                "LOG_START",
                start,
                self.remain,
                "ln 2 - 1, as found from 1: ln 1 is exactly 0",
            ),
            accum: m.name(y, "one_plus_power"),
            digits,
        }
    }

    /// The initial constant for which `LOG_START - constants + R_accum / 2` is exactly 0 at e = 0.
    fn log_start(&self) -> BigInt {
        let engine = self.engine;
        let one = BigInt::from(1) << engine.accumulator_bits;
        let (mut accum, mut sum) = (one.clone(), BigInt::ZERO);
        for i in 1..=self.exp.iterations {
            let more: BigInt = &accum + (((&accum << 1u32 >> i) + 1u32) >> 1u32);
            if more < &one * 2u32 {
                accum = more;
                sum += ln_one_plus(i, engine.constant_bits);
            }
        }
        sum - (accum << engine.constant_bits >> (engine.accumulator_bits + 1))
    }

    /// The 32-bit result of softplus.
    pub(in crate::vector_unit) fn softplus(&self, m: &mut ModuleBuilder, sum: Signal) -> Signal {
        let (from, to) = (self.engine.constant_bits, self.exp.output_bits);
        let rounded = if from >= to {
            m.round(sum, from - to, Rounding::HalfUp)
        } else {
            let wide = m.extend(sum, sum.width() + to - from);
            m.shl_const(wide, to - from)
        };
        let rounded = m.name(rounded, "softplus_rounded");
        let held = m.saturate(rounded, Ty::u(31));
        let held = m.as_unsigned(held);
        m.extend(held, 32)
    }
}
