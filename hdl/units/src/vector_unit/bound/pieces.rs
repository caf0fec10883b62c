//! Error bounds of the piecewise form: approximation and dropped bits.

use std::f64::consts::LN_2;

use num_traits::ToPrimitive;
use potamoi_formats::config::{Config, ExpBase};
use potamoi_formats::units::OpCode;
use potamoi_netlist::{Module, Op};

use super::unit::Unit;
use super::{Errors, SLACK};

/// The unit, and the signals under analysis.
pub(super) struct Pieces<'a> {
    unit: Unit<'a>,
    piece: usize,
    start: usize,
    slope: usize,
    exponent: usize,
    /// Factor from the operand to the exponent of two.
    scale: f64,
    /// Logarithm of the base.
    logarithm: f64,
}

impl<'a> Pieces<'a> {
    pub(super) fn new(config: &'a Config, op: OpCode, module: &'a Module) -> Option<Self> {
        let exp = &config.vu.exp;
        let signals = [
            "lane_0.piece",
            "lane_0.piece_start",
            "lane_0.piece_slope",
            "lane_0.s_exponent",
        ];
        let unit = Unit::new(config, op, module, &signals, &["lane_0.power_of_two"])?;
        let machine = &unit.machine;
        let scale = match exp.piece_widths().scale_bits {
            Some(bits) => match machine.op(machine.find("lane_0.LOG2_E")?) {
                Op::Lit(value) => value.to_f64()? * 2f64.powi(-(bits as i32)),
                _ => return None,
            },
            None => 1.0,
        };
        Some(Self {
            piece: machine.find("lane_0.piece")?,
            start: machine.find("lane_0.piece_start")?,
            slope: machine.find("lane_0.piece_slope")?,
            exponent: machine.find("lane_0.s_exponent")?,
            scale,
            logarithm: match exp.base {
                ExpBase::E => 1.0,
                ExpBase::Two => LN_2,
            },
            unit,
        })
    }

    /// Runs an operation on any of these operands; `None` where they are on different pieces.
    pub(super) fn errors(&mut self, operands: [i64; 2], fraction: u32) -> Option<Errors> {
        let exp = &self.unit.config.vu.exp;
        self.unit.prepare(operands);
        for _ in 0..=exp.interval() + 1 {
            // The pipeline is full of the same operands.
            self.unit.offer(true);
            if self.unit.yes(self.unit.done)? {
                break;
            }
            self.unit.machine.clock();
        }
        if !self.unit.yes(self.unit.done)? {
            return None;
        }
        let widths = exp.piece_widths();
        let number = |id: usize, bits: u32| -> Option<f64> {
            Some(self.unit.point(id)?.to_f64()? * 2f64.powi(-(bits as i32)))
        };
        let exponent = number(self.exponent, 0)?;
        let start = number(self.start, exp.engine().accumulator_bits)?;
        let slope = number(self.slope, widths.slope_bits)?;
        let from = exponent - 1.0 + number(self.piece, widths.index_bits)?;
        let power = (-exponent).exp2();
        // The piece, had no bit been dropped, less the power itself.
        let above = |x: f64| {
            let piece = power * (start - slope * (x * self.scale - from));
            piece - (-x * self.logarithm).exp()
        };
        let [low, high] = operands.map(|code| code as f64 * 2f64.powi(-(fraction as i32)));
        // Where both fall alike.
        let fall = power * slope * self.scale / self.logarithm;
        let alike = (-fall.ln() / self.logarithm).clamp(low, high);
        let all = [low, alike, high].map(above);
        let unit = 2f64.powi(exp.output_bits as i32);
        let ends = |of: fn(f64, f64) -> f64| all.into_iter().fold(0.0, of);
        Some(Errors {
            dropped: self.unit.dropped()?,
            method: [
                (ends(f64::min) - SLACK) * unit,
                (ends(f64::max) + SLACK) * unit,
            ],
        })
    }

    /// Codes from 0 to `last`, cut approximately at the ends of pieces.
    pub(super) fn spans(&self, last: i64, fraction: u32) -> Vec<[i64; 2]> {
        let pieces = 2f64.powi(self.unit.config.vu.exp.piece_widths().index_bits as i32);
        let code = |end: u32| f64::from(end) / pieces / self.scale * 2f64.powi(fraction as i32);
        let ends = (1..).map(|end| code(end).floor() as i64);
        let ends = ends.take_while(|code| *code <= last);
        super::cut(last, ends.flat_map(|code| [code - 2, code + 3]))
    }
}
