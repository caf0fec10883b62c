//! Fixed-point formats with explicit rounding and saturation.
//!
//! A *code* is the integer that a register holds; its value is
//! `code * 2^-frac_bits`. `U3.13` has 3 integer and 13 fraction bits (16 in
//! all); `S15.16` has a sign bit besides (32 in all).

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Rounding of dropped low bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rounding {
    /// Towards minus infinity: truncation.
    Floor,
    /// To nearest, ties towards plus infinity.
    HalfUp,
    /// To nearest, ties to the even code. No measurable bias.
    HalfEven,
}

/// `value / 2^shift`, rounded. Exact for every input with `shift <= 126`;
/// larger shifts give the limit (0, or -1 for `Floor` of a negative value).
#[must_use]
#[inline]
pub fn round_shift(value: i128, shift: u32, rounding: Rounding) -> i128 {
    if shift == 0 {
        return value;
    }
    if shift > 126 {
        return match rounding {
            Rounding::Floor if value < 0 => -1,
            _ => 0,
        };
    }
    // Arithmetic in 128 bits takes several times as long.
    if let (Ok(value), ..=62) = (i64::try_from(value), shift) {
        let floor = value >> shift;
        let rest = value & ((1 << shift) - 1);
        let up = is_up(rest, 1 << (shift - 1), floor & 1 == 1, rounding);
        return (floor + i64::from(up)).into();
    }
    let floor = value >> shift;
    let rest = value & ((1i128 << shift) - 1);
    let up = is_up(rest, 1i128 << (shift - 1), floor & 1 == 1, rounding);
    floor + i128::from(up)
}

/// Whether a dropped rest, beside half a unit, rounds up.
#[inline]
fn is_up<T: Ord>(rest: T, half: T, is_odd: bool, rounding: Rounding) -> bool {
    match rounding {
        Rounding::Floor => false,
        Rounding::HalfUp => rest >= half,
        Rounding::HalfEven => rest > half || (rest == half && is_odd),
    }
}

/// A fixed-point format of at most 64 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Format {
    signed: bool,
    int_bits: u32,
    frac_bits: u32,
}

/// A text is not a [`Format`].
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "`{0}` is not a fixed-point format: write U3.13 (3 integer, 13 fraction bits) or \
     S15.16 (a sign bit besides), 1 to 64 bits in all"
)]
pub struct FormatError(String);

impl Format {
    /// An unsigned format, `U{int_bits}.{frac_bits}`.
    #[must_use]
    pub const fn unsigned(int_bits: u32, frac_bits: u32) -> Self {
        Self {
            signed: false,
            int_bits,
            frac_bits,
        }
    }

    /// A two's complement format with a sign bit besides `int_bits`.
    #[must_use]
    pub const fn signed(int_bits: u32, frac_bits: u32) -> Self {
        Self {
            signed: true,
            int_bits,
            frac_bits,
        }
    }

    /// Total width in bits, sign included.
    #[must_use]
    #[inline]
    pub const fn width(self) -> u32 {
        self.int_bits + self.frac_bits + self.signed as u32
    }

    /// Fraction bits.
    #[must_use]
    #[inline]
    pub const fn frac_bits(self) -> u32 {
        self.frac_bits
    }

    /// Integer bits, without the sign.
    #[must_use]
    #[inline]
    pub const fn int_bits(self) -> u32 {
        self.int_bits
    }

    /// Whether codes are two's complement.
    #[must_use]
    #[inline]
    pub const fn is_signed(self) -> bool {
        self.signed
    }

    /// The smallest code.
    #[must_use]
    #[inline]
    pub const fn min(self) -> i128 {
        if self.signed {
            -(1i128 << (self.width() - 1))
        } else {
            0
        }
    }

    /// The largest code.
    #[must_use]
    #[inline]
    pub const fn max(self) -> i128 {
        let magnitude = self.width() - self.signed as u32;
        (1i128 << magnitude) - 1
    }

    /// Saturates a code to the range. Returns whether it was outside.
    #[must_use]
    #[inline]
    pub fn saturate(self, code: i128) -> (i128, bool) {
        let held = code.clamp(self.min(), self.max());
        (held, held != code)
    }

    /// The code of `value`, rounded and saturated; `None` for NaN.
    #[must_use]
    #[inline]
    pub fn quantise(self, value: f64, rounding: Rounding) -> Option<i128> {
        if value.is_nan() {
            return None;
        }
        let scaled = value * power_of_two(self.frac_bits as i32);
        let rounded = match rounding {
            Rounding::Floor => scaled.floor(),
            Rounding::HalfEven => scaled.round_ties_even(),
            Rounding::HalfUp => {
                let floor = scaled.floor();
                if scaled - floor >= 0.5 {
                    floor + 1.0
                } else {
                    floor
                }
            }
        };
        // Whole tables are quantised: the bounds of most formats are exact in 64-bit floats.
        if self.width() <= 53 {
            let [low, high] = [self.min() as i64, self.max() as i64];
            return Some((rounded.clamp(low as f64, high as f64) as i64).into());
        }
        // Every f64 at or past 2^64 saturates, so the cast below is exact.
        let held = rounded.clamp(-(2f64.powi(65)), 2f64.powi(65));
        Some(self.saturate(held as i128).0)
    }

    /// The value of a code.
    #[must_use]
    #[inline]
    pub fn value(self, code: i128) -> f64 {
        code as f64 * power_of_two(-(self.frac_bits as i32))
    }

    /// One unit in the last place (ulp).
    #[must_use]
    #[inline]
    pub fn ulp(self) -> f64 {
        power_of_two(-(self.frac_bits as i32))
    }
}

/// `2^power`, of a normal number.
#[inline]
fn power_of_two(power: i32) -> f64 {
    f64::from_bits(((1023 + power) as u64) << 52)
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.signed { 'S' } else { 'U' };
        write!(f, "{kind}{}.{}", self.int_bits, self.frac_bits)
    }
}

impl FromStr for Format {
    type Err = FormatError;

    fn from_str(text: &str) -> Result<Self, FormatError> {
        let bad = || FormatError(text.to_owned());
        let signed = match text.as_bytes().first() {
            Some(b'S') => true,
            Some(b'U') => false,
            _ => return Err(bad()),
        };
        let (int, frac) = text[1..].split_once('.').ok_or_else(bad)?;
        let digits = |part: &str| -> Result<u32, FormatError> {
            if part.is_empty() || part.len() > 2 || !part.bytes().all(|b| b.is_ascii_digit()) {
                return Err(bad());
            }
            part.parse().map_err(|_| bad())
        };
        let format = Self {
            signed,
            int_bits: digits(int)?,
            frac_bits: digits(frac)?,
        };
        if (1..=64).contains(&format.width()) {
            Ok(format)
        } else {
            Err(bad())
        }
    }
}

impl Serialize for Format {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Format {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn rounding_on_every_tie_and_sign() {
        // Quarters from -2 to 2: floor, half-up, half-even.
        let expected = [
            (-8, [-2, -2, -2]),
            (-7, [-2, -2, -2]),
            (-6, [-2, -1, -2]),
            (-5, [-2, -1, -1]),
            (-2, [-1, 0, 0]),
            (-1, [-1, 0, 0]),
            (1, [0, 0, 0]),
            (2, [0, 1, 0]),
            (3, [0, 1, 1]),
            (6, [1, 2, 2]),
            (7, [1, 2, 2]),
        ];
        for (value, [floor, up, even]) in expected {
            assert_eq!(round_shift(value, 2, Rounding::Floor), floor, "{value}/4");
            assert_eq!(round_shift(value, 2, Rounding::HalfUp), up, "{value}/4");
            assert_eq!(round_shift(value, 2, Rounding::HalfEven), even, "{value}/4");
        }
    }

    #[test]
    fn formats_read_back_and_refuse() {
        for text in ["U3.13", "S15.16", "U0.16", "U1.20", "S1.30", "U32.32"] {
            assert_eq!(text.parse::<Format>().unwrap().to_string(), text);
        }
        for text in [
            "", "3.13", "U3", "U.13", "U3.-1", "U40.40", "S0.64", "U0.0", "Ü1.2",
        ] {
            assert!(text.parse::<Format>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_weight_of_one_needs_the_integer_bit() {
        assert_eq!(
            Format::unsigned(1, 15).quantise(1.0, Rounding::HalfEven),
            Some(0x8000)
        );
        assert_eq!(
            Format::unsigned(0, 16).quantise(1.0, Rounding::HalfEven),
            Some(0xffff)
        );
    }

    #[test]
    fn special_values_saturate_and_nan_is_refused() {
        let s = Format::signed(15, 16);
        assert_eq!(s.quantise(f64::INFINITY, Rounding::Floor), Some(s.max()));
        assert_eq!(
            s.quantise(f64::NEG_INFINITY, Rounding::HalfUp),
            Some(s.min())
        );
        assert_eq!(s.quantise(f64::NAN, Rounding::Floor), None);
    }

    /// Formats of up to 53 bits saturate in floating point, wider ones as integers: both do alike.
    #[test]
    fn narrow_and_wide_formats_saturate_alike() {
        let all = [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven];
        for width in 1..=53 {
            for narrow in [Format::unsigned(width, 0), Format::signed(width - 1, 0)] {
                let ends = [narrow.min(), narrow.max()];
                for (end, off) in ends.iter().flat_map(|end| [-1, 0, 1].map(|off| (end, off))) {
                    let code = end + off;
                    let found = all.map(|way| narrow.quantise(code as f64, way));
                    assert_eq!(found, [Some(narrow.saturate(code).0); 3], "{narrow} {code}");
                }
            }
        }
        for power in -64..=64 {
            assert_eq!(power_of_two(power), 2f64.powi(power));
        }
    }

    proptest! {
        #[test]
        fn rounding_stays_within_its_bound(value in -(1i128 << 90)..(1i128 << 90), shift in 1u32..80) {
            let unit = 1i128 << shift;
            let floor = round_shift(value, shift, Rounding::Floor);
            prop_assert!(floor * unit <= value && value - floor * unit < unit);
            for rounding in [Rounding::HalfUp, Rounding::HalfEven] {
                let error = round_shift(value, shift, rounding) * unit - value;
                prop_assert!(error.abs() * 2 <= unit);
            }
        }

        #[test]
        fn quantising_a_code_gives_it_back(code in any::<i32>()) {
            let s = Format::signed(15, 16);
            prop_assert_eq!(s.quantise(s.value(i128::from(code)), Rounding::HalfEven), Some(i128::from(code)));
        }
    }
}
