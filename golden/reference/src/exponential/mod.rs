//! The exponential engine in exact integers (paper, Sec. "Vector Unit"), one file a form.
//!
//! `docs/adding/exponential.md` shows step by step how to add a form.

use std::sync::Arc;

use potamoi_formats::config::{Engine, ExpConfig, ExpForm, ExpOutput};
use potamoi_formats::fixed::Format;
use potamoi_formats::units::OpCode;

mod c_header;
#[cfg(test)]
mod every_input;
mod form;
mod literal;
mod logistic;
mod piecewise;
mod radix4;
mod restoring;

pub use c_header::c_header;
pub use form::Raw;

use form::Form;
use logistic::Logarithm;

/// The form that a configuration selects.
fn form(config: &ExpConfig) -> Arc<dyn Form> {
    match config.form {
        ExpForm::Restoring => Arc::new(restoring::Restoring::new(config)),
        ExpForm::Literal => Arc::new(literal::Literal::new(config)),
        ExpForm::Piecewise => Arc::new(piecewise::Piecewise::new(config)),
        ExpForm::Radix4 => Arc::new(radix4::Radix4::new(config)),
    }
}

/// Bit-exact model of one lane's exponential engine, without timing.
#[derive(Debug, Clone)]
pub struct ReferenceExponential {
    form: Arc<dyn Form>,
    output: ExpOutput,
    engine: Engine,
    input: Format,
    output_bits: u32,
    one_minus_bits: u32,
    logarithm: Logarithm,
}

impl ReferenceExponential {
    /// The engine that `config` describes, with its constants.
    ///
    /// `config` must have passed the rules of `potamoi_formats::config`. For any other, results
    /// are unspecified, but it does not panic.
    #[must_use]
    pub fn new(config: &ExpConfig) -> Self {
        let mut engine = config.engine();
        engine.accumulator_bits = engine.accumulator_bits.min(40);
        engine.constant_bits = engine.constant_bits.min(40);
        Self {
            form: form(config),
            output: config.output,
            engine,
            input: config.input,
            output_bits: config.output_bits.min(24),
            one_minus_bits: config.one_minus_frac_bits.min(26),
            logarithm: Logarithm::new(config, engine),
        }
    }

    /// The widths of the engine's registers.
    #[must_use]
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// The engine's registers after the operation `exp` of `a`, which is clamped to the input
    /// format.
    #[must_use]
    pub fn raw(&self, a: i32) -> Raw {
        let code = i64::from(a).clamp(self.input.min() as i64, self.input.max() as i64);
        let value = align(code, self.input.frac_bits(), self.engine.constant_bits);
        if self.is_signed() {
            self.form.signed_power(value)
        } else {
            self.form.power(value, false)
        }
    }

    /// The operation `exp`. Alpha output: U0.F, `exp(-a)`. General output: {exponent, mantissa
    /// U1.F}. Literal form: F fraction bits.
    #[must_use]
    pub fn exp(&self, a: i32) -> i32 {
        let raw = self.raw(a);
        let f = self.output_bits;
        let result = match self.output {
            _ if self.form.is_bare() => self.round(raw.accumulator, 0),
            ExpOutput::Alpha => self.round(raw.accumulator, -raw.exponent).min((1 << f) - 1),
            ExpOutput::General => {
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

    /// The result of `exp` as a mantissa with F fraction bits and a binary exponent, 0 but for the
    /// general output.
    #[must_use]
    pub fn floating(&self, a: i32) -> (i64, i32) {
        let (word, bits) = (self.exp(a), self.output_bits + 1);
        match self.output {
            ExpOutput::General if !self.form.is_bare() => {
                (i64::from(word) & ((1 << bits) - 1), word >> bits)
            }
            _ => (word.into(), 0),
        }
    }

    /// The operation `one-minus-exp`: U0.F, `1 - exp(-a)`. `a` has `one_minus_frac_bits` fraction
    /// bits and is clamped to 0..16.
    #[must_use]
    pub fn one_minus_exp(&self, a: i32) -> i32 {
        let raw = self.raw_one_minus(a);
        let one = 1 << self.output_bits;
        let e = self.round(raw.accumulator, -raw.exponent);
        (one - e).min(one - 1) as i32
    }

    /// The largest operand `a` such that `one-minus-exp` gives 0 to `least` for every operand from 0 to `a`; -1
    /// if it does not for 0.
    #[must_use]
    pub fn largest_depth(&self, least: i32) -> i32 {
        let mut codes = 0..16 << self.one_minus_bits;
        let beyond = codes.find(|a| !(0..=least).contains(&self.one_minus_exp(*a)));
        beyond.map_or(i32::MAX, |first| first - 1)
    }

    /// The engine's registers after the operation `one-minus-exp` of `a`.
    #[must_use]
    pub(crate) fn raw_one_minus(&self, a: i32) -> Raw {
        let g = self.one_minus_bits;
        let code = i64::from(a).clamp(0, (16 << g) - 1);
        let value = align(code, g, self.engine.constant_bits);
        self.form.power(value, code >= 8 << g)
    }

    /// The binary exponent k for operand `a`: the result, or with one-minus-exp 1 less the result,
    /// is `R_accum 2^-k`. It is 0 for all other operations.
    #[must_use]
    pub fn exponent(&self, op: OpCode, a: i32) -> u32 {
        let raw = match op {
            OpCode::Exp => self.raw(a),
            OpCode::OneMinusExp => self.raw_one_minus(a),
            _ => return 0,
        };
        raw.exponent.min(0).unsigned_abs()
    }

    /// Whether the operand is the exponent itself, and not less it.
    fn is_signed(&self) -> bool {
        self.form.is_bare() || self.output == ExpOutput::General
    }

    /// `accumulator * 2^-k` with F fraction bits, rounded half-up.
    fn round(&self, accumulator: i64, k: i32) -> i64 {
        let from = i64::from(self.engine.accumulator_bits) + i64::from(k);
        align(accumulator, from.clamp(0, 80) as u32, self.output_bits)
    }
}

/// Converts a code from `from` to `to` fraction bits, rounded half-up.
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
        let twin = ReferenceExponential::new(&ExpConfig::default());
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
        let twin = ReferenceExponential::new(&config);
        let value = |x: i32| {
            let code = twin.exp(x);
            f64::from(code & 0x1ffff) * 2f64.powi((code >> 17) - 16)
        };
        assert_eq!(value(0), 1.0);
        for x in [-32_768, -4096, -1, 1, 4096, 32_767] {
            let exact = (f64::from(x) / 4096.0).exp();
            assert!((value(x) / exact - 1.0).abs() < 2f64.powi(-16), "{x}");
            let (mantissa, exponent) = twin.floating(x);
            assert_eq!(mantissa as f64 * 2f64.powi(exponent - 16), value(x));
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
            let twin = ReferenceExponential::new(&config);
            for a in [i32::MIN, -1, 0, 1, 40_000, i32::MAX] {
                let _ = (twin.exp(a), twin.one_minus_exp(a));
                let _ = (twin.sigmoid(a), twin.softplus(a));
            }
            for &form in ExpForm::ALL {
                let twin = ReferenceExponential::new(&ExpConfig {
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
