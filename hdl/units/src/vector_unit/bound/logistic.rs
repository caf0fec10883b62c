//! Error bounds of sigmoid and softplus: an exponential, a logarithm, and for sigmoid another
//! exponential.
//!
//! Each pass is exact for an operand with the error of the passes before, so that sums of exponents
//! are tracked: `e = exp(-|x| + g)`, then `p = max(y, 0) + ln(1 + e) + m`, then `exp(-p + g)`.

use std::f64::consts::LN_2;

use num_bigint::BigInt;
use num_traits::ToPrimitive;
use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;
use potamoi_netlist::{Binary, Interval, Module, Op, Unary};

use super::recurrence::{self, Recurrence};
use super::{Errors, SLACK};
use crate::vector_unit::exponential::constants::less_than_log;

/// Operands saturate at plus and minus this value.
const HOLDS: f64 = 16.0;
/// Parts of each range of one exponent.
const PARTS: i64 = 8;

/// The unit, and the signals under analysis.
pub(super) struct Passes<'a> {
    recurrence: Recurrence<'a>,
    /// Source of a power's size: the bias.
    from: usize,
    /// Remainder before the steps.
    remain: usize,
    accum: usize,
    /// Register of the accumulator.
    held: usize,
    /// Sum that softplus rounds.
    sum: usize,
}

/// State of a logarithm in the registers.
struct Logarithm {
    steps: u32,
    /// Its initial constant minus that of exact arithmetic.
    start: f64,
    /// Smallest and largest excess of logarithms over the subtracted constants.
    off: [f64; 2],
    /// Lower bound of the accumulator.
    least: f64,
}

impl<'a> Passes<'a> {
    pub(super) fn new(config: &'a Config, op: OpCode, module: &'a Module) -> Option<Self> {
        let recurrence = Recurrence::new(config, op, module)?;
        let machine = &recurrence.unit.machine;
        let start = machine.find("lane_0.depth_remain")?;
        let Op::Binary(Binary::Sub, from, _) = machine.op(start) else {
            return None;
        };
        Some(Self {
            from: machine.beside(start, *from),
            remain: machine.find("lane_0.remain_now")?,
            accum: machine.find("lane_0.accum_now")?,
            held: machine.find("lane_0.r_accum")?,
            sum: machine.find("lane_0.softplus")?,
            recurrence,
        })
    }

    /// Codes from -16 to 16, cut approximately where the exponent changes, and in between.
    pub(super) fn spans(&self, fraction: u32, bits: u32) -> Vec<[i64; 2]> {
        let end = (HOLDS as i64) << fraction;
        let mut all = vec![[-end, -end], [end, end]];
        for [low, high] in recurrence::spans(end - 1, fraction, bits) {
            let step = ((high - low) / PARTS).max(1);
            let mut at = low;
            while at <= high {
                let last = (at + step - 1).min(high);
                all.push([at, last]);
                // 0 has no sign.
                if last > 0 {
                    all.push([-last, -at.max(1)]);
                }
                at = last + 1;
            }
        }
        all
    }

    /// Runs an operation on any of these operands, all of one sign; `None` where they lead to
    /// different exponents.
    pub(super) fn errors(
        &mut self,
        op: OpCode,
        operands: [i64; 2],
        fraction: u32,
    ) -> Option<Errors> {
        let exp = &self.recurrence.unit.config.vu.exp;
        let (engine, output) = (exp.engine(), 2f64.powi(exp.output_bits as i32));
        let [low, high] = operands.map(|code| code as f64 * 2f64.powi(-(fraction as i32)));
        let sizes = if low < 0.0 {
            [-high, -low]
        } else {
            [low, high]
        };
        // Two's complement.
        let raw = operands.map(|code| if low < 0.0 { code + (1 << 32) } else { code });
        self.recurrence.unit.prepare(raw);

        let power = self.power(exp.interval(), true)?;
        let last = HOLDS - 2f64.powi(-(fraction as i32));
        let power = [power[0], power[1] + (sizes[1] - last).max(0.0)];
        // d ln(1 + e) / d ln e, at the largest e.
        let e = (power[1].max(0.0) - sizes[0]).exp();
        let slope = e / (1.0 + e);
        let log = self.logarithm(exp.power_pipeline().turn())?;
        let [least, most] = [
            power[0].min(0.0) * slope + log[0],
            power[1].max(0.0) * slope + log[1],
        ];
        if op == OpCode::Softplus {
            return self.ends([least * output, most * output]);
        }
        let softplus = |y: f64| y.max(0.0) + (-y.abs()).exp().ln_1p();
        self.narrow([softplus(-high) + least, softplus(-low) + most])?;
        let again = self.power(exp.interval(), false)?;
        let held = softplus(-low) - (HOLDS - 2f64.powi(-(engine.constant_bits as i32)));
        let left = [again[0] - most, again[1] - least + held.max(0.0)];
        let exact = output * (-softplus(-high)).exp();
        self.ends(left.map(|left| exact * left.exp_m1()))
    }

    /// Narrows the sum to these bounds without dropped bits, closer than intervals, which ignore
    /// the correlation of a step's product and difference.
    fn narrow(&mut self, [least, most]: [f64; 2]) -> Option<()> {
        let unit = &mut self.recurrence.unit;
        let ulps = 2f64.powi(unit.config.vu.exp.engine().constant_bits as i32);
        let off = unit.machine.off(self.sum)?;
        let [low, high] = [
            (least * ulps + off[0]).floor(),
            (most * ulps + off[1]).ceil(),
        ];
        unit.machine
            .narrow(self.sum, &Interval::new(low as i64, high as i64))
    }

    /// Errors of the completed result.
    fn ends(&self, method: [f64; 2]) -> Option<Errors> {
        let unit = &self.recurrence.unit;
        Some(Errors {
            dropped: unit
                .dropped()
                .filter(|_| unit.yes(unit.done) == Some(true))?,
            method: [method[0].min(0.0), method[1].max(0.0)],
        })
    }

    /// Runs the pass of an exponential, of the operand or of the registers' content, up to the
    /// first cycle after it.
    fn power(&mut self, clocks: u32, of_operand: bool) -> Option<[f64; 2]> {
        if of_operand {
            self.recurrence.unit.offer(true);
        }
        let bias = self.recurrence.unit.point(self.from)?.to_f64()?;
        let mut power = self.recurrence.begin(bias)?;
        for _ in 0..clocks {
            self.recurrence.look(&mut power);
            self.recurrence.follow(&mut power)?;
            self.recurrence.unit.machine.clock();
            self.recurrence.unit.offer(false);
        }
        self.recurrence.look(&mut power);
        self.recurrence.left(&power)
    }

    /// Runs the pass of the logarithm. Returns its excess over `ln(1 + e)`.
    fn logarithm(&mut self, clocks: u32) -> Option<[f64; 2]> {
        let exp = &self.recurrence.unit.config.vu.exp;
        let (engine, clock) = (exp.engine(), exp.iterations_per_clock);
        let [unit, last] =
            [engine.constant_bits, engine.accumulator_bits].map(|bits| 2f64.powi(-(bits as i32)));
        let machine = &self.recurrence.unit.machine;
        let start = self.recurrence.unit.point(self.remain)?;
        // It is below 0.
        let lap = BigInt::from(1) << machine.ty(self.remain).width;
        let mut log = Logarithm {
            steps: 0,
            start: (start - lap).to_f64()? * unit - (LN_2 - 1.0),
            off: [0.0; 2],
            least: machine.value(self.accum).low.to_f64()? * last,
        };
        for _ in 0..clocks {
            for index in 0..clock {
                self.step(index, &mut log)?;
            }
            self.recurrence.unit.machine.clock();
            self.recurrence.unit.offer(false);
        }
        // Without dropped bits: A / 2 - 1 in place of ln(A / 2).
        let machine = &self.recurrence.unit.machine;
        let off = machine.off(self.held)?;
        let ends = [
            log.least / last - off[1],
            machine.value(self.held).high.to_f64()? - off[0],
        ];
        let first_order = ends.map(|a| {
            let half = a * last / 2.0;
            half - 1.0 - half.ln()
        });
        let [least, most] = log.off.map(|off| off + log.start);
        Some([
            least - SLACK,
            most + first_order[0].max(first_order[1]) + SLACK,
        ])
    }

    /// One step of a logarithm: it multiplies where the product stays below 2.
    fn step(&self, index: u32, log: &mut Logarithm) -> Option<()> {
        let unit = &self.recurrence.unit;
        let (machine, engine) = (&unit.machine, unit.config.vu.exp.engine());
        let take = machine.find(&format!("lane_0.take{index}"))?;
        let constant = self.constant(take, index)?;
        let takes = unit.yes(take);
        let is_digit = log.steps < engine.digits;
        log.steps += 1;
        if is_digit || log.steps > engine.steps {
            return (takes == Some(false)).then_some(());
        }
        let amount = self.recurrence.amount(index)?;
        let less = less_than_log(&unit.point(constant)?, engine.constant_bits, 1, amount);
        log.off = match takes {
            Some(true) => log.off.map(|off| off + less),
            Some(false) => log.off,
            None => [log.off[0] + less.min(0.0), log.off[1] + less.max(0.0)],
        };
        // Products are rounded by half a unit.
        let half = 2f64.powi(-(engine.accumulator_bits as i32) - 1);
        let factor = 1.0 + 2f64.powi(-(amount as i32));
        let taken = log.least * factor - half;
        let kept = log.least.max((2.0 - half) / factor);
        log.least = match takes {
            Some(true) => taken,
            Some(false) => kept,
            None => taken.min(kept),
        };
        Some(())
    }

    /// The constant subtracted by a step, if the step is taken exactly where neither the sum nor
    /// its source has its top bit set.
    fn constant(&self, take: usize, index: u32) -> Option<usize> {
        let machine = &self.recurrence.unit.machine;
        let at = |node: usize, n: &usize| machine.beside(node, *n);
        let Op::Mux(_, below, compared) = machine.op(take) else {
            return None;
        };
        let below = at(take, below);
        let Op::Unary(Unary::Not, past) = machine.op(below) else {
            return None;
        };
        let past = at(below, past);
        let Op::Binary(Binary::Or, sum, before) = machine.op(past) else {
            return None;
        };
        let top = |bit: usize| match machine.op(bit) {
            Op::Slice(of, low) if machine.ty(at(bit, of)).width == low + 1 => Some(at(bit, of)),
            _ => None,
        };
        let grown = machine.find(&format!("lane_0.accum_grown{index}"))?;
        let before = top(at(past, before))?;
        let grows = machine.ty(grown) == machine.ty(before);
        let is_known = top(at(past, sum))? == grown && grows;
        match machine.op(at(take, compared)) {
            Op::Binary(Binary::Le, constant, _) if is_known => {
                Some(at(at(take, compared), constant))
            }
            _ => None,
        }
    }
}
