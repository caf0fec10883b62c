//! Sigmoid and softplus to 120 bits, for every operand up to 16, and error bounds of a unit.

use astro_float::{BigFloat, Consts, RoundingMode};
use potamoi_formats::config::ExpConfig;
use rayon::prelude::*;

use super::exact_exponential::{ERROR_BITS, ExactError, ExpError, WORKING_BITS, parts};
use super::widths::budget;

/// Fraction bits of a stored value, which is below 1.
const FRACTION: u32 = 124;
/// Low bits of a code, whose exponentials form the fine table.
const FINE: u32 = 9;

/// One of the two functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Logistic {
    /// `1 / (1 + exp(-x))`, at most the largest code of U0.F.
    Sigmoid,
    /// `ln(1 + exp(x))`.
    Softplus,
}

/// `sigmoid(-s)` and `softplus(-s)` for every code of `s` in [0, 16], within
/// 2^-122; their values for `s` follow from these.
#[derive(Debug)]
pub struct LogisticReference {
    frac_bits: u32,
    falling: Vec<(u128, u128)>,
}

impl LogisticReference {
    /// Fraction bits of codes.
    pub const BITS: std::ops::RangeInclusive<u32> = 4..=16;

    /// The reference for codes with `frac_bits` fraction bits, clamped to [`Self::BITS`].
    ///
    /// # Errors
    /// The library of arbitrary precision failed.
    pub fn new(frac_bits: u32) -> Result<Self, ExactError> {
        let frac_bits = frac_bits.clamp(*Self::BITS.start(), *Self::BITS.end());
        let fine = exponentials(0..1 << FINE, -(frac_bits as i32))?;
        let blocks = (16u32 << frac_bits >> FINE) + 1;
        let coarse = exponentials(0..blocks, FINE as i32 - frac_bits as i32)?;
        let logarithm = Logarithm::new()?;
        let block = |coarse: &BigFloat| {
            let values = fine
                .iter()
                .map(|fine| both(&coarse.mul(fine, WORKING_BITS, NEAREST), &logarithm));
            values.collect::<Result<Vec<_>, _>>()
        };
        let blocks: Vec<_> = coarse.par_iter().map(block).collect::<Result<_, _>>()?;
        let mut falling = blocks.concat();
        falling.truncate((16 << frac_bits) + 1);
        Ok(Self { frac_bits, falling })
    }

    /// The largest code: 16.
    #[must_use]
    pub fn last(&self) -> i32 {
        16 << self.frac_bits
    }

    /// The value for a code, clamped to -16 to 16, in units of 2^-`output_bits` (at most 24), with
    /// 80 more fraction bits, truncated.
    #[must_use]
    pub fn scaled(&self, of: Logistic, code: i32, output_bits: u32) -> i128 {
        let code = code.clamp(-self.last(), self.last());
        let output_bits = output_bits.min(24);
        let index = code.unsigned_abs() as usize;
        let (sigmoid, softplus) = self.falling.get(index).copied().unwrap_or((0, 0));
        let drop = FRACTION - ERROR_BITS as u32 - output_bits;
        match of {
            Logistic::Sigmoid => {
                let value = if code > 0 {
                    (1 << FRACTION) - sigmoid
                } else {
                    sigmoid
                };
                ((value >> drop) as i128).min(((1 << output_bits) - 1) << ERROR_BITS)
            }
            Logistic::Softplus => {
                let linear =
                    i128::from(code.max(0)) << (ERROR_BITS as u32 + output_bits - self.frac_bits);
                linear + (softplus >> drop) as i128
            }
        }
    }

    /// Signed error of `output`, a code with `output_bits` fraction bits, in units of its last
    /// place.
    #[must_use]
    pub fn error(&self, of: Logistic, code: i32, output: i32, output_bits: u32) -> f64 {
        let off = (i128::from(output) << ERROR_BITS) - self.scaled(of, code, output_bits);
        off as f64 * 2f64.powi(-ERROR_BITS)
    }

    /// Measures `output`, which is called once for every code from -16 to 16, smallest first.
    pub fn measure(
        &self,
        of: Logistic,
        output_bits: u32,
        mut output: impl FnMut(i32) -> i32,
    ) -> ExpError {
        let results = (-self.last()..=self.last()).map(|code| {
            let found = output(code);
            let off = self.error(of, code, found, output_bits);
            (code, off, f64::from(found))
        });
        ExpError::of(results, false)
    }
}

const NEAREST: RoundingMode = RoundingMode::ToEven;

fn library() -> Result<Consts, ExactError> {
    Consts::new().map_err(|e| ExactError::Library(e.to_string()))
}

/// `exp(-code 2^power)` of each code.
fn exponentials(codes: std::ops::Range<u32>, power: i32) -> Result<Vec<BigFloat>, ExactError> {
    let mut consts = library()?;
    let exp = |code: u32| {
        let argument = BigFloat::from_f64(-f64::from(code) * 2f64.powi(power), WORKING_BITS);
        argument.exp(WORKING_BITS, NEAREST, &mut consts)
    };
    Ok(codes.map(exp).collect())
}

/// `e / (1 + e)` and `ln(1 + e)` with [`FRACTION`] fraction bits, truncated.
fn both(e: &BigFloat, logarithm: &Logarithm) -> Result<(u128, u128), ExactError> {
    let y = e.add(&logarithm.one, WORKING_BITS, NEAREST);
    let sigmoid = e.div(&y, WORKING_BITS, NEAREST);
    Ok((fixed(&sigmoid)?, fixed(&logarithm.of_one_and(e, &y)?)?))
}

/// A number below 1 with [`FRACTION`] fraction bits, truncated.
fn fixed(value: &BigFloat) -> Result<u128, ExactError> {
    let (mantissa, exponent) = positive(value)?;
    // The mantissa has 126 fraction bits.
    Ok(mantissa >> (126 - FRACTION as i32 - exponent).clamp(0, 127))
}

fn positive(value: &BigFloat) -> Result<(u128, i32), ExactError> {
    parts(value).ok_or_else(|| ExactError::Library(format!("a value is {value}")))
}

/// `ln(1 + e)` from logarithms of a grid: a call of the library a value would take ten times as
/// long.
struct Logarithm {
    one: BigFloat,
    /// `g = 1 + k 2^-GRID` and its logarithm, for every `k` up to `2^GRID`.
    grid: Vec<(BigFloat, BigFloat)>,
    /// `2 / (2j + 1)`, the last first.
    terms: Vec<BigFloat>,
}

/// Bits of the grid between 1 and 2.
const GRID: i32 = 9;
/// Terms of the series. Its argument is at most 2^-11, so that the first term left out is below
/// 2^-145.
const TERMS: u32 = 6;

impl Logarithm {
    fn new() -> Result<Self, ExactError> {
        let mut consts = library()?;
        let number = |value: f64| BigFloat::from_f64(value, WORKING_BITS);
        let mut point = |k: u32| {
            let g = number(1.0 + f64::from(k) * 2f64.powi(-GRID));
            let ln = g.ln(WORKING_BITS, NEAREST, &mut consts);
            (g, ln)
        };
        let term = |j: u32| number(2.0).div(&number(f64::from(2 * j + 1)), WORKING_BITS, NEAREST);
        Ok(Self {
            one: number(1.0),
            grid: (0..=1 << GRID).map(&mut point).collect(),
            terms: (0..TERMS).rev().map(term).collect(),
        })
    }

    /// `ln(y)` of `y = 1 + e`, for `e` in (0, 1]: `ln(g) + 2 artanh((y - g) / (y + g))`.
    fn of_one_and(&self, e: &BigFloat, y: &BigFloat) -> Result<BigFloat, ExactError> {
        let (p, rm) = (WORKING_BITS, NEAREST);
        let (mantissa, exponent) = positive(e)?;
        let near = mantissa as f64 * 2f64.powi(exponent - 126 + GRID);
        let k = (near.round() as usize).min(self.grid.len() - 1);
        let (g, ln) = &self.grid[k];
        let z = y.sub(g, p, rm).div(&y.add(g, p, rm), p, rm);
        let square = z.mul(&z, p, rm);
        let series = self.terms.iter().fold(BigFloat::new(p), |sum, term| {
            sum.mul(&square, p, rm).add(term, p, rm)
        });
        Ok(series.mul(&z, p, rm).add(ln, p, rm))
    }
}

/// An upper bound of the error of `of` by an engine of `config`, in units of the last place.
///
/// E is the bound of its exponential before rounding ([`budget`] less 1/2); a and c are the
/// fraction bits of accumulator and constants beyond F. The sum `max(x, 0) + ln(1 + exp(-|x|))` is
/// off by at most `S = E + 2^-a / 2 + n (2^-a + 2^-c) + 2^-c + 2^(F - 2n)`: the exponential and
/// its rounding to a; n sums and n constants of the logarithm, and its start; the truncation of
/// the last term; and the remainder of the first order. Softplus rounds it: `S + 1/2`. Sigmoid is
/// the exponential of it, whose slope is at most 1: `S + E + 1/2`. Holds where the budget of the
/// exponential does.
#[must_use]
pub fn logistic_budget(of: Logistic, config: &ExpConfig) -> f64 {
    let (n, f, engine) = (config.iterations, config.output_bits, config.engine());
    let beyond = |bits: u32| 2f64.powi(f as i32 - bits as i32);
    let (a, c) = (
        beyond(engine.accumulator_bits),
        beyond(engine.constant_bits),
    );
    let exp = budget(config) - 0.5;
    let sum = exp + a / 2.0 + f64::from(n) * (a + c) + c + 2f64.powi(f as i32 - 2 * n as i32);
    match of {
        Logistic::Softplus => sum + 0.5,
        Logistic::Sigmoid => sum + exp + 0.5,
    }
}

#[cfg(test)]
mod tests;
