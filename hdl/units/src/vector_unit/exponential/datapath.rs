//! Datapath of the engine: start, tail and result.

use num_bigint::BigInt;
use potamoi_formats::config::ExpOutput;
use potamoi_formats::fixed::Rounding;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::form::{Powers, Recurrence, Shift, State, StepInputs, Widths};
use super::logistic::Size;
use crate::circuits::{bits_for, held};

impl Widths {
    /// `Z ln 2`, centred.
    fn bias(&self, own: &dyn Recurrence, z: u32) -> BigInt {
        let bits = self.engine.constant_bits;
        let sum = own.bias(z, bits);
        if self.engine.centred {
            sum + (BigInt::from(1) << (bits - self.exp.resolved_bits() - 1))
        } else {
            sum
        }
    }

    /// The state before the first step, and whether the larger bias was used. `size` are the
    /// operands of sigmoid and softplus, where built.
    pub(super) fn start(
        &self,
        own: &dyn Recurrence,
        m: &mut ModuleBuilder,
        a: Signal,
        one_minus: Signal,
        size: Option<Size>,
    ) -> (State, Signal) {
        let bits = self.engine.constant_bits;
        let zero = m.lit(0, Ty::bit());
        let format = self.exp.input;
        let power = self.operand(m, a);
        let wide = m.extend(power, self.remain.width.max(power.width()));
        let wide = m.name(wide, "power_extended");
        let wide = m.truncate(wide, self.remain.width);
        let aligned = m.shl_const(wide, bits - format.frac_bits());
        let aligned = m.name(aligned, "power_aligned");
        let one = (BigInt::from(1) << self.engine.accumulator_bits) + self.engine.offset;
        let one = if own.is_literal() {
            BigInt::from(1) << self.engine.accumulator_bits
        } else {
            one
        };
        let accum = m.param("ACCUM_START", one, self.accum, "1 and the offset");
        let digits = m.lit(0, self.digits);
        let (remain, large) = match self.exp.output {
            _ if own.is_literal() => (aligned, zero),
            ExpOutput::General => {
                let bias = self.bias(own, self.engine.bias);
                let bias = m.param("BIAS", bias, self.remain, "Z ln 2");
                let x = m.as_unsigned(aligned);
                (m.add(bias, x), zero)
            }
            ExpOutput::Alpha => {
                let bias = self.bias(own, 12);
                let bias = m.param("BIAS", bias, self.remain, "12 ln 2, centred");
                let plain = m.sub(bias, aligned);
                if self.kinds.one_minus || size.is_some() {
                    let mut depth = self.kinds.one_minus.then(|| self.depth(m, a));
                    let mut wide = one_minus;
                    if let Some(size) = size {
                        depth = Some(size.or(m, depth));
                        wide = m.or(size.given, wide);
                        wide = m.name(wide, "takes_depth");
                    }
                    let (aligned, large) = depth.unwrap_or((plain, zero));
                    let remain = self.start_depth(own, m, aligned, large, bias);
                    let large = m.and(large, wide);
                    (m.mux(wide, remain, plain), m.name(large, "rescaled"))
                } else {
                    (plain, zero)
                }
            }
        };
        let remain = m.name(remain, "remain_start");
        (
            State {
                remain,
                accum,
                digits,
            },
            large,
        )
    }

    /// The largest remainder before the first step.
    pub(super) fn start_most(&self, own: &dyn Recurrence) -> BigInt {
        let bits = self.engine.constant_bits;
        match self.exp.output {
            // From 8 on, the larger bias is used.
            ExpOutput::Alpha if !own.is_literal() => {
                let near = self.bias(own, 12);
                let far = self.bias(own, 24) - (BigInt::from(8) << bits);
                if self.kinds.one_minus {
                    near.max(far)
                } else {
                    near
                }
            }
            _ => (BigInt::from(1) << self.remain.width) - 1,
        }
    }

    /// The operand of exp.
    pub(super) fn operand(&self, m: &mut ModuleBuilder, a: Signal) -> Signal {
        let format = self.exp.input;
        let ty = Ty {
            width: format.width(),
            signed: format.is_signed(),
        };
        let power = m.saturate(a, ty);
        let power = m.name(power, "power");
        m.note(power, &format!("the operand, held within {format}"))
    }

    /// The operand of `1 - exp(-s)` with the constants' fraction bits, and whether it is at least
    /// 8.
    pub(super) fn depth(&self, m: &mut ModuleBuilder, a: Signal) -> (Signal, Signal) {
        let (bits, frac) = (self.engine.constant_bits, self.exp.one_minus_frac_bits);
        let s = m.saturate(a, Ty::u(4 + frac));
        let s = m.name(s, "depth");
        m.note(
            s,
            &format!("the operand of 1 - exp(-s), held within U4.{frac}"),
        );
        let large = m.bit(s, 3 + frac);
        let width = self.remain.width + 1;
        let aligned = if frac > bits {
            let rounded = m.round(s, frac - bits, Rounding::HalfUp);
            m.extend(rounded, width)
        } else {
            let wide = m.extend(s, width);
            m.shl_const(wide, bits - frac)
        };
        (aligned, large)
    }

    /// The start for an exponent of up to 16, with a matching bias.
    fn start_depth(
        &self,
        own: &dyn Recurrence,
        m: &mut ModuleBuilder,
        aligned: Signal,
        large: Signal,
        bias: Signal,
    ) -> Signal {
        let width = self.remain.width + 1;
        let far = m.param(
            "FAR_BIAS",
            self.bias(own, 24),
            Ty::u(width),
            "24 ln 2, centred",
        );
        let near = m.extend(bias, width);
        let from = m.mux(large, far, near);
        let remain = m.sub(from, aligned);
        let remain = m.name(remain, "depth_remain");
        m.truncate(remain, self.remain.width)
    }

    /// `R_accum (1 + 2^-i)`; where sums are `rounded`, the dropped bit is added.
    pub(super) fn grown(
        &self,
        m: &mut ModuleBuilder,
        s: State,
        place: &StepInputs,
        index: u32,
        rounded: bool,
    ) -> Signal {
        let more = self.shifted(m, s.accum, place.shift, index, rounded);
        more.into_iter().fold(s.accum, |sum, one| m.add(sum, one))
    }

    /// A value shifted to the right, as addends of the accumulator's width: what is left, and where
    /// it is `rounded` the last bit that is dropped.
    pub(super) fn shifted(
        &self,
        m: &mut ModuleBuilder,
        value: Signal,
        shift: Shift,
        index: u32,
        rounded: bool,
    ) -> Vec<Signal> {
        let width = self.accum.width;
        let name = format!("accum_shifted{index}");
        let addends = match shift {
            Shift::By(by) => {
                let rounding = match rounded {
                    true => Rounding::HalfUp,
                    false => Rounding::Floor,
                };
                // More steps than bits shift everything out.
                let wide = m.extend(value, value.width().max(by + 1));
                let shifted = m.round(wide, by, rounding);
                vec![m.name(shifted, &name)]
            }
            Shift::Of(by) => {
                // One more bit below: the dropped bit rounds.
                let none = m.lit(0, Ty::bit());
                let doubled = m.cat(&[value, none]);
                let shifted = m.shr(doubled, by);
                let shifted = m.name(shifted, &name);
                let whole = m.slice(shifted, 1, value.width());
                let up = m.bit(shifted, 0);
                vec![whole, up][..1 + usize::from(rounded)].to_vec()
            }
        };
        let fit = |one: Signal| match one.width() < width {
            true => m.extend(one, width),
            false => m.truncate(one, width),
        };
        addends.into_iter().map(fit).collect()
    }

    /// `R_accum (1 + R_remain)`, truncated.
    pub(super) fn tail(&self, m: &mut ModuleBuilder, s: State) -> State {
        let bits = self.engine.constant_bits;
        // What is left is below 2^-n, and a unit for every constant's rounding.
        let below = bits.saturating_sub(self.exp.resolved_bits());
        let most = (1u64 << below) + u64::from(self.engine.steps + 2);
        let left = m.truncate(s.remain, (most.ilog2() + 1).min(bits));
        let left = m.name(left, "residual");
        let product = m.mul(s.accum, left);
        let product = m.name(product, "tail_product");
        let Some(width) = product.width().checked_sub(bits).filter(|&width| width > 0) else {
            return s;
        };
        let more = m.slice(product, bits, width.min(self.accum.width));
        let more = m.extend(more, self.accum.width);
        let accum = m.add(s.accum, more);
        State {
            accum: m.name(accum, "accum_tail"),
            ..s
        }
    }

    /// The exponent from the digits found by the steps.
    pub(super) fn exponent_of_digits(
        &self,
        m: &mut ModuleBuilder,
        s: State,
        large: Signal,
    ) -> Signal {
        let bias = m.lit(12, Ty::u(5));
        let bias = if self.kinds.one_minus || self.kinds.logistic() {
            let far = m.lit(24, Ty::u(5));
            m.mux(large, far, bias)
        } else {
            bias
        };
        let digits = m.extend(s.digits, 5);
        let k = m.sub(bias, digits);
        let k = m.name(k, "exponent");
        m.note(k, "the result is R_accum 2^-exponent");
        k
    }

    /// `R_accum 2^-k` with one guard bit, for sigmoid and softplus.
    pub(super) fn scaled(&self, m: &mut ModuleBuilder, s: State, large: Signal) -> Signal {
        let k = self.form.exponent(m, self, s, large);
        let none = m.lit(0, Ty::bit());
        let doubled = m.cat(&[s.accum, none]);
        let doubled = m.name(doubled, "accum_doubled");
        let scaled = m.shr(doubled, k);
        m.name(scaled, "power_scaled")
    }

    /// The 32-bit result from the final state.
    pub(in crate::vector_unit) fn result(
        &self,
        m: &mut ModuleBuilder,
        powers: &Powers,
        one_minus: Signal,
        registered: bool,
    ) -> Signal {
        // Before the result stage; what is shifted is held shifted instead.
        let hold = |m: &mut ModuleBuilder, name: &str, value: Signal| match registered {
            true => held(m, name, value),
            false => value,
        };
        let mut s = powers.state;
        if self.form.is_bare() || self.exp.output == ExpOutput::General {
            s.accum = hold(m, "accum_held", s.accum);
            s.digits = hold(m, "digits_held", s.digits);
        }
        let (wa, f) = (self.engine.accumulator_bits, self.exp.output_bits);
        if self.form.is_bare() {
            let rounded = m.round(s.accum, wa - f, Rounding::HalfUp);
            return self.word(m, rounded);
        }
        if self.exp.output == ExpOutput::General {
            return self.general(m, s);
        }
        let fixed_width = s.accum.width() + 1 - (wa - f);
        let scaled = if let Some((power, _)) = powers.logistic {
            m.slice(power, wa - f, fixed_width)
        } else {
            let k = powers.exponent;
            let k = k.unwrap_or_else(|| self.form.exponent(m, self, s, powers.large));
            let none = m.lit(0, Ty::bit());
            let doubled = m.cat(&[s.accum, none]);
            let doubled = m.name(doubled, "accum_doubled");
            let fixed = m.slice(doubled, wa - f, fixed_width);
            m.shr(fixed, k)
        };
        let scaled = m.name(scaled, "scaled");
        // The power of sigmoid and softplus is held already.
        let scaled = match powers.logistic {
            Some(_) => scaled,
            None => hold(m, "scaled_held", scaled),
        };
        let whole = m.slice(scaled, 1, fixed_width - 1);
        let up = m.bit(scaled, 0);
        let up = m.extend(up, whole.width());
        let e = m.add(whole, up);
        let e = m.name(e, "rounded");
        let top = m.saturate(e, Ty::u(f));
        let alpha = self.word(m, top);
        if !self.kinds.one_minus {
            return alpha;
        }
        let one = m.lit(BigInt::from(1) << f, e.ty());
        let rest = m.sub(one, e);
        let past = m.gt(e, one);
        let zero = m.lit(0, rest.ty());
        let rest = m.mux(past, zero, rest);
        let rest = m.name(rest, "one_minus_power");
        let held = m.saturate(rest, Ty::u(f));
        let other = self.word(m, held);
        m.mux(one_minus, other, alpha)
    }

    fn general(&self, m: &mut ModuleBuilder, s: State) -> Signal {
        let (wa, f) = (self.engine.accumulator_bits, self.exp.output_bits);
        let m_rounded = m.round(s.accum, wa - f, Rounding::HalfUp);
        let m_rounded = m.name(m_rounded, "mantissa_rounded");
        let two = m.lit(BigInt::from(2) << f, m_rounded.ty());
        let over = m.ge(m_rounded, two);
        let over = m.name(over, "mantissa_over");
        let low = m.slice(m_rounded, 0, f + 1);
        let one = m.lit(BigInt::from(1) << f, low.ty());
        let mantissa = m.mux(over, one, low);
        let width = 32 - (f + 1);
        let room = width
            .max(bits_for(self.engine.bias) + 2)
            .max(self.digits.width + 1);
        let digits = m.extend(s.digits, room);
        let bias = m.lit(self.engine.bias, Ty::u(room));
        let over = m.extend(over, room);
        let e = m.sub(digits, bias);
        let e = m.add(e, over);
        let e = m.name(e, "exponent");
        let e = m.truncate(e, width);
        m.cat(&[e, mantissa])
    }

    fn word(&self, m: &mut ModuleBuilder, s: Signal) -> Signal {
        let s = m.as_unsigned(s);
        if s.width() > 32 {
            m.truncate(s, 32)
        } else {
            m.extend(s, 32)
        }
    }
}
