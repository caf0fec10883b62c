//! `1 - exp(-s)` to 120 bits, for every `s` that the vector unit takes.

use astro_float::{BigFloat, Consts, RoundingMode};
use rayon::prelude::*;

use super::exact_exponential::{ERROR_BITS, ExactError, WORKING_BITS, parts};

/// Fraction bits of a stored exponential, which is in [0, 1].
const FRACTION: u32 = 127;
/// Low bits of a code, whose exponentials form the fine table.
const FINE: u32 = 12;

/// `1 - exp(-s)` for every code of `s` in [0, 16), as a product of two tables, within 2^-124.
#[derive(Debug)]
pub struct OneMinusReference {
    frac_bits: u32,
    coarse: Vec<u128>,
    fine: Vec<u128>,
}

impl OneMinusReference {
    /// The reference for codes of `s` with `frac_bits` fraction bits, clamped to 8 to 24.
    ///
    /// # Errors
    /// The library of arbitrary precision failed.
    pub fn new(frac_bits: u32) -> Result<Self, ExactError> {
        let frac_bits = frac_bits.clamp(8, 24);
        let table = |count: u32, power: i32| -> Result<Vec<u128>, ExactError> {
            let mut consts = Consts::new().map_err(|e| ExactError::Library(e.to_string()))?;
            let unit = -2f64.powi(power);
            let value = |code: u32| {
                let argument = BigFloat::from_f64(f64::from(code) * unit, WORKING_BITS);
                let exact = argument.exp(WORKING_BITS, RoundingMode::ToEven, &mut consts);
                let (mantissa, exponent) = parts(&exact)
                    .ok_or_else(|| ExactError::Library(format!("exp({argument}) is {exact}")))?;
                // The mantissa has 126 fraction bits.
                Ok(if exponent >= 0 {
                    mantissa << 1
                } else {
                    mantissa >> (-1 - exponent).min(127)
                })
            };
            (0..count).map(value).collect()
        };
        let (coarse, fine) = rayon::join(
            || table(1 << (4 + frac_bits - FINE), FINE as i32 - frac_bits as i32),
            || table(1 << FINE, -(frac_bits as i32)),
        );
        Ok(Self {
            frac_bits,
            coarse: coarse?,
            fine: fine?,
        })
    }

    /// The largest code of `s`.
    #[must_use]
    pub fn last(&self) -> i32 {
        (16 << self.frac_bits) - 1
    }

    /// `1 - exp(-s)` in units of 2^-`output_bits` (at most 24), with 80 more fraction bits,
    /// truncated; at most the largest code, `2^output_bits - 1`. `code` is clamped.
    #[must_use]
    pub fn scaled(&self, code: i32, output_bits: u32) -> i128 {
        let code = code.clamp(0, self.last()) as usize;
        let output_bits = output_bits.min(24);
        let get = |table: &[u128], at: usize| table.get(at).copied().unwrap_or(0);
        let exp = multiply(
            get(&self.coarse, code >> FINE),
            get(&self.fine, code & ((1 << FINE) - 1)),
        );
        let drop = FRACTION - ERROR_BITS as u32 - output_bits;
        let exact = (((1u128 << FRACTION) - exp) >> drop) as i128;
        exact.min(((1 << output_bits) - 1) << ERROR_BITS)
    }

    /// Signed error of `output`, a code with `output_bits` fraction bits, in units of its last
    /// place.
    #[must_use]
    pub fn error(&self, code: i32, output: i32, output_bits: u32) -> f64 {
        let off = (i128::from(output) << ERROR_BITS) - self.scaled(code, output_bits);
        off as f64 * 2f64.powi(-ERROR_BITS)
    }

    /// Largest magnitude of the error of `output` over each octave of codes, in units of the last
    /// place: entry i covers codes 2^i to 2^(i+1) - 1.
    pub fn by_octave(&self, output_bits: u32, output: impl Fn(i32) -> i32 + Sync) -> Vec<f64> {
        let octave = |i: u32| {
            (1i32 << i..=((2i64 << i) - 1) as i32)
                .into_par_iter()
                .map(|code| self.error(code, output(code), output_bits).abs())
                .reduce(|| 0.0, f64::max)
        };
        (0..4 + self.frac_bits).map(octave).collect()
    }
}

/// `a b / 2^127`, truncated; factors are at most 2^127.
fn multiply(a: u128, b: u128) -> u128 {
    let low = u128::from(u64::MAX);
    let ((ah, al), (bh, bl)) = ((a >> 64, a & low), (b >> 64, b & low));
    let middle = ah * bl + ((al * bl) >> 64);
    let (carry, middle) = (middle >> 64, (middle & low) + al * bh);
    let high = ah * bh + carry + (middle >> 64);
    high << 1 | (middle & low) >> 63
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::exponential::ReferenceExponential;
    use crate::widths::budget;
    use potamoi_formats::config::ExpConfig;

    #[test]
    fn products_are_exact_before_the_cut() {
        let values = [
            0,
            1,
            3,
            u128::from(u64::MAX),
            1 << 64,
            (1 << 127) - 1,
            1 << 127,
            0x5555 << 100,
        ];
        for a in values {
            for b in values {
                let limbs = |v: u128| [0, 32, 64, 96].map(|s| v >> s & 0xffff_ffff);
                let mut sums = [0u128; 8];
                for (i, x) in limbs(a).into_iter().enumerate() {
                    for (j, y) in limbs(b).into_iter().enumerate() {
                        sums[i + j] += x * y;
                    }
                }
                for i in 0..7 {
                    sums[i + 1] += sums[i] >> 32;
                    sums[i] &= 0xffff_ffff;
                }
                let exact =
                    sums[7] << 97 | sums[6] << 65 | sums[5] << 33 | sums[4] << 1 | sums[3] >> 31;
                assert_eq!(multiply(a, b), exact, "{a:x} {b:x}");
            }
        }
    }

    /// One call of the library a value, at 320 bits: 2^-104 units of 2^-16 is
    /// 2^-120; the scaled value itself is cut off at 80 bits.
    #[test]
    fn values_agree_with_the_library() {
        let (p, rm) = (320, RoundingMode::ToEven);
        let mut consts = Consts::new().unwrap();
        let reference = OneMinusReference::new(20).unwrap();
        for code in (0..1 << 24)
            .step_by(65_521)
            .chain([1, 2, 4095, 4096, (1 << 24) - 1])
        {
            let argument = BigFloat::from_f64(-f64::from(code) * 2f64.powi(-20), p);
            let exp = argument.exp(p, rm, &mut consts);
            let one = BigFloat::from_f64(1.0, p);
            let scale = BigFloat::from_f64(2f64.powi(24 + ERROR_BITS), p);
            let exact = one.sub(&exp, p, rm).mul(&scale, p, rm);
            let found = BigFloat::from_i128(reference.scaled(code, 24), p);
            let most = BigFloat::from_i128(((1 << 24) - 1) << ERROR_BITS, p);
            let off = exact.min(&most).sub(&found, p, rm).abs();
            assert!(off <= BigFloat::from_f64(1.001, p), "{code}: {off}");
        }
    }

    /// Every s from 2^-20 to 16 in steps of 2^-20.
    #[test]
    fn every_one_minus_exp_of_the_default_engine() {
        let config = ExpConfig::default();
        let (twin, f) = (ReferenceExponential::new(&config), config.output_bits);
        let reference = OneMinusReference::new(config.one_minus_frac_bits).unwrap();
        assert_eq!((twin.one_minus_exp(0), reference.scaled(0, f)), (0, 0));
        let octaves = reference.by_octave(f, |s| twin.one_minus_exp(s));
        for (i, worst) in octaves.iter().enumerate() {
            println!("s from 2^{}: at most {worst:.4} ulp", i as i32 - 20);
        }
        // The budget counts no rounding of s, here to the constants' 19 bits.
        let worst = octaves.iter().copied().fold(0.0, f64::max);
        assert!(worst <= budget(&config) + 2f64.powi(16 - 20), "{worst}");
        assert!((1.0..1.25).contains(&worst), "{worst}");
        let falls = (0..reference.last())
            .into_par_iter()
            .find_any(|s| twin.one_minus_exp(s + 1) < twin.one_minus_exp(*s));
        assert_eq!(falls, None, "not monotone");
        // Taken from the saturated result, nothing would be something.
        let naive = (1 << f) - twin.exp(0);
        assert_eq!(naive, 1);
    }
}
