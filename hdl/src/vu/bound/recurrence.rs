//! What the recurrence leaves of a power, and what its datapath drops.

use std::f64::consts::LN_2;

use num_bigint::BigInt;
use num_traits::{ToPrimitive, Zero};
use potamoi_formats::config::{Config, ExpForm};
use potamoi_formats::units::OpCode;

use super::unit::Unit;
use super::{Errors, SLACK};
use crate::ir::{Binary, Interval, Module, Op};
use crate::vu::constants::{less_than_log, multiples};

/// What steps have taken from the remainder.
#[derive(Default)]
struct Taken {
    steps: u32,
    /// Of the exponent's digits, with the constants' fraction bits.
    digits: BigInt,
    /// What logarithms are above the other constants, in all: least and most.
    off: [f64; 2],
}

/// The unit, and the signals that are looked at.
pub(super) struct Recurrence<'a> {
    unit: Unit<'a>,
    start: usize,
    remain: usize,
    exponent: usize,
    /// What enables steps, and what multiplies instead, of the iterative form.
    steps: Option<usize>,
    tail: Option<usize>,
}

impl<'a> Recurrence<'a> {
    pub(super) fn new(config: &'a Config, op: OpCode, module: &'a Module) -> Option<Self> {
        let exp = &config.vu.exp;
        let last = exp.engine().steps.div_ceil(exp.iterations_per_clock) - 1;
        let remain = if exp.pipelined {
            format!("lane0.s_remain_{last}")
        } else {
            "lane0.r_remain".to_owned()
        };
        let signals = ["lane0.remain_start", &remain, "lane0.exponent"];
        let unit = Unit::new(config, op, module, &signals, &[])?;
        let machine = &unit.machine;
        let remain = machine.find(&remain)?;
        let steps = match &machine.node(remain).op {
            Op::Reg { enable, .. } => enable.map(|e| machine.beside(remain, e)),
            _ => return None,
        };
        Some(Self {
            start: machine.find("lane0.remain_start")?,
            remain,
            exponent: machine.find("lane0.exponent")?,
            steps,
            tail: machine.find("lane0.tail"),
            unit,
        })
    }

    /// Runs an operation of any of these operands; `None` where they do not decide
    /// the same exponent and the same clocks.
    pub(super) fn errors(&mut self, operands: [i64; 2], fraction: u32) -> Option<Errors> {
        let exp = &self.unit.config.vu.exp;
        let (engine, pipelined) = (exp.engine(), exp.pipelined);
        let bias = self.bias(operands[0], fraction)?;
        self.unit.prepare(operands);
        let mut taken = Taken::default();
        let mut start = [0.0; 2];
        let (mut remain, mut multiplied) = (Interval::new(0, 0), false);
        for cycle in 0..=engine.interval + 1 {
            // The pipeline is full of the same operands.
            self.unit.offer(cycle == 0 || pipelined);
            if cycle == 0 {
                start = self.unit.machine.off(self.start)?.bounds();
            }
            let done = self.unit.yes(self.unit.done)?;
            if !multiplied {
                remain = self.unit.machine.value(self.remain).clone();
            }
            if done {
                break;
            }
            let tail = match self.tail {
                Some(tail) => self.unit.yes(tail)?,
                None => false,
            };
            multiplied |= tail;
            let steps = match self.steps {
                Some(enable) => self.unit.yes(enable)? && !tail,
                None => false,
            };
            if steps {
                for index in 0..exp.iterations_per_clock {
                    self.step(index, &mut taken)?;
                }
            }
            self.unit.machine.clock();
        }
        if !self.unit.yes(self.unit.done)? {
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
        let exponent = self.unit.point(self.exponent)?.to_f64()?;
        let fixed = offset.ln_1p() - exponent * LN_2 + (bias - taken.digits.to_f64()?) * unit;
        let left = [-SLACK, SLACK];
        let left = [0, 1].map(|i| left[i] + fixed + start[i] * unit + remain[i] + taken.off[i]);
        let exact = -(operands[0] as f64) * 2f64.powi(-(fraction as i32));
        let exact = 2f64.powi(exp.output_bits as i32) * exact.exp();
        let [least, most] = left.map(|left| exact * left.exp_m1());
        Some(Errors {
            dropped: self.unit.dropped()?,
            method: [least.min(0.0), most.max(0.0)],
        })
    }

    /// What the remainder starts with for the operand 0, or for one of 8 and more:
    /// with its bits, had it the operand 0.
    fn bias(&mut self, operand: i64, fraction: u32) -> Option<f64> {
        let bits = self.unit.config.vu.exp.engine().constant_bits;
        let eight = if operand >> fraction < 8 { 0 } else { 8 };
        self.unit.prepare([eight << fraction; 2]);
        self.unit.offer(true);
        (self.unit.point(self.start)? + (BigInt::from(eight) << bits)).to_f64()
    }

    /// One step: digits of the exponent that it takes, and what the constants that
    /// it may subtract are off.
    fn step(&self, index: u32, taken: &mut Taken) -> Option<()> {
        let exp = &self.unit.config.vu.exp;
        let engine = exp.engine();
        let names = match exp.form {
            ExpForm::Radix4 => vec!["take_one", "take_two", "take_three"],
            _ => vec!["take"],
        };
        let (mut digit, mut off) = (BigInt::zero(), [0.0f64; 2]);
        for (d, name) in multiples(exp.form).zip(names) {
            let take = self.unit.machine.find(&format!("lane0.{name}{index}"))?;
            let (take, constant) = self.compared(take)?;
            let takes = self.unit.yes(take);
            if takes == Some(false) {
                continue;
            }
            let constant = self.unit.point(constant)?;
            if taken.steps < engine.digits {
                takes?;
                digit = constant;
                continue;
            }
            let shifted = self
                .unit
                .machine
                .find(&format!("lane0.accum_shifted{index}"))?;
            let Op::Shr(_, amount) = &self.unit.machine.node(shifted).op else {
                return None;
            };
            let amount = self
                .unit
                .point(self.unit.machine.beside(shifted, *amount))?
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
        match &self.unit.machine.node(id).op {
            Op::Binary(Binary::Le, constant, _) => {
                Some((id, self.unit.machine.beside(id, *constant)))
            }
            Op::Cast(a) => self.compared(self.unit.machine.beside(id, *a)),
            Op::Mux(c, t, e) => {
                let side = if self.unit.yes(self.unit.machine.beside(id, *c))? {
                    t
                } else {
                    e
                };
                self.compared(self.unit.machine.beside(id, *side))
            }
            _ => None,
        }
    }
}

/// Codes from 0 to `last`, cut about where the exponent changes.
pub(super) fn spans(last: i64, fraction: u32, bits: u32) -> Vec<[i64; 2]> {
    let centre = 2f64.powi(-(bits as i32) - 1);
    let ends = (0..=24).map(|k| f64::from(k) * LN_2 + centre);
    let codes = ends.map(|x| (x * 2f64.powi(fraction as i32)).floor() as i64);
    let starts = codes.flat_map(|code| [code - 2, code + 3]);
    super::cut(last, starts.chain([8 << fraction]))
}
