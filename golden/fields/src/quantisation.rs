//! Conversion of values to codes of the finest format that fits.

use potamoi_formats::fixed::{Format, Rounding};

use super::FieldError;

/// The largest number of fraction bits with which every rounded value fits `bits` bits.
pub(super) fn finest<'a>(
    values: impl Iterator<Item = &'a f32>,
    bits: u32,
    part: &'static str,
) -> Result<u32, FieldError> {
    let largest = values.fold(0f32, |m, v| m.max(v.abs()));
    let most = 2f64.powi(bits as i32 - 1) - 1.0;
    let fits =
        |frac: &u32| (f64::from(largest) * 2f64.powi(*frac as i32)).round_ties_even() <= most;
    (2..bits).rev().find(fits).ok_or_else(|| FieldError::Part {
        part,
        found: format!("up to {largest}"),
        expected: format!("values that leave 2 fraction bits of {bits}"),
    })
}

/// The code of a value, which is finite and fits by the choice of format.
pub(super) fn quantised(value: f32, bits: u32, frac: u32) -> i16 {
    let format = Format::signed(bits - 1 - frac, frac);
    let code = format.quantise(f64::from(value), Rounding::HalfEven);
    code.unwrap_or_default() as i16
}

/// The nearest 16-bit code, half to even, saturating.
pub(super) fn held(scaled: f64) -> i16 {
    let code = scaled.round_ties_even();
    code.clamp(i16::MIN.into(), i16::MAX.into()) as i16
}
