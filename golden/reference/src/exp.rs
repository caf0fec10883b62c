//! The exponential engine in exact integers (paper, Sec. "Vector Unit"):
//! compare and subtract on `R_remain`, shift and add on `R_accum`; and what
//! can stand in its place, straight pieces and radix 4.

use potamoi_formats::config::{Engine, ExpConfig, ExpForm, ExpOutput};
use potamoi_formats::fixed::Format;

use super::logarithms::{ln_one_plus_power, multiple_of_ln2};
use potamoi_formats::units::OpCode;

mod logistic;
mod pieces;
mod radix4;

use pieces::Pieces;
use radix4::Radix4;

/// What the engine holds after its last step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Raw {
    /// `R_accum`, with [`Engine::accumulator_bits`] fraction bits: the
    /// mantissa.
    pub accumulator: i64,
    /// `R_remain` before the tail, with [`Engine::constant_bits`] fraction
    /// bits.
    pub remain: i64,
    /// Binary exponent: the result is `accumulator * 2^exponent`.
    pub exponent: i32,
}

/// The engine of one lane: every bit of it, no clock.
#[derive(Debug, Clone)]
pub struct ExpTwin {
    form: ExpForm,
    output: ExpOutput,
    engine: Engine,
    input: Format,
    tail: bool,
    output_bits: u32,
    one_minus_bits: u32,
    digits: Vec<i64>,
    steps: Vec<(u32, i64)>,
    start: i64,
    start_far: i64,
    start_logarithm: i64,
    /// With an early out, by exponent: iterations that a power takes.
    early: Option<Vec<usize>>,
    other: Option<Other>,
}

/// What finds powers in the restoring engine's place.
#[derive(Debug, Clone)]
enum Other {
    Pieces(Pieces),
    Radix4(Radix4),
}

/// The exponent's bias for one-minus-exp of values of 8 and more.
const FAR_BIAS: u32 = 24;

impl ExpTwin {
    /// The engine that `config` describes, its constants computed here.
    ///
    /// `config` has passed the rules of `potamoi_formats::config`; of one that
    /// has not, nothing is promised but that it does not panic.
    #[must_use]
    pub fn new(config: &ExpConfig) -> Self {
        let mut engine = config.engine();
        engine.accumulator_bits = engine.accumulator_bits.min(40);
        engine.constant_bits = engine.constant_bits.min(40);
        let (n, wc) = (config.iterations.min(31), engine.constant_bits);
        let shifts = match config.form {
            ExpForm::Literal => 0..n,
            _ => 1..n + 1,
        };
        let centre = if engine.centred && wc > n {
            1 << (wc - n - 1)
        } else {
            0
        };
        let biased = |bias: u32| -> i64 {
            let digits = (0..u32::BITS).filter(|j| bias >> j & 1 == 1);
            digits.map(|j| multiple_of_ln2(j, wc)).sum::<i64>() + centre
        };
        let steps: Vec<_> = shifts.map(|i| (i, ln_one_plus_power(i, wc))).collect();
        Self {
            form: config.form,
            output: config.output,
            engine,
            input: config.input,
            tail: config.tail && config.form != ExpForm::Literal,
            output_bits: config.output_bits.min(24),
            one_minus_bits: config.one_minus_frac_bits.min(26),
            digits: (0..engine.digits)
                .rev()
                .map(|j| multiple_of_ln2(j, wc))
                .collect(),
            start_logarithm: Self::logarithm_start(&engine, &steps),
            steps,
            start: biased(engine.bias),
            start_far: biased(FAR_BIAS),
            early: config.early_out.then(|| {
                let iterations = |k| config.clocks_of(k) * config.iterations_per_clock;
                (0..=FAR_BIAS)
                    .map(|k| iterations(k).saturating_sub(engine.digits) as usize)
                    .collect()
            }),
            other: match config.form {
                ExpForm::Piecewise => Some(Other::Pieces(Pieces::new(config))),
                ExpForm::Radix4 => Some(Other::Radix4(Radix4::new(config))),
                ExpForm::Restoring | ExpForm::Literal => None,
            },
        }
    }

    /// The widths in use.
    #[must_use]
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// What the engine holds for operand `a` of the operation `exp`, clamped
    /// to the input format.
    #[must_use]
    pub fn raw(&self, a: i32) -> Raw {
        let code = i64::from(a).clamp(self.input.min() as i64, self.input.max() as i64);
        let value = align(code, self.input.frac_bits(), self.engine.constant_bits);
        match (self.form, self.output) {
            (ExpForm::Literal, _) => self.literal(value),
            (_, ExpOutput::Alpha) => self.falling(value, false),
            (_, ExpOutput::General) => self.restoring(self.start + value, self.engine.bias),
        }
    }

    /// The operation `exp`. Alpha: U0.F, `exp(-a)`; general: {exponent,
    /// mantissa U1.F}; literal: F fraction bits.
    #[must_use]
    pub fn exp(&self, a: i32) -> i32 {
        let raw = self.raw(a);
        let f = self.output_bits;
        let result = match (self.form, self.output) {
            (ExpForm::Literal, _) => self.round(raw.accumulator, 0),
            (_, ExpOutput::Alpha) => self.round(raw.accumulator, -raw.exponent).min((1 << f) - 1),
            (_, ExpOutput::General) => {
                let mantissa = self.round(raw.accumulator, 0);
                let exponent = i64::from(raw.exponent);
                if mantissa >= 1 << (f + 1) {
                    (exponent + 1) << (f + 1) | 1 << f
                } else {
                    exponent << (f + 1) | mantissa
                }
            }
        };
        result as i32
    }

    /// The operation `one-minus-exp`: U0.F, `1 - exp(-a)`, with
    /// `one_minus_frac_bits` fraction bits in `a`, clamped to 0..16.
    #[must_use]
    pub fn one_minus_exp(&self, a: i32) -> i32 {
        let raw = self.raw_one_minus(a);
        let one = 1 << self.output_bits;
        let e = self.round(raw.accumulator, -raw.exponent);
        (one - e).min(one - 1) as i32
    }

    /// What the engine holds for operand `a` of `one-minus-exp`.
    #[must_use]
    pub fn raw_one_minus(&self, a: i32) -> Raw {
        let g = self.one_minus_bits;
        let code = i64::from(a).clamp(0, (16 << g) - 1);
        let value = align(code, g, self.engine.constant_bits);
        self.falling(value, code >= 8 << g)
    }

    /// The exponent k of what the engine finds for operand `a`: the result, or
    /// with one-minus-exp 1 less the result, is `R_accum 2^-k`. 0 of other
    /// operations.
    #[must_use]
    pub fn exponent(&self, op: OpCode, a: i32) -> u32 {
        let raw = match op {
            OpCode::Exp => self.raw(a),
            OpCode::OneMinusExp => self.raw_one_minus(a),
            _ => return 0,
        };
        raw.exponent.min(0).unsigned_abs()
    }

    /// The power of minus a value with the constants' fraction bits; `far` of
    /// 8 and more.
    fn falling(&self, value: i64, far: bool) -> Raw {
        let (start, bias) = if far {
            (self.start_far, FAR_BIAS)
        } else {
            (self.start, self.engine.bias)
        };
        match &self.other {
            Some(Other::Pieces(pieces)) => pieces.raw(value),
            Some(Other::Radix4(radix4)) => radix4.raw(value, bias),
            None => self.restoring(start - value, bias),
        }
    }

    fn restoring(&self, start: i64, bias: u32) -> Raw {
        let mut remain = start;
        let mut taken = 0;
        for &c in &self.digits {
            taken <<= 1;
            if remain >= c {
                remain -= c;
                taken |= 1;
            }
        }
        let mut accumulator =
            (1i64 << self.engine.accumulator_bits) + i64::from(self.engine.offset);
        let k = (bias as i32 - taken).clamp(0, FAR_BIAS as i32) as usize;
        let count = self.early.as_ref().and_then(|early| early.get(k).copied());
        for &(i, c) in self.steps.iter().take(count.unwrap_or(usize::MAX)) {
            if remain >= c {
                remain -= c;
                accumulator += (accumulator >> i) + (accumulator >> (i - 1) & 1);
            }
        }
        if self.tail {
            let product = i128::from(accumulator) * i128::from(remain);
            accumulator += (product >> self.engine.constant_bits) as i64;
        }
        Raw {
            accumulator,
            remain,
            exponent: taken - bias as i32,
        }
    }

    fn literal(&self, start: i64) -> Raw {
        let mut remain = start;
        let mut accumulator = 1i64 << self.engine.accumulator_bits;
        for &(i, c) in &self.steps {
            if remain >= c {
                remain -= c;
                accumulator += accumulator >> i;
            }
        }
        Raw {
            accumulator,
            remain,
            exponent: 0,
        }
    }

    /// `accumulator * 2^-k` with F fraction bits, rounded half-up.
    fn round(&self, accumulator: i64, k: i32) -> i64 {
        let from = i64::from(self.engine.accumulator_bits) + i64::from(k);
        align(accumulator, from.clamp(0, 80) as u32, self.output_bits)
    }
}

/// Brings a code with `from` fraction bits to `to`, rounded half-up.
fn align(code: i64, from: u32, to: u32) -> i64 {
    match from.checked_sub(to) {
        None => code << (to - from).min(32),
        Some(0) => code,
        Some(drop) => {
            let drop = drop.min(62);
            (code + (1 << (drop - 1))) >> drop
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn anchors_of_the_default_engine() {
        let twin = ExpTwin::new(&ExpConfig::default());
        assert_eq!(twin.exp(0), 65_535);
        assert_eq!(twin.exp(i32::MIN), 65_535);
        // exp(-65535 / 8192) * 65536 = 21.98...
        assert_eq!(twin.exp(65_535), 22);
        assert_eq!(twin.exp(i32::MAX), 22);
        // exp(-1) * 65536 = 24109.35.
        assert_eq!(twin.exp(8192), 24_109);
        assert_eq!(twin.one_minus_exp(0), 0);
        assert_eq!(twin.one_minus_exp(-1), 0);
        // exp(-16 + 2^-20) * 65536 = 0.0074.
        assert_eq!(twin.one_minus_exp(i32::MAX), 65_535);
        // 65536 - 21.98 at 8 from either side.
        assert_eq!(twin.one_minus_exp((8 << 20) - 1), 65_514);
        assert_eq!(twin.one_minus_exp(8 << 20), 65_514);
    }

    #[test]
    fn general_results_are_exponent_and_mantissa() {
        let config = ExpConfig {
            output: ExpOutput::General,
            input: Format::signed(3, 12),
            ..ExpConfig::default()
        };
        let twin = ExpTwin::new(&config);
        let value = |x: i32| {
            let code = twin.exp(x);
            f64::from(code & 0x1ffff) * 2f64.powi((code >> 17) - 16)
        };
        assert_eq!(value(0), 1.0);
        for x in [-32_768, -4096, -1, 1, 4096, 32_767] {
            let exact = (f64::from(x) / 4096.0).exp();
            assert!((value(x) / exact - 1.0).abs() < 2f64.powi(-16), "{x}");
        }
    }

    #[test]
    fn unchecked_configurations_do_not_panic() {
        for (accumulator, constants, n, f) in [(0, 0, 0, 60), (90, 90, 90, 0), (3, 60, 31, 24)] {
            let config = ExpConfig {
                accumulator_bits: Some(accumulator),
                constant_bits: Some(constants),
                iterations: n,
                output_bits: f,
                one_minus_frac_bits: 90,
                ..ExpConfig::default()
            };
            let twin = ExpTwin::new(&config);
            for a in [i32::MIN, -1, 0, 1, 40_000, i32::MAX] {
                let _ = (twin.exp(a), twin.one_minus_exp(a));
                let _ = (twin.sigmoid(a), twin.softplus(a));
            }
            for form in [ExpForm::Piecewise, ExpForm::Radix4, ExpForm::Restoring] {
                let twin = ExpTwin::new(&ExpConfig {
                    form,
                    pieces: accumulator * 7,
                    early_out: true,
                    ..config.clone()
                });
                for a in [i32::MIN, -1, 0, 1, 40_000, i32::MAX] {
                    let _ = (twin.exp(a), twin.one_minus_exp(a));
                }
            }
        }
    }
}
