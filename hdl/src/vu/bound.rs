//! The largest error of an exponential that the netlist allows, over all operands
//! at once.
//!
//! Two things make a result differ from `2^F exp(-x)`. Bits that the datapath
//! drops: [`crate::ir`]'s analysis, clock by clock, of the unit as it is printed.
//! And what the recurrence itself leaves: without dropped bits the result would be
//! `exp(-x + g)`, where g is the sum of what is known of the netlist's registers
//! and constants: the remainder at the end, the start's alignment and bias, and
//! what each constant that is subtracted is off from its logarithm.

use std::f64::consts::LN_2;

use num_bigint::BigInt;
use num_traits::{ToPrimitive, Zero};
use potamoi_formats::config::{Config, ExpBase, ExpForm, ExpOutput};
use potamoi_formats::units::OpCode;

use super::constants::{less_than_log, multiples};
use super::top::vector_unit;
use crate::ir::{Binary, Interval, IrErrors, Machine, Module, Op};

/// More than the sums of `left`, of numbers below 32, are off in floating point.
const SLACK: f64 = 1e-12;

/// A guaranteed error, in units of the result's last place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// The most that a result is above or below the exact one, before a power of
    /// one is held below it.
    pub ulp: f64,
    /// Of it, what dropped bits are.
    pub dropped: f64,
    /// Operands among which the bound is the largest, codes.
    pub operands: [i64; 2],
}

/// Operands that decide the same exponent, and what follows from it.
struct Power {
    /// Of the result, least and most.
    dropped: [f64; 2],
    /// The logarithm of the result, had no bit been dropped, plus x: least and most.
    left: [f64; 2],
}

/// The bound for `exp` or `one-minus-exp` of a vector unit; `None` where it is not
/// built, and of what this analysis does not know: straight pieces, the literal
/// form and results with an exponent.
///
/// # Errors
/// As [`vector_unit`].
pub fn exponential_bound(config: &Config, op: OpCode) -> Result<Option<Bound>, IrErrors> {
    let exp = &config.vu.exp;
    let known = matches!(exp.form, ExpForm::Restoring | ExpForm::Radix4)
        && exp.output == ExpOutput::Alpha
        && exp.base == ExpBase::E
        && matches!(op, OpCode::Exp | OpCode::OneMinusExp)
        && config.vu.ops.contains(&op);
    if !known {
        return Ok(None);
    }
    // Lanes are alike.
    let mut one = config.clone();
    one.vu.lanes = 1;
    let module = vector_unit(&one)?;
    Ok(largest(&one, op, &module))
}

/// The bound of a unit of one lane.
fn largest(config: &Config, op: OpCode, module: &Module) -> Option<Bound> {
    let exp = &config.vu.exp;
    let (fraction, last) = match op {
        OpCode::Exp => (exp.input.frac_bits(), exp.input.max() as i64),
        _ => (exp.one_minus_frac_bits, (16 << exp.one_minus_frac_bits) - 1),
    };
    let mut run = Run::new(config, op, module)?;
    let mut todo = spans(last, fraction, exp.resolved_bits());
    let mut worst: Option<Bound> = None;
    while let Some([low, high]) = todo.pop() {
        let Some(power) = run.power([low, high], fraction) else {
            if low == high {
                return None;
            }
            let middle = low + (high - low) / 2;
            todo.extend([[low, middle], [middle + 1, high]]);
            continue;
        };
        let exact = 2f64.powi(exp.output_bits as i32)
            * (-(low as f64) * 2f64.powi(-(fraction as i32))).exp();
        let below = power.dropped[0] + exact * power.left[0].exp_m1().min(0.0);
        let above = power.dropped[1] + exact * power.left[1].exp_m1().max(0.0);
        let found = Bound {
            ulp: above.max(-below),
            dropped: power.dropped[1].max(-power.dropped[0]),
            operands: [low, high],
        };
        worst = worst.filter(|w| w.ulp >= found.ulp).or(Some(found));
    }
    worst
}

/// Codes from 0 to `last`, cut about where the exponent changes.
fn spans(last: i64, fraction: u32, bits: u32) -> Vec<[i64; 2]> {
    let centre = 2f64.powi(-(bits as i32) - 1);
    let mut starts = vec![0];
    for k in 0..=24 {
        let x = f64::from(k) * LN_2 + centre;
        let code = (x * 2f64.powi(fraction as i32)).floor() as i64;
        starts.extend([code - 2, code + 3]);
    }
    starts.push(8 << fraction);
    starts.retain(|s| (0..=last).contains(s));
    starts.sort_unstable();
    starts.dedup();
    let ends = starts.iter().skip(1).map(|s| s - 1).chain([last]);
    starts
        .iter()
        .copied()
        .zip(ends)
        .map(|(a, b)| [a, b])
        .collect()
}

/// What steps have taken from the remainder.
#[derive(Default)]
struct Taken {
    steps: u32,
    /// Of the exponent's digits, with the constants' fraction bits.
    digits: BigInt,
    /// What logarithms are above the other constants, in all: least and most.
    off: [f64; 2],
}

/// The unit with one lane, and the signals that are looked at.
struct Run<'a> {
    config: &'a Config,
    op: OpCode,
    machine: Machine<'a>,
    valid: usize,
    data: usize,
    done: usize,
    start: usize,
    remain: usize,
    exponent: usize,
    result: usize,
    /// What enables steps, and what multiplies instead, of the iterative form.
    steps: Option<usize>,
    tail: Option<usize>,
}

impl<'a> Run<'a> {
    fn new(config: &'a Config, op: OpCode, module: &'a Module) -> Option<Self> {
        let exp = &config.vu.exp;
        let last = exp.engine().steps.div_ceil(exp.iterations_per_clock) - 1;
        let remain = if exp.pipelined {
            format!("lane0.s_remain_{last}")
        } else {
            "lane0.r_remain".to_owned()
        };
        let signals = [
            "result_valid",
            "lane0.remain_start",
            &remain,
            "lane0.exponent",
            "lane0.rounded",
        ];
        let machine = Machine::new(module, &signals)?;
        let remain = machine.find(&remain)?;
        let steps = match &machine.node(remain).op {
            Op::Reg { enable, .. } => enable.map(|e| machine.beside(remain, e)),
            _ => return None,
        };
        Some(Self {
            config,
            op,
            valid: machine.find("s_axis_vec_tvalid")?,
            data: machine.find("s_axis_vec_tdata")?,
            done: machine.find("result_valid")?,
            start: machine.find("lane0.remain_start")?,
            remain,
            exponent: machine.find("lane0.exponent")?,
            result: machine.find("lane0.rounded")?,
            steps,
            tail: machine.find("lane0.tail"),
            machine,
        })
    }

    fn point(&self, id: usize) -> Option<BigInt> {
        let value = self.machine.value(id);
        value.is_point().then(|| value.low.clone())
    }

    fn yes(&self, id: usize) -> Option<bool> {
        Some(!self.point(id)?.is_zero())
    }

    /// Sets what does not change while an operation of these operands runs.
    fn prepare(&mut self, [low, high]: [i64; 2]) {
        self.machine.reset();
        self.machine.set(self.data, Interval::new(low, high));
        for (name, value) in [
            ("cfg_clear", 0),
            ("s_axis_vec_tkeep", 1),
            ("s_axis_vec_tlast", 0),
            ("s_axis_vec_tuser", self.op.code()),
            ("m_axis_vec_tready", 1),
        ] {
            if let Some(port) = self.machine.find(name) {
                self.machine.set(port, Interval::new(value, value));
            }
        }
    }

    /// Runs an operation of any of these operands; `None` where they do not decide
    /// the same exponent and the same clocks.
    fn power(&mut self, operands: [i64; 2], fraction: u32) -> Option<Power> {
        let exp = &self.config.vu.exp;
        let (engine, pipelined) = (exp.engine(), exp.pipelined);
        let bias = self.bias(operands[0], fraction)?;
        self.prepare(operands);
        let mut taken = Taken::default();
        let mut start = [0.0; 2];
        let (mut remain, mut multiplied) = (Interval::new(0, 0), false);
        for cycle in 0..=engine.interval + 1 {
            // The pipeline is full of the same operands.
            let offered = u8::from(cycle == 0 || pipelined);
            self.machine
                .set(self.valid, Interval::new(offered, offered));
            self.machine.settle();
            if cycle == 0 {
                start = self.machine.off(self.start)?.bounds();
            }
            let done = self.yes(self.done)?;
            if !multiplied {
                remain = self.machine.value(self.remain).clone();
            }
            if done {
                break;
            }
            let tail = match self.tail {
                Some(tail) => self.yes(tail)?,
                None => false,
            };
            multiplied |= tail;
            let steps = match self.steps {
                Some(enable) => self.yes(enable)? && !tail,
                None => false,
            };
            if steps {
                for index in 0..exp.iterations_per_clock {
                    self.step(index, &mut taken)?;
                }
            }
            self.machine.clock();
        }
        if !self.yes(self.done)? {
            return None;
        }
        if pipelined {
            for index in 0..engine.turn * exp.iterations_per_clock {
                self.step(index, &mut taken)?;
            }
        }
        let unit = 2f64.powi(-(engine.constant_bits as i32));
        let [least, most] = [remain.low.to_f64()? * unit, remain.high.to_f64()? * unit];
        let remain = if exp.tail {
            // The product takes 1 + r for exp(r).
            [most.ln_1p() - most, 0.0]
        } else {
            [-most, -least]
        };
        let offset = f64::from(engine.offset) * 2f64.powi(-(engine.accumulator_bits as i32));
        let exponent = self.point(self.exponent)?.to_f64()?;
        let fixed = offset.ln_1p() - exponent * LN_2 + (bias - taken.digits.to_f64()?) * unit;
        let left = [-SLACK, SLACK];
        let left = [0, 1].map(|i| left[i] + fixed + start[i] * unit + remain[i] + taken.off[i]);
        let dropped = self.machine.off(self.result)?.bounds();
        Some(Power { dropped, left })
    }

    /// What the remainder starts with for the operand 0, or for one of 8 and more:
    /// with its bits, had it the operand 0.
    fn bias(&mut self, operand: i64, fraction: u32) -> Option<f64> {
        let bits = self.config.vu.exp.engine().constant_bits;
        let eight = if operand >> fraction < 8 { 0 } else { 8 };
        self.prepare([eight << fraction; 2]);
        self.machine.set(self.valid, Interval::new(1, 1));
        self.machine.settle();
        (self.point(self.start)? + (BigInt::from(eight) << bits)).to_f64()
    }

    /// One step: digits of the exponent that it takes, and what the constants that
    /// it may subtract are off.
    fn step(&self, index: u32, taken: &mut Taken) -> Option<()> {
        let exp = &self.config.vu.exp;
        let engine = exp.engine();
        let names = match exp.form {
            ExpForm::Radix4 => vec!["take_one", "take_two", "take_three"],
            _ => vec!["take"],
        };
        let (mut digit, mut off) = (BigInt::zero(), [0.0f64; 2]);
        for (d, name) in multiples(exp.form).zip(names) {
            let take = self.machine.find(&format!("lane0.{name}{index}"))?;
            let (take, constant) = self.compared(take)?;
            let takes = self.yes(take);
            if takes == Some(false) {
                continue;
            }
            let constant = self.point(constant)?;
            if taken.steps < engine.digits {
                takes?;
                digit = constant;
                continue;
            }
            let shifted = self.machine.find(&format!("lane0.accum_shifted{index}"))?;
            let Op::Shr(_, amount) = &self.machine.node(shifted).op else {
                return None;
            };
            let amount = self
                .point(self.machine.beside(shifted, *amount))?
                .to_u32()?;
            let less = less_than_log(&constant, engine.constant_bits, d, amount);
            off = if takes == Some(true) {
                // It takes the place of smaller digits.
                [less, less]
            } else {
                [off[0].min(less), off[1].max(less)]
            };
        }
        taken.steps += 1;
        taken.digits += digit;
        for (sum, off) in taken.off.iter_mut().zip(off) {
            *sum += off;
        }
        Some(())
    }

    /// The comparison that a decision is made by, and what is compared with.
    fn compared(&self, id: usize) -> Option<(usize, usize)> {
        match &self.machine.node(id).op {
            Op::Binary(Binary::Le, constant, _) => Some((id, self.machine.beside(id, *constant))),
            Op::Cast(a) => self.compared(self.machine.beside(id, *a)),
            Op::Mux(c, t, e) => {
                let side = if self.yes(self.machine.beside(id, *c))? {
                    t
                } else {
                    e
                };
                self.compared(self.machine.beside(id, *side))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests;
