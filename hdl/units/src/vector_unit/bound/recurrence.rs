//! Error bounds of the recurrence: method and dropped bits.

use std::f64::consts::LN_2;

use num_bigint::BigInt;
use num_traits::{ToPrimitive, Zero};
use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;
use potamoi_netlist::{Binary, Interval, Module, Op};

use super::unit::Unit;
use super::{Errors, SLACK};
use crate::vector_unit::exponential::constants::{less_than_log, multiples};
use crate::vector_unit::exponential::form;

/// Known facts of a power in the registers.
pub(super) struct Power {
    /// Initial remainder for the operand 0, with the bias used for this power's operand.
    bias: f64,
    /// Smallest and largest error of the start.
    start: [f64; 2],
    remain: Interval,
    multiplied: bool,
    taken: Subtracted,
}

/// Amount subtracted from the remainder by steps.
#[derive(Default)]
struct Subtracted {
    steps: u32,
    /// By the exponent's digits, with the constants' fraction bits.
    digits: BigInt,
    /// Smallest and largest total excess of logarithms over the other constants.
    off: [f64; 2],
}

/// The unit, and the signals under analysis.
pub(super) struct Recurrence<'a> {
    pub(super) unit: Unit<'a>,
    start: usize,
    remain: usize,
    exponent: usize,
    /// Enable of steps, and of the final multiplication, in the iterative form.
    steps: Option<usize>,
    tail: Option<usize>,
}

impl<'a> Recurrence<'a> {
    pub(super) fn new(config: &'a Config, op: OpCode, module: &'a Module) -> Option<Self> {
        let exp = &config.vu.exp;
        let last = exp.power_pipeline().turn() - 1;
        let remain = if exp.pipelined {
            format!("lane_0.s_remain_{last}")
        } else {
            "lane_0.r_remain".to_owned()
        };
        let signals = ["lane_0.remain_start", &remain, "lane_0.exponent"];
        let unit = Unit::new(config, op, module, &signals, &[])?;
        let machine = &unit.machine;
        let remain = machine.find(&remain)?;
        let steps = match machine.op(remain) {
            Op::Reg { enable, .. } => enable.map(|e| machine.beside(remain, e)),
            _ => return None,
        };
        Some(Self {
            start: machine.find("lane_0.remain_start")?,
            remain,
            exponent: machine.find("lane_0.exponent")?,
            steps,
            tail: machine.find("lane_0.tail"),
            unit,
        })
    }

    /// Runs an operation on any of these operands; `None` where they lead to different exponents or
    /// clocks.
    pub(super) fn errors(&mut self, operands: [i64; 2], fraction: u32) -> Option<Errors> {
        let exp = &self.unit.config.vu.exp;
        let (stages, pipelined) = (exp.power_pipeline(), exp.pipelined);
        let bias = self.bias(operands[0], fraction)?;
        self.unit.prepare(operands);
        self.unit.offer(true);
        let mut power = self.begin(bias)?;
        for cycle in 0..=stages.cycles() + 1 {
            if cycle > 0 {
                // The pipeline is full of the same operands.
                self.unit.offer(pipelined);
            }
            let done = self.unit.yes(self.unit.done)?;
            self.look(&mut power);
            if done {
                break;
            }
            self.follow(&mut power)?;
            self.unit.machine.clock();
        }
        if !self.unit.yes(self.unit.done)? {
            return None;
        }
        if pipelined {
            for index in 0..stages.turn() * exp.iterations_per_clock {
                self.step(index, &mut power.taken)?;
            }
        }
        let left = self.left(&power)?;
        let exact = -(operands[0] as f64) * 2f64.powi(-(fraction as i32));
        let exact = 2f64.powi(exp.output_bits as i32) * exact.exp();
        let [least, most] = left.map(|left| exact * left.exp_m1());
        Some(Errors {
            dropped: self.unit.dropped()?,
            method: [least.min(0.0), most.max(0.0)],
        })
    }

    /// The power that begins in this cycle.
    pub(super) fn begin(&self, bias: f64) -> Option<Power> {
        Some(Power {
            bias,
            start: self.unit.machine.off(self.start)?,
            remain: Interval::new(0, 0),
            multiplied: false,
            taken: Subtracted::default(),
        })
    }

    /// Records the remainder; the final multiplication replaces further steps.
    pub(super) fn look(&self, power: &mut Power) {
        if !power.multiplied {
            power.remain = self.unit.machine.value(self.remain).clone();
        }
    }

    /// Records this cycle's subtractions from the remainder.
    pub(super) fn follow(&self, power: &mut Power) -> Option<()> {
        let tail = match self.tail {
            Some(tail) => self.unit.yes(tail)?,
            None => false,
        };
        power.multiplied |= tail;
        let steps = match self.steps {
            Some(enable) => self.unit.yes(enable)? && !tail,
            None => false,
        };
        if steps {
            for index in 0..self.unit.config.vu.exp.iterations_per_clock {
                self.step(index, &mut power.taken)?;
            }
        }
        Some(())
    }

    /// Smallest and largest g, where the registers hold `exp(-x + g)` of an operand x, without
    /// dropped bits.
    pub(super) fn left(&self, power: &Power) -> Option<[f64; 2]> {
        let exp = &self.unit.config.vu.exp;
        let engine = exp.engine();
        let unit = 2f64.powi(-(engine.constant_bits as i32));
        let [least, most] = [&power.remain.low, &power.remain.high].map(|v| v.to_f64());
        let [least, most] = [least? * unit, most? * unit];
        let remain = if exp.tail {
            // The product takes 1 + r for exp(r).
            [most.ln_1p() - most, 0.0]
        } else {
            [-most, -least]
        };
        let taken = &power.taken;
        let offset = f64::from(engine.offset) * 2f64.powi(-(engine.accumulator_bits as i32));
        let exponent = self.unit.point(self.exponent)?.to_f64()?;
        let fixed = offset.ln_1p() - exponent * LN_2 + (power.bias - taken.digits.to_f64()?) * unit;
        let slack = [-SLACK, SLACK];
        Some([0, 1].map(|i| slack[i] + fixed + power.start[i] * unit + remain[i] + taken.off[i]))
    }

    /// Initial remainder for the operand 0, with the bias used for this power's operand.
    fn bias(&mut self, operand: i64, fraction: u32) -> Option<f64> {
        let bits = self.unit.config.vu.exp.engine().constant_bits;
        let eight = if operand >> fraction < 8 { 0 } else { 8 };
        self.unit.prepare([eight << fraction; 2]);
        self.unit.offer(true);
        (self.unit.point(self.start)? + (BigInt::from(eight) << bits)).to_f64()
    }

    /// One step: its digit of the exponent, and the errors of the constants that it may subtract.
    fn step(&self, index: u32, taken: &mut Subtracted) -> Option<()> {
        let exp = &self.unit.config.vu.exp;
        let engine = exp.engine();
        let own = form(exp).recurrence()?;
        let names = match own.radix_bits() {
            1 => vec!["take"],
            _ => vec!["take_one", "take_two", "take_three"],
        };
        let (mut digit, mut off) = (BigInt::zero(), [0.0f64; 2]);
        for (d, name) in multiples(own).zip(names) {
            let take = self.unit.machine.find(&format!("lane_0.{name}{index}"))?;
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
            let amount = self.amount(index)?;
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

    /// Shift amount of the accumulator in a step.
    pub(super) fn amount(&self, index: u32) -> Option<u32> {
        let machine = &self.unit.machine;
        let shifted = machine.find(&format!("lane_0.accum_shifted{index}"))?;
        match machine.op(shifted) {
            Op::Shr(_, amount) => self.unit.point(machine.beside(shifted, *amount))?.to_u32(),
            Op::Round(_, amount, _) => Some(*amount),
            _ => None,
        }
    }

    /// The comparison behind a decision: both compared nodes.
    fn compared(&self, id: usize) -> Option<(usize, usize)> {
        match self.unit.machine.op(id) {
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

/// Codes from 0 to `last`, cut approximately where the exponent changes.
pub(super) fn spans(last: i64, fraction: u32, bits: u32) -> Vec<[i64; 2]> {
    let centre = 2f64.powi(-(bits as i32) - 1);
    let ends = (0..=24).map(|k| f64::from(k) * LN_2 + centre);
    let codes = ends.map(|x| (x * 2f64.powi(fraction as i32)).floor() as i64);
    let starts = codes.flat_map(|code| [code - 2, code + 3]);
    super::cut(last, starts.chain([8 << fraction]))
}
