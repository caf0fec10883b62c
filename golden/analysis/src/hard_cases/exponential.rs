//! The exponential at its ends, at each multiple of ln 2, and where rounding is hardest.

use std::f64::consts::LN_2;
use std::sync::Arc;

use potamoi_formats::config::{Config, ExpBase, ExpConfig, ExpForm, ExpOutput};
use potamoi_formats::fixed::Format;
use potamoi_formats::units::OpCode;

use super::{Measuring, Stop, Worst, base_e, cases, codes_of_powers, computes, unless};
use potamoi_reference::exact_exponential::{ExactError, ExactExponential};
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_reference::widths::{Target, budget, target};

cases! {
    "exponential";
    every_operand, "exp of every operand, the smallest among them", "";
    negative_powers, "exp of a negative power", "";
    zero, "exp of 0", "";
    past_the_range, "exp past the range, down to minus infinity", "";
    positive_powers, "exp of a positive power", "";
    multiples_of_ln_2, "exp around each m ln 2", "";
    hardest_to_round, "exp at the hardest codes to round", "[vu.exp]\niterations = 27";
}

/// Unit of errors: the last place of the results.
pub(super) fn ulp(exp: &ExpConfig) -> String {
    format!("ulp of U0.{}", exp.output_bits)
}

/// Largest error of one result of `exp`, in units of its last place, and where the figure comes from:
/// the limit that the form's own widths are chosen for, or the sum of what each rounding may lose.
pub(super) fn accuracy(exp: &ExpConfig) -> (f64, &'static str) {
    let formula = budget(exp);
    let is_own = [exp.accumulator_bits, exp.constant_bits] == [None; 2] && exp.offset.is_none();
    let restoring = is_own && exp.form == ExpForm::Restoring && !exp.early_out;
    match target(exp.iterations, exp.tail, exp.output_bits) {
        Target::Below(limit) if restoring && limit == 1.0 => (limit, "one unit of the format"),
        _ => (
            formula,
            "half a unit, and what truncation, sums and constants lose",
        ),
    }
}

/// An engine under test, and exact values of its operands.
struct Engine<'a> {
    exp: &'a ExpConfig,
    twin: ReferenceExponential,
    exact: Arc<ExactExponential>,
}

impl<'a> Engine<'a> {
    fn of(config: &'a Config) -> Result<Self, Stop> {
        let exp = codes_of_powers(config)?;
        let exact = match ExactExponential::in_base(exp.input, exp.base) {
            Err(wide @ ExactError::TooWide(_)) => {
                return Err(Stop::DoesNotApply(format!("vu.exp.input: {wide}")));
            }
            other => other?,
        };
        Ok(Self {
            exp,
            twin: ReferenceExponential::new(exp),
            exact,
        })
    }

    /// Largest error of some results.
    fn errors(&self, codes: impl Iterator<Item = i32>, results: impl Fn(i32) -> i32) -> Worst {
        let bits = self.exp.output_bits;
        Worst::of(codes.map(|u| self.exact.error(u, results(u), bits)))
    }

    fn ours(&self, codes: impl Iterator<Item = i32>) -> Worst {
        self.errors(codes, |u| self.twin.exp(u))
    }

    /// The largest code of a result.
    const fn most(&self) -> i32 {
        (1 << self.exp.output_bits) - 1
    }

    /// The largest operand, and the value of its last bit times the base's logarithm.
    fn operands(&self) -> (i32, f64) {
        let logarithm = match self.exp.base {
            ExpBase::E => 1.0,
            ExpBase::Two => LN_2,
        };
        let input = self.exp.input;
        (input.max() as i32, input.ulp() * logarithm)
    }

    /// The result for an operand of which only the low bits are wired.
    fn wrapped(&self, u: i32) -> i32 {
        self.twin.exp(u & self.operands().0)
    }

    /// By how much a power of 0 or above may be below the largest code: nothing, if no power is off by
    /// two units.
    fn below_the_largest(&self) -> (f64, &'static str) {
        let off = (accuracy(self.exp).0.ceil() - 2.0).max(0.0);
        (off, "held at the largest code, which is the nearest")
    }
}

/// The recurrence in as many fraction bits as the result has, with each shift truncated and the
/// truncation error not centred.
fn as_narrow_as_the_result(engine: &Engine<'_>, u: i32) -> i32 {
    let (most, unit) = engine.operands();
    let bits = engine.exp.output_bits;
    let one = 2f64.powi(bits as i32);
    let constant = |value: f64| (value * one).round() as i64;
    let mut k = (f64::from(most) * unit / LN_2).ceil() as i64;
    let mut remain = constant(k as f64 * LN_2) - (f64::from(u) * unit * one).floor() as i64;
    let mut digit = 1 << k.ilog2();
    while digit > 0 {
        let step = constant(digit as f64 * LN_2);
        if remain >= step {
            remain -= step;
            k -= digit;
        }
        digit /= 2;
    }
    let mut power = 1i64 << bits;
    for i in 1..=bits {
        let step = constant(2f64.powi(-(i as i32)).ln_1p());
        if remain >= step {
            remain -= step;
            power += power >> i;
        }
    }
    (power >> k).min(i64::from(engine.most())) as i32
}

fn every_operand(under: &Config) -> Measuring {
    let engine = Engine::of(under)?;
    let all = || engine.exact.codes();
    let (bound, from) = accuracy(engine.exp);
    Ok(super::Case {
        naive: format!(
            "the recurrence in {} bits, cut off, not centred",
            engine.exp.output_bits
        )
        .into(),
        unit: ulp(engine.exp).into(),
        fails: engine.errors(all(), |u| as_narrow_as_the_result(&engine, u)),
        bound,
        from: from.into(),
        ours: engine.ours(all()),
    })
}

/// As printed, every logarithm is positive and no subtraction fires below zero.
fn negative_powers(under: &Config) -> Measuring {
    computes(under, OpCode::Exp)?;
    let exp = &under.vu.exp;
    base_e(exp)?;
    let literal = ExpConfig {
        form: ExpForm::Literal,
        input: Format::signed(1, 14),
        output_bits: 14,
        ..ExpConfig::default()
    };
    // -1 to 0, in steps of the operand's format.
    let off = |exp: &ExpConfig| {
        let twin = ReferenceExponential::new(exp);
        let sign = if exp.input.is_signed() { -1 } else { 1 };
        let steps = 1i32 << exp.input.frac_bits().min(20);
        Worst::of((0..=steps).map(|u| {
            let (mantissa, exponent) = twin.floating(sign * u);
            let found = mantissa as f64 * 2f64.powi(exponent - exp.output_bits as i32);
            found - (-f64::from(u) / f64::from(steps)).exp()
        }))
    };
    let is_code = exp.output == ExpOutput::Alpha && exp.form != ExpForm::Literal;
    let (units, from) = match is_code {
        true => accuracy(exp),
        // A mantissa has a unit more than a code below 1.
        false => (2.0, "two units of the format"),
    };
    Ok(super::Case {
        naive: "the recurrence as the paper prints it".into(),
        unit: "absolute".into(),
        fails: off(&literal),
        bound: units.max(1.0) * 2f64.powi(-(exp.output_bits as i32)),
        from: from.into(),
        ours: off(exp),
    })
}

fn zero(under: &Config) -> Measuring {
    let engine = Engine::of(under)?;
    let (bound, from) = engine.below_the_largest();
    let bits = engine.exp.output_bits;
    Ok(super::Case {
        naive: format!("2^{bits} cut to {bits} bits").into(),
        unit: ulp(engine.exp).into(),
        fails: engine.errors(0..1, |_| (1i64 << bits) as i32 & engine.most()),
        bound,
        from: from.into(),
        ours: engine.ours(0..1),
    })
}

fn past_the_range(under: &Config) -> Measuring {
    let engine = Engine::of(under)?;
    let (most, unit) = engine.operands();
    let codes = [1, 2, 4464, most, 15 * (most / 16 + 1), 1 << 29, 1 << 30];
    let codes = codes.map(|more: i32| most.saturating_add(more));
    let one = 2f64.powi(engine.exp.output_bits as i32);
    let off = |exp: &dyn Fn(i32) -> i32| {
        let exact = |u: i32| (-f64::from(u) * unit).exp() * one;
        Worst::of(codes.map(|u| f64::from(exp(u)) - exact(u)))
    };
    let accuracy = accuracy(engine.exp).0;
    Ok(super::Case {
        naive: format!("the operand's low {} bits", engine.exp.input.width()).into(),
        unit: ulp(engine.exp).into(),
        fails: off(&|u| engine.wrapped(u)),
        bound: (-f64::from(most) * unit).exp() * one + accuracy,
        from: "all that is left at the end of the range, and the error of a result".into(),
        ours: off(&|u| engine.twin.exp(u)),
    })
}

fn positive_powers(under: &Config) -> Measuring {
    let engine = Engine::of(under)?;
    let codes = [-1, -2, -8192, -65_535, -65_536, i32::MIN];
    let most = engine.most();
    let off = |exp: &dyn Fn(i32) -> i32| Worst::of(codes.map(|u| f64::from(exp(u) - most)));
    let (bound, from) = engine.below_the_largest();
    Ok(super::Case {
        naive: format!("the operand's low {} bits", engine.exp.input.width()).into(),
        unit: ulp(engine.exp).into(),
        fails: off(&|u| engine.wrapped(u)),
        bound,
        from: from.into(),
        ours: off(&|u| engine.twin.exp(u)),
    })
}

fn multiples_of_ln_2(under: &Config) -> Measuring {
    let engine = Engine::of(under)?;
    base_e(engine.exp)?;
    let (most, unit) = engine.operands();
    let count = (f64::from(most) * unit / LN_2) as i32;
    let codes = || {
        (0..=count).flat_map(|m| {
            let at = (f64::from(m) * LN_2 / unit).round() as i32;
            (at - 2..=at + 2).filter(|u| (0..=most).contains(u))
        })
    };
    // Just below a multiple the quotient is one too large and the remainder wraps.
    let bits = engine.exp.output_bits as i32;
    let naive = |u: i32| {
        let log2_e = (LN_2.recip() * 256.0).ceil() as i64;
        let k = ((i64::from(u) * log2_e) as f64 * unit / 256.0).floor() as i32;
        let r = (u - (f64::from(k) * LN_2 / unit).round() as i32) & most;
        let power = (-f64::from(r) * unit).exp() * 2f64.powi(bits - k);
        power.round().min(f64::from(engine.most())) as i32
    };
    let (bound, from) = accuracy(engine.exp);
    Ok(super::Case {
        naive: "k by log2(e) in 8 bits, the remainder unsigned".into(),
        unit: ulp(engine.exp).into(),
        fails: engine.errors(codes(), naive),
        bound,
        from: format!("{from}, on either side").into(),
        ours: engine.ours(codes()),
    })
}

/// In U3.13, code 15967 lies 2^-16.1 units from a midpoint, closer than 32-bit floats tell.
fn hardest_to_round(under: &Config) -> Measuring {
    let engine = Engine::of(under)?;
    let exp = engine.exp;
    let own = target(exp.iterations, exp.tail, exp.output_bits);
    let is_exact = exp.form == ExpForm::Restoring && own == Target::CorrectlyRounded;
    unless(is_exact && !exp.early_out, || {
        let whole = "27 iterations without a tail make every result the nearest code";
        format!("{} iterations do not promise it: {whole}", exp.iterations)
    })?;
    let unit = engine.operands().1 as f32;
    let one = 2f32.powi(exp.output_bits as i32);
    let float =
        |u: i32| (((-u as f32 * unit).exp() * one).round()).min(engine.most() as f32) as i32;
    let misrounded = |results: &dyn Fn(i32) -> i32| {
        let codes = engine.exact.codes();
        let off = |u: &i32| engine.exact.error(*u, results(*u), exp.output_bits).abs();
        Worst(codes.filter(|u| off(u) > 0.5).count() as f64)
    };
    Ok(super::Case {
        naive: "32-bit floats, rounded".into(),
        unit: format!("operands of {} misrounded", 1u64 << exp.input.width()).into(),
        fails: misrounded(&float),
        bound: 0.0,
        from: format!("{} iterations are correctly rounded", exp.iterations).into(),
        ours: misrounded(&|u| engine.twin.exp(u)),
    })
}

#[test]
fn the_default_engine_is_within_its_budget() {
    let config = Config::paper();
    let Ok(engine) = Engine::of(&config) else {
        unreachable!("the paper's exponential has codes");
    };
    assert!(engine.ours(0..65_536).0 <= budget(&config.vu.exp));
}
