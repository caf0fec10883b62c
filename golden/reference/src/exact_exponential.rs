//! Exponentials to at least 120 bits, and the errors of a unit against them.
//!
//! The values come from a library of arbitrary precision, not from the engine's arithmetic. Of the
//! 65,536 arguments of U3.13 the hardest to round lies 2^-16 units from a midpoint of U0.16 and
//! 2^-21 units from one of U0.12, so 2^-120 leaves no case undecided.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use astro_float::{BigFloat, Consts, RoundingMode};
use potamoi_formats::config::ExpBase;
use potamoi_formats::fixed::Format;
use thiserror::Error;

/// Fraction bits of a stored mantissa.
const MANTISSA_BITS: i32 = 126;
/// Fraction bits of errors, in units of the last place of the output.
pub(super) const ERROR_BITS: i32 = 80;
/// Bits of the library's numbers during the computation.
pub(super) const WORKING_BITS: usize = 192;

/// The reference cannot be computed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ExactError {
    /// The format has too many codes to tabulate.
    #[error("input format {0} has too many codes to tabulate: expected at most {most} bits", most = ExactExponential::MOST_BITS)]
    TooWide(Format),
    /// The library of arbitrary precision failed.
    #[error("cannot compute exponentials to {WORKING_BITS} bits: {0}")]
    Library(String),
}

/// The exponential of every code of a format: `exp(-u)` of an unsigned one,
/// `exp(x)` of a signed one.
#[derive(Debug)]
pub struct ExactExponential {
    input: Format,
    /// Mantissa in [1, 2) with [`MANTISSA_BITS`] fraction bits, exponent.
    values: Vec<(u128, i32)>,
}

/// Error statistics of an output against the reference, over all codes of the input format.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpError {
    /// Largest magnitude of an error, in units of the output's last place.
    pub max_ulp: f64,
    /// Mean magnitude of the error, in the same units.
    pub mean: f64,
    /// Root of the mean squared error, in the same units.
    pub rms: f64,
    /// Mean signed error, in the same units.
    pub bias: f64,
    /// The first code with the largest error.
    pub worst_code: i32,
    /// Whether the outputs are monotone in the argument, as the exponential is.
    pub monotone: bool,
    /// Number of outputs that are not the nearest code.
    pub misrounded: u32,
}

static CACHE: Mutex<BTreeMap<(Format, ExpBase), Arc<ExactExponential>>> =
    Mutex::new(BTreeMap::new());

impl ExactExponential {
    /// Most bits of an input format.
    pub const MOST_BITS: u32 = 20;

    /// The reference for an input format of at most 20 bits, computed once a process.
    ///
    /// # Errors
    /// The format is wider than 20 bits, or the library fails.
    pub fn of(input: Format) -> Result<Arc<Self>, ExactError> {
        Self::in_base(input, ExpBase::E)
    }

    /// As [`ExactExponential::of`], with `2^-u` and `2^x` if the base is two.
    ///
    /// # Errors
    /// Those of [`ExactExponential::of`].
    pub fn in_base(input: Format, base: ExpBase) -> Result<Arc<Self>, ExactError> {
        let mut cache = CACHE.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = cache.get(&(input, base)) {
            return Ok(Arc::clone(known));
        }
        let made = Arc::new(Self::make(input, base)?);
        cache.insert((input, base), Arc::clone(&made));
        Ok(made)
    }

    fn make(input: Format, base: ExpBase) -> Result<Self, ExactError> {
        if input.width() > Self::MOST_BITS {
            return Err(ExactError::TooWide(input));
        }
        let mut consts = Consts::new().map_err(|e| ExactError::Library(e.to_string()))?;
        let sign = if input.is_signed() { 1.0 } else { -1.0 };
        let unit = sign * input.ulp();
        let logarithm = match base {
            ExpBase::E => BigFloat::from_f64(1.0, WORKING_BITS),
            ExpBase::Two => consts.ln_2(WORKING_BITS, RoundingMode::ToEven),
        };
        // Arguments of at most 20 bits are exact in 64-bit floating point.
        let mut exp = |code: i128| {
            BigFloat::from_f64(code as f64 * unit, WORKING_BITS)
                .mul(&logarithm, WORKING_BITS, RoundingMode::ToEven)
                .exp(WORKING_BITS, RoundingMode::ToEven, &mut consts)
        };
        let count = 1usize << input.width();
        let fine: Vec<_> = (0..256.min(count as i128)).map(&mut exp).collect();
        let mut values = Vec::with_capacity(count);
        for block in (input.min()..=input.max()).step_by(256) {
            let coarse = exp(block);
            for fine in &fine {
                let value = coarse.mul(fine, WORKING_BITS, RoundingMode::ToEven);
                values.push(
                    parts(&value).ok_or_else(|| {
                        ExactError::Library(format!("exp near {block} is {value}"))
                    })?,
                );
            }
        }
        Ok(Self { input, values })
    }

    /// The format of the arguments.
    #[must_use]
    pub fn input(&self) -> Format {
        self.input
    }

    /// Every code of the format, smallest first.
    pub fn codes(&self) -> impl Iterator<Item = i32> + use<> {
        let least = self.input.min() as i32;
        least..=self.input.max() as i32
    }

    /// The value for a code (clamped to the format): a mantissa in [1, 2) with 126 fraction bits,
    /// truncated, and a binary exponent.
    #[must_use]
    pub fn value(&self, code: i32) -> (u128, i32) {
        let held = self.input.saturate(i128::from(code)).0;
        let index = (held - self.input.min()) as usize;
        self.values.get(index).copied().unwrap_or((0, 0))
    }

    /// The value for a code in units of 2^-`output_bits`, with 80 more fraction bits, truncated.
    /// An unsigned input format caps it at the largest code, `2^output_bits - 1`. Values of 2^46
    /// units and more return 2^126.
    #[must_use]
    pub fn scaled(&self, code: i32, output_bits: u32) -> i128 {
        let (mantissa, exponent) = self.value(code);
        let shift = MANTISSA_BITS - ERROR_BITS - output_bits as i32 - exponent;
        let exact = match shift {
            ..0 => 1 << 126,
            127.. => 0,
            _ => (mantissa >> shift) as i128,
        };
        if self.input.is_signed() {
            exact
        } else {
            exact.min(((1 << output_bits.min(40)) - 1) << ERROR_BITS)
        }
    }

    /// Signed error of `output`, a code with `output_bits` fraction bits, in units of its last
    /// place.
    #[must_use]
    pub fn error(&self, code: i32, output: i32, output_bits: u32) -> f64 {
        let off = (i128::from(output) << ERROR_BITS) - self.scaled(code, output_bits);
        off as f64 * 2f64.powi(-ERROR_BITS)
    }

    /// Signed error of `mantissa 2^(exponent - mantissa_bits)`, in units of `2^-mantissa_bits` of the
    /// value's own power of two.
    #[must_use]
    pub fn floating_error(
        &self,
        code: i32,
        (mantissa, exponent): (i64, i32),
        mantissa_bits: u32,
    ) -> f64 {
        let (exact, own) = self.value(code);
        // Both in units of 2^-ERROR_BITS of the last place, at the value's power of two.
        let dropped = MANTISSA_BITS - ERROR_BITS - mantissa_bits.min(40) as i32;
        let exact = (exact >> dropped) as i128;
        // What is farther off than some powers of two is only large.
        let apart = (exponent - own).clamp(-ERROR_BITS, 20);
        let found = i128::from(mantissa) << (ERROR_BITS + apart);
        (found - exact) as f64 * 2f64.powi(-ERROR_BITS)
    }

    /// Measures `output` against the reference. It is called once for every code, smallest first.
    /// An unsigned input format caps the reference at `2^output_bits - 1`: 1 saturates.
    pub fn measure(&self, output_bits: u32, mut output: impl FnMut(i32) -> i32) -> ExpError {
        let results = self.codes().map(|code| {
            let found = output(code);
            let off = self.error(code, found, output_bits);
            (code, off, f64::from(found))
        });
        ExpError::of(results, !self.input.is_signed())
    }

    /// As [`ExactExponential::measure`], of results that are a mantissa with `mantissa_bits` fraction
    /// bits and a binary exponent. Errors are those of [`ExactExponential::floating_error`].
    pub fn measure_floating(
        &self,
        mantissa_bits: u32,
        mut output: impl FnMut(i32) -> (i64, i32),
    ) -> ExpError {
        let results = self.codes().map(|code| {
            let (mantissa, exponent) = output(code);
            let off = self.floating_error(code, (mantissa, exponent), mantissa_bits);
            (code, off, mantissa as f64 * 2f64.powi(exponent))
        });
        ExpError::of(results, !self.input.is_signed())
    }
}

impl ExpError {
    /// Statistics of errors: each with its code and the result, in the order of codes. `falls`: exact
    /// results fall.
    pub(super) fn of(results: impl Iterator<Item = (i32, f64, f64)>, falls: bool) -> Self {
        let mut error = Self {
            max_ulp: 0.0,
            mean: 0.0,
            rms: 0.0,
            bias: 0.0,
            worst_code: 0,
            monotone: true,
            misrounded: 0,
        };
        let (mut count, mut before) = (0u32, None);
        for (code, off, found) in results {
            error.mean += off.abs();
            error.rms += off * off;
            error.bias += off;
            if count == 0 || off.abs() > error.max_ulp {
                error.max_ulp = off.abs();
                error.worst_code = code;
            }
            error.misrounded += u32::from(off.abs() > 0.5);
            error.monotone &= before.is_none_or(|b| if falls { found <= b } else { found >= b });
            before = Some(found);
            count += 1;
        }
        let count = f64::from(count.max(1));
        error.mean /= count;
        error.rms = (error.rms / count).sqrt();
        error.bias /= count;
        error
    }
}

/// Mantissa and exponent of a positive number.
pub fn parts(value: &BigFloat) -> Option<(u128, i32)> {
    // The library's mantissa is in [1/2, 1), its words lowest first.
    let (words, _, _, exponent, _) = value.as_raw_parts()?;
    let bits = astro_float::WORD_BIT_SIZE as u32;
    let mut top = 0u128;
    for &word in words.iter().rev().take((128 / bits) as usize) {
        top = top << bits | u128::from(word);
    }
    (top >> 127 == 1).then_some((top >> 1, exponent - 1))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn values_agree_with_floating_point() {
        for text in ["U3.13", "S3.12", "S0.15", "U1.7", "S6.9"] {
            let format: Format = text.parse().unwrap();
            let reference = ExactExponential::of(format).unwrap();
            let sign = if format.is_signed() { 1.0 } else { -1.0 };
            let mut count = 0;
            for code in reference.codes() {
                let (mantissa, exponent) = reference.value(code);
                let found = mantissa as f64 * 2f64.powi(exponent - MANTISSA_BITS);
                let expected = (sign * format.value(i128::from(code))).exp();
                assert!((found / expected - 1.0).abs() < 1e-15, "{text} {code}");
                assert!((1 << 126..1 << 127).contains(&mantissa));
                count += 1;
            }
            assert_eq!(count, 1 << format.width());
        }
    }

    /// Whole powers of two are exact but for the library's last bits, and halves
    /// are square roots.
    #[test]
    fn powers_of_two_are_powers_of_two() {
        let reference = ExactExponential::in_base(Format::unsigned(3, 13), ExpBase::Two).unwrap();
        for code in reference.codes().step_by(1 << 10) {
            let (mantissa, exponent) = reference.value(code);
            let found = mantissa as f64 * 2f64.powi(exponent - MANTISSA_BITS);
            let exact = (-f64::from(code) / 8192.0).exp2();
            assert!((found / exact - 1.0).abs() < 1e-15, "{code}");
        }
        let reference = ExactExponential::in_base(Format::signed(3, 8), ExpBase::Two).unwrap();
        let (mantissa, exponent) = reference.value(3 << 8);
        // 8 from above, or from just below: a mantissa of almost 2.
        let units = match exponent {
            3 => mantissa - (1 << MANTISSA_BITS),
            2 => (1 << (MANTISSA_BITS + 1)) - mantissa,
            _ => u128::MAX,
        };
        assert!(units < 64, "2^{exponent}, {units}");
    }

    /// `exp(-u) exp(-v) = exp(-(u + v))` to 2^-120: a slip in one of the
    /// factors of a value would show.
    #[test]
    fn products_of_values_are_values() {
        let reference = ExactExponential::of(Format::unsigned(3, 13)).unwrap();
        let wide = |code| {
            let (m, e) = reference.value(code);
            (BigFloat::from_u128(m, 256), e)
        };
        let rm = RoundingMode::ToEven;
        for u in (1..30_000).step_by(101) {
            let v = 65_535 - 2 * u;
            let ((a, ea), (b, eb), (c, ec)) = (wide(u), wide(v), wide(u + v));
            // Exact: 2^-252 scales the product, 2^-126 the value.
            let scale = |x: &BigFloat, power: i32| {
                x.mul(&BigFloat::from_f64(2f64.powi(power), 256), 256, rm)
            };
            let product = scale(&a.mul(&b, 256, rm), ea + eb - ec - 126);
            let off = product.sub(&c, 256, rm).abs();
            assert!(off < BigFloat::from_f64(64.0, 256), "{u} {v}");
        }
    }

    /// Against the library at 320 bits, one call a value, and against printed
    /// digits: what products of values at 192 bits lose is far below 2^-120.
    #[test]
    fn values_are_good_to_120_bits() {
        let (p, rm) = (320, RoundingMode::ToEven);
        let mut consts = Consts::new().unwrap();
        let reference = ExactExponential::of(Format::unsigned(3, 13)).unwrap();
        let near = |code: i32, exact: &BigFloat| {
            let (mantissa, exponent) = reference.value(code);
            let scale = BigFloat::from_f64(2f64.powi(exponent - MANTISSA_BITS), p);
            let held = BigFloat::from_u128(mantissa, p).mul(&scale, p, rm);
            let off = held.div(exact, p, rm);
            let off = off.sub(&BigFloat::from_f64(1.0, p), p, rm).abs();
            assert!(off < BigFloat::from_f64(2f64.powi(-120), p), "{code}");
        };
        for code in (0..65_536).step_by(61).chain([15_967, 65_535]) {
            let argument = BigFloat::from_f64(-f64::from(code) / 8192.0, p);
            near(code, &argument.exp(p, rm, &mut consts));
        }
        let radix = astro_float::Radix::Dec;
        for (code, digits) in [
            (0, "1"),
            (4096, "0.60653065971263342360379953499118045344191813548719"),
            (8192, "0.36787944117144232159552377016146086744581113103177"),
            (57_344, "0.00091188196555451620800313608440928262647423041"),
        ] {
            near(
                code,
                &BigFloat::parse(digits, radix, p, rm, &mut Consts::new().unwrap()),
            );
        }
    }

    /// The argument that is hardest to round, found over all of them, is far
    /// enough from a midpoint for 120 bits to decide.
    #[test]
    fn no_case_is_left_undecided() {
        let reference = ExactExponential::of(Format::unsigned(3, 13)).unwrap();
        let from_midpoint = |code: i32, f: u32| {
            let rest = reference.scaled(code, f) & ((1 << ERROR_BITS) - 1);
            (rest - (1 << (ERROR_BITS - 1))).abs() as f64 * 2f64.powi(-ERROR_BITS)
        };
        for (f, hardest) in [(8, None), (12, None), (16, Some(15_967)), (24, None)] {
            let (off, code) = reference
                .codes()
                .map(|code| (from_midpoint(code, f), code))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap();
            println!(
                "F {f}: code {code} is 2^{:.2} units from a midpoint",
                off.log2()
            );
            assert!(off > 2f64.powi(-24), "F {f}: {code}");
            assert!(hardest.is_none_or(|h| h == code), "F {f}: {code}");
        }
    }

    #[test]
    fn wide_formats_are_refused() {
        let wide = Format::unsigned(3, 18);
        assert_eq!(
            ExactExponential::of(wide).unwrap_err(),
            ExactError::TooWide(wide)
        );
    }

    /// The measurement itself: outputs that are off by a known amount.
    #[test]
    fn known_errors_are_measured() {
        let reference = ExactExponential::of(Format::unsigned(3, 13)).unwrap();
        let nearest = |code| {
            let scaled = reference.scaled(code, 16);
            ((scaled + (1 << (ERROR_BITS - 1))) >> ERROR_BITS) as i32
        };
        let right = reference.measure(16, nearest);
        assert!(right.max_ulp <= 0.5 && right.monotone && right.misrounded == 0);
        assert!(right.max_ulp > 0.4999 && (right.mean - 0.25).abs() < 0.01);
        // A uniform error of half a unit at most has an rms of 1 / sqrt(12).
        assert!(
            (right.rms - 12f64.sqrt().recip()).abs() < 0.005,
            "{right:?}"
        );
        let up = reference.measure(16, |code| nearest(code) + 2);
        assert!(
            (up.rms - (4.0 + right.rms.powi(2)).sqrt()).abs() < 0.01,
            "{up:?}"
        );
        let off = reference.measure(16, |code| nearest(code) + i32::from(code == 700) * 3);
        assert_eq!((off.worst_code, off.misrounded), (700, 1));
        assert!((off.max_ulp - 3.0).abs() <= 0.5 && off.monotone);
        let bump = reference.measure(16, |code| nearest(code) + i32::from(code == 60_000) * 3);
        assert!(!bump.monotone);
    }

    /// The nearest mantissas, one of them in another binade, and one that is off by three units.
    #[test]
    fn known_errors_of_mantissas_are_measured() {
        const F: u32 = 16;
        let reference = ExactExponential::of(Format::signed(3, 8)).unwrap();
        let nearest = |code| {
            let (mantissa, exponent) = reference.value(code);
            let drop = MANTISSA_BITS as u32 - F;
            (((mantissa >> (drop - 1)) as i64 + 1) >> 1, exponent)
        };
        let right = reference.measure_floating(F, nearest);
        assert!(
            right.max_ulp <= 0.5 && right.max_ulp > 0.49 && right.monotone,
            "{right:?}"
        );
        assert!((right.rms - 12f64.sqrt().recip()).abs() < 0.01, "{right:?}");
        let halved = reference.measure_floating(F, |code| {
            let (mantissa, exponent) = nearest(code);
            (2 * mantissa, exponent - 1)
        });
        assert_eq!(halved, right);
        let off = reference.measure_floating(F, |code| {
            let (mantissa, exponent) = nearest(code);
            (mantissa + 3 * i64::from(code == 5), exponent)
        });
        assert_eq!((off.worst_code, off.misrounded), (5, 1));
        let far = reference.measure_floating(F, |code| {
            let (mantissa, exponent) = nearest(code);
            (mantissa, exponent + 90 * i32::from(code == 7))
        });
        assert!(far.worst_code == 7 && far.max_ulp > 1e9, "{far:?}");
    }
}
