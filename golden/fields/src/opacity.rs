//! Opacities from gathered densities in the hardware's formats, through the vector unit.
//!
//! | step | operation | result |
//! |---|---|---|
//! | d | multiply by a power of two | the fraction bits of the exponential's input |
//! | density | softplus after a shift, or ReLU | F fraction bits, or those of d |
//! | s | multiply by the interval, half even | U4.G, G = `one_minus_frac_bits` |
//! | alpha | 1 - exp(-s) | U0.F |
//!
//! An exponential density needs no multiplication by the interval: the interval is added as a
//! logarithm. The unit computes exp(-u) for u from 0 to 8, and s may be as thin as a sample of
//! fog. So u is half of ln 16 less the exponent, and s is 16 exp(-u)^2, from 16 down to 16
//! exp(-16).

use std::f64::consts::LN_2;

use potamoi_formats::config::{Config, presets_that};
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};

use super::FieldError;
use potamoi_march::{Lanes, MarchError, Transparent};

/// Fraction bits of the interval.
const INTERVAL_BITS: u32 = 24;
/// Optical depths are below two to this power.
const DEPTH_INT_BITS: u32 = 4;
/// Optical depth at which thicker samples saturate.
pub(super) const THICKEST: f64 = (1 << DEPTH_INT_BITS) as f64;

/// Activation from a number to a density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Curve {
    /// `ln(1 + exp(d + shift))`.
    Softplus {
        /// Shift before the softplus.
        shift: f64,
    },
    /// `max(d, 0)`.
    Relu,
    /// `exp(d)`.
    Exp,
}

impl Curve {
    const fn operations(self) -> &'static [OpCode] {
        match self {
            Self::Softplus { .. } => &[OpCode::Softplus, OpCode::Add],
            Self::Relu => &[OpCode::Relu],
            Self::Exp => &[OpCode::Exp, OpCode::Add, OpCode::Relu],
        }
    }
}

/// Conversion of numbers to opacities.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Opacity {
    pub(super) curve: Curve,
    /// Optical depth of one step at density 1.
    pub(super) interval: f64,
    /// Fraction bits of the exponential's input, of its results, and of s.
    engine: [u32; 3],
    transparent: Transparent,
}

impl Opacity {
    /// # Errors
    /// The units lack an operation, or their formats are too narrow.
    pub(super) fn new(curve: Curve, interval: f64, config: &Config) -> Result<Self, FieldError> {
        need(config, curve.operations())?;
        need(config, &[OpCode::Multiply, OpCode::OneMinusExp])?;
        let exp = &config.vu.exp;
        // Codes of the interval have 31 bits.
        if !(interval > 0.0 && interval < 64.0) {
            return Err(FieldError::Part {
                part: "interval",
                found: interval.to_string(),
                expected: "above 0 and below 64, as steps of a few voxels have it".to_owned(),
            });
        }
        Ok(Self {
            curve,
            interval,
            engine: [
                exp.input.frac_bits(),
                exp.output_bits,
                exp.one_minus_frac_bits,
            ],
            transparent: Transparent::of(config, 0),
        })
    }

    /// The same where opacities up to `least` are taken for 0.
    pub(super) fn with_least(self, least: i32, config: &Config) -> Self {
        Self {
            transparent: Transparent::of(config, least),
            ..self
        }
    }

    /// Operations of the conversion.
    pub(super) fn operations(&self) -> Vec<OpCode> {
        [
            self.curve.operations(),
            &[OpCode::Multiply, OpCode::OneMinusExp],
        ]
        .concat()
    }

    /// Fraction bits of opacities.
    pub(super) const fn alpha_bits(&self) -> u32 {
        self.engine[1]
    }

    /// Opacities for numbers of `frac_bits` fraction bits.
    pub(super) fn alphas(
        &self,
        numbers: &[i32],
        frac_bits: i32,
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError> {
        let [input, output, _] = self.engine;
        let depth = match self.curve {
            Curve::Softplus { shift } => {
                let scaled = rescale(numbers, frac_bits, input, lanes)?;
                let shift = code(shift, input);
                let shifted = lanes.compute_with(VectorOp::new(OpCode::Add), &scaled, shift)?;
                let positive = lanes.compute_with(VectorOp::new(OpCode::Softplus), &shifted, 0)?;
                self.times_interval(&positive, output as i32, lanes)?
            }
            Curve::Relu => {
                let positive = lanes.compute_with(VectorOp::new(OpCode::Relu), numbers, 0)?;
                self.times_interval(&positive, frac_bits, lanes)?
            }
            Curve::Exp => self.exponential(numbers, frac_bits, lanes)?,
        };
        lanes.one_minus_exp(&depth, self.transparent)
    }

    /// Bits of the interval above its point. An interval of 1 and more has as many bits as one below 1, and
    /// so many fraction bits less: lanes may have a narrow second factor.
    fn whole_bits(&self) -> i32 {
        (self.interval.log2().floor() as i32 + 1).max(0)
    }

    /// Largest error of the interval's code.
    pub(super) fn interval_off(&self) -> f64 {
        2f64.powi(self.whole_bits() - INTERVAL_BITS as i32 - 1)
    }

    fn times_interval(
        &self,
        density: &[i32],
        frac_bits: i32,
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError> {
        let [_, _, depth] = self.engine;
        // Fewer bits than s has are those of a coarser interval.
        let down = frac_bits + INTERVAL_BITS as i32 - depth as i32;
        let less = self.whole_bits().min(down.max(0));
        let interval = code(
            self.interval,
            (INTERVAL_BITS as i32 - less - down.min(0)) as u32,
        );
        lanes.compute_with(multiply((down - less).max(0) as u32), density, interval)
    }

    fn exponential(
        &self,
        numbers: &[i32],
        frac_bits: i32,
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError> {
        let [input, output, depth] = self.engine;
        // Half of each number, with its sign changed.
        let half = rescale_by(numbers, frac_bits + 1, input, -1, lanes)?;
        let most = (f64::from(DEPTH_INT_BITS) * LN_2 - self.interval.ln()) / 2.0;
        let less = lanes.compute_with(VectorOp::new(OpCode::Add), &half, code(most, input))?;
        let held = lanes.compute_with(VectorOp::new(OpCode::Relu), &less, 0)?;
        let root = lanes.compute_with(VectorOp::new(OpCode::Exp), &held, 0)?;
        let down = (2 * output) as i32 - (depth + DEPTH_INT_BITS) as i32;
        let square = lanes.compute(multiply(down.max(0) as u32), &root, &root)?;
        if down >= 0 {
            return Ok(square);
        }
        lanes.compute_with(multiply(0), &square, 1 << -down)
    }
}

/// Checks that the units have the operations. A refusal names the presets that have them.
pub(super) fn need(config: &Config, ops: &[OpCode]) -> Result<(), FieldError> {
    need_of(config, ops, |_| true)
}

/// The same, where a refusal names only presets that are `able` to do the rest.
pub(super) fn need_of(
    config: &Config,
    ops: &[OpCode],
    able: impl Fn(&Config) -> bool,
) -> Result<(), FieldError> {
    let lacks = |config: &Config| ops.iter().find(|op| !config.vu.ops.contains(op));
    let missing = lacks(config);
    missing.map_or(Ok(()), |op| {
        Err(FieldError::Part {
            part: "vu.ops",
            found: OpCode::list(&config.vu.ops),
            expected: format!(
                "\"{}\" among the operations{}",
                op.name(),
                presets_that(|preset| lacks(preset).is_none() && able(preset))
            ),
        })
    })
}

/// A product shifted right by `shift` bits, half to even.
pub(super) fn multiply(shift: u32) -> VectorOp {
    VectorOp {
        code: OpCode::Multiply,
        shift: shift.min(63) as u8,
        rounding: Rounding::HalfEven,
    }
}

/// Converts codes from `from` to `to` fraction bits.
pub(super) fn rescale(
    codes: &[i32],
    from: i32,
    to: u32,
    lanes: &mut Lanes<'_>,
) -> Result<Vec<i32>, MarchError> {
    rescale_by(codes, from, to, 1, lanes)
}

fn rescale_by(
    codes: &[i32],
    from: i32,
    to: u32,
    sign: i32,
    lanes: &mut Lanes<'_>,
) -> Result<Vec<i32>, MarchError> {
    let up = to as i32 - from;
    let factor = sign << up.clamp(0, 30);
    lanes.compute_with(multiply((-up).max(0) as u32), codes, factor)
}

/// The nearest 32-bit code, saturating.
fn code(value: f64, frac_bits: u32) -> i32 {
    (value * 2f64.powi(frac_bits as i32)).round_ties_even() as i32
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_march::Work;
    use potamoi_reference::ReferenceUnits;

    fn config() -> Config {
        let path =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/fields.toml");
        Config::from_toml(&std::fs::read_to_string(path).unwrap(), "fields").unwrap()
    }

    /// Numbers from -20 to 20 with 10 fraction bits.
    const FRAC: i32 = 10;

    fn alphas(curve: Curve, interval: f64, numbers: &[i32]) -> Vec<f64> {
        let config = config();
        let opacity = Opacity::new(curve, interval, &config).unwrap();
        let (mut units, mut work) = (ReferenceUnits::new(&config), Work::default());
        let mut lanes = Lanes {
            units: &mut units,
            work: &mut work,
        };
        let codes = opacity.alphas(numbers, FRAC, &mut lanes).unwrap();
        let unit = 2f64.powi(-(opacity.alpha_bits() as i32));
        codes.iter().map(|c| f64::from(*c) * unit).collect()
    }

    fn numbers() -> Vec<i32> {
        (-20 << FRAC..=20 << FRAC).step_by(7).collect()
    }

    /// How far an opacity may be from that of an optical depth `s` that is off
    /// by `error`: U4.20 rounds s by half a code and holds it below 16, and
    /// 1 - exp(-s) is 1.112 units of 2^-16 off at most (docs/reference/vector-unit.md).
    fn bound(s: f64, error: f64) -> f64 {
        let least = (s - error).max(0.0);
        (-least).exp() * (error + 2f64.powi(-21)) + (-16f64).exp() + 1.112 * 2f64.powi(-16)
    }

    /// The exponential's u has 13 fraction bits, twice rounded, and its result
    /// is 1 unit of 2^-16 off: so the root r is off by r 2^-13 + 2^-16, and s by
    /// 16 times its square's.
    #[test]
    fn exponential_densities_keep_to_their_bound() {
        let numbers = numbers();
        for interval in [3.7e-5, 1.7e-3, 0.02, 1.0, 9.0] {
            let mut worst = 0f64;
            for (number, alpha) in numbers.iter().zip(alphas(Curve::Exp, interval, &numbers)) {
                let s = interval * (f64::from(*number) * 2f64.powi(-FRAC)).exp();
                // Thicker ones are held at 16, thinner ones at 16 exp(-16).
                let held = s.clamp(16.0 * (-16f64).exp(), 16.0);
                let root = (held / 16.0).sqrt();
                let off = root * 2f64.powi(-13) + 2f64.powi(-16);
                let bound =
                    bound(held, 16.0 * (2.0 * root * off + off * off)) + (held - s).max(0.0);
                let share = (alpha + (-s).exp_m1()).abs() / bound;
                assert!(share <= 1.0, "{interval} exp({number}): {alpha}, {share}");
                worst = worst.max(share);
            }
            assert!(worst > 0.2, "{worst}");
        }
    }

    /// Without the square u would end at 8, and the thinnest sample would be
    /// 16 exp(-8) = 0.0054: a hundred of them in empty space would hide 40 % of
    /// what is behind.
    #[test]
    fn thin_fog_is_not_thickened() {
        let alpha = alphas(Curve::Exp, 1.7e-3, &[-20 << FRAC, -5 << FRAC]);
        let naive = 16.0 * (-8f64).exp();
        assert!(1.0 - (-100.0 * naive).exp() > 0.4);
        assert!(alpha.iter().all(|a| *a < 2e-5), "{alpha:?}");
    }

    /// Softplus is 0.74 units of 2^-16 off after 13 fraction bits of input,
    /// twice rounded; its slope is at most 1.
    #[test]
    fn softplus_and_relu_keep_to_their_bounds() {
        let numbers = numbers();
        for interval in [2e-3, 0.4, 12.0] {
            for shift in [-10.0, -4.6, 0.0] {
                let curve = Curve::Softplus { shift };
                for (number, alpha) in numbers.iter().zip(alphas(curve, interval, &numbers)) {
                    let x = f64::from(*number) * 2f64.powi(-FRAC) + shift;
                    let density = x.max(0.0) + (-x.abs()).exp().ln_1p();
                    let off = 2f64.powi(-13) + 0.74 * 2f64.powi(-16);
                    let s = interval * density;
                    let bound = bound(s, interval * off + density * 2f64.powi(-25));
                    let error = (alpha + (-s).exp_m1()).abs();
                    assert!(
                        error <= bound,
                        "{interval} {shift} {number}: {error} {bound}"
                    );
                }
            }
            for (number, alpha) in numbers.iter().zip(alphas(Curve::Relu, interval, &numbers)) {
                let density = (f64::from(*number) * 2f64.powi(-FRAC)).max(0.0);
                let s = interval * density;
                let error = (alpha + (-s).exp_m1()).abs();
                assert!(error <= bound(s, density * 2f64.powi(-25)));
                assert!(*number > 0 || alpha == 0.0, "nothing where nothing is");
            }
        }
    }

    /// Ties go to the even code, so that no sum of many samples drifts.
    #[test]
    fn products_are_rounded_half_to_even() {
        let config = config();
        let (mut units, mut work) = (ReferenceUnits::new(&config), Work::default());
        let mut lanes = Lanes {
            units: &mut units,
            work: &mut work,
        };
        let found = rescale(&[1, 3, 5, -1, -3, 6], 3, 2, &mut lanes).unwrap();
        assert_eq!(found, [0, 2, 2, 0, -2, 3]);
    }

    #[test]
    fn intervals_and_units_that_do_not_fit_are_refused() {
        let refused = |interval, config: &Config| {
            let made = Opacity::new(Curve::Exp, interval, config);
            made.unwrap_err().to_string()
        };
        for interval in [0.0, -1.0, 64.0, f64::NAN, f64::INFINITY] {
            assert!(refused(interval, &config()).contains("interval"));
        }
        let text = "[vu]\nops = [\"pass\", \"relu\", \"add\", \"multiply\", \"exp\"]\n";
        let less = Config::from_toml(text, "test").unwrap();
        assert!(refused(1.0, &less).contains("one-minus-exp"));
    }
}
