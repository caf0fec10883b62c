//! Conversion of projected Gaussians to the records that the gathering unit reads.

use potamoi_formats::config::SplatOpacity;
use potamoi_formats::fixed::{Format, Rounding};
use potamoi_formats::record::{COLOUR, FACTOR, LOG_OPACITY, MEAN, OPACITY, SplatRecord};

use super::project::Projected;

/// Numbers of record values that saturated, by field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Saturations {
    /// Means farther than 524,288 pixels from the first pixel.
    pub mean: u64,
    /// Cholesky factors of 2 or more; the dilation rules them out.
    pub factor: u64,
    /// Opacities that round to 1.
    pub opacity: u64,
    /// Colour channels of 16 or more.
    pub colour: u64,
}

impl Saturations {
    /// Sum over all fields.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.mean + self.factor + self.opacity + self.colour
    }
}

/// The code nearest to `value`, ties to even. Counts saturation.
fn code(format: Format, value: f64, saturated: &mut u64) -> i128 {
    let scaled = (value / format.ulp()).round_ties_even();
    let outside = scaled < format.min() as f64 || scaled > format.max() as f64;
    *saturated += u64::from(outside);
    // A projected Gaussian holds no NaN.
    format
        .quantise(value, Rounding::HalfEven)
        .unwrap_or_default()
}

fn factor(value: f64, bits: u32, saturations: &mut Saturations) -> i32 {
    let spare = FACTOR.frac_bits() - bits.min(FACTOR.frac_bits());
    let coarse = Format::signed(FACTOR.width() - FACTOR.frac_bits() - 1, bits);
    (code(coarse, value, &mut saturations.factor) << spare) as i32
}

/// What a record holds of a Gaussian.
#[derive(Debug, Clone, Copy)]
pub struct RecordForm {
    /// Fraction bits of factors.
    pub conic_bits: u32,
    /// The opacity, or its logarithm.
    pub opacity: SplatOpacity,
}

/// Factors with all fraction bits, and opacities as factors.
impl Default for RecordForm {
    fn default() -> Self {
        Self {
            conic_bits: FACTOR.frac_bits(),
            opacity: SplatOpacity::Multiplied,
        }
    }
}

/// The code of an opacity. An opacity below exp(-8) has the logarithm's largest code, with which nothing
/// counts; that is no saturation to be told.
fn opacity(value: f64, form: SplatOpacity, saturations: &mut Saturations) -> u16 {
    let code = match form {
        SplatOpacity::Multiplied => code(OPACITY, value, &mut saturations.opacity),
        SplatOpacity::InPower => code(LOG_OPACITY, -value.ln(), &mut 0),
    };
    code as u16
}

/// The record of a projected Gaussian of rank `rank`.
#[must_use]
pub fn record(
    splat: &Projected,
    rank: u32,
    form: RecordForm,
    saturations: &mut Saturations,
) -> SplatRecord {
    SplatRecord {
        mean: splat
            .mean
            .to_array()
            .map(|v| code(MEAN, v, &mut saturations.mean) as i32),
        factor: splat
            .footprint
            .factor
            .map(|v| factor(v, form.conic_bits, saturations)),
        opacity: opacity(splat.opacity, form.opacity, saturations),
        colour: splat
            .colour
            .to_array()
            .map(|v| code(COLOUR, v, &mut saturations.colour) as u16),
        rank,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Footprint;
    use glam::{DVec2, DVec3};

    /// Every opacity of 16 bits: the logarithm is off by half a unit at most, and what is too small for
    /// it is as small as can be.
    #[test]
    fn logarithms_of_opacities_are_the_nearest() {
        let form = RecordForm {
            opacity: SplatOpacity::InPower,
            ..RecordForm::default()
        };
        let mut s = Saturations::default();
        for code in 0..=u16::MAX {
            let opacity = f64::from(code) / 65_536.0;
            let of = Projected { opacity, ..splat() };
            let found = LOG_OPACITY.value(record(&of, 0, form, &mut s).opacity.into());
            let exact = -opacity.ln();
            let within = (found - exact).abs() <= LOG_OPACITY.ulp() / 2.0;
            let held = exact > 8.0 && found == LOG_OPACITY.value(LOG_OPACITY.max());
            assert!(within || held, "{opacity}: {found}");
        }
        assert_eq!(s, Saturations::default());
    }

    fn splat() -> Projected {
        Projected {
            index: 0,
            depth: 1.0,
            mean: DVec2::new(-3.25, 1000.5),
            footprint: Footprint::new(DVec3::new(2.0, 1.0, 0.0), DVec3::new(0.5, -3.0, 1.0), 0.3),
            opacity: 0.75,
            colour: DVec3::new(0.5, 2.83, 0.0),
        }
    }

    #[test]
    fn codes_are_the_nearest() {
        let mut s = Saturations::default();
        let r = record(&splat(), 7, RecordForm::default(), &mut s);
        assert_eq!(s, Saturations::default());
        assert_eq!(r.mean, [-13312, 4_098_048]);
        assert_eq!((r.opacity, r.rank), (49152, 7));
        assert_eq!(r.colour, [2048, 11592, 0]);
        for (code, value) in r.factor.into_iter().zip(splat().footprint.factor) {
            let off = (FACTOR.value(i128::from(code)) - value).abs();
            assert!(off <= FACTOR.ulp() / 2.0);
        }
    }

    #[test]
    fn what_does_not_fit_is_held_and_counted() {
        let mut s = Saturations::default();
        let far = Projected {
            mean: DVec2::new(1e300, -524_288.0),
            opacity: 1.0,
            colour: DVec3::new(16.0, 15.9999, 1e30),
            ..splat()
        };
        let r = record(&far, 0, RecordForm::default(), &mut s);
        assert_eq!(r.mean, [i32::MAX, i32::MIN]);
        assert_eq!(r.opacity, u16::MAX);
        assert_eq!(r.colour, [u16::MAX; 3]);
        // 15.9999 rounds to 16, 65536 codes.
        let expected = Saturations {
            mean: 1,
            factor: 0,
            opacity: 1,
            colour: 3,
        };
        assert_eq!(s, expected);
        assert_eq!(s.total(), 5);
    }

    /// Alpha at an offset from the mean, from factors.
    fn alpha(factor: [f64; 3], opacity: f64, d: DVec2) -> f64 {
        let (p, q) = (factor[0] * d.x + factor[1] * d.y, factor[2] * d.y);
        opacity * (-0.5 * (p * p + q * q)).exp()
    }

    #[test]
    fn records_keep_needles_that_a_16_bit_conic_breaks() {
        let (mut worst, mut worst_conic) = (0.0f64, 0.0f64);
        for i in 0..400 {
            let (s, c) = (f64::from(i) * 0.0393).sin_cos();
            let length = 3.0 * 1.02f64.powi(i);
            let footprint = Footprint::new(
                DVec3::new(length * c, 0.02, 0.0),
                DVec3::new(length * s, 0.0, 0.1),
                0.3,
            );
            let splat = Projected {
                footprint,
                mean: DVec2::new(311.013_7, 97.77),
                ..splat()
            };
            let r = record(
                &splat,
                0,
                RecordForm::default(),
                &mut Saturations::default(),
            );
            let mean = DVec2::from(r.mean.map(|m| MEAN.value(m.into())));
            let factor = r.factor.map(|l| FACTOR.value(l.into()));
            // The conic in 16 bits, on the scale of its largest entry.
            let [a, b, d] = footprint.factor;
            let conic = [a * a, a * b, b * b + d * d];
            let step = conic[0].max(conic[2]) / 32767.0;
            let coarse = conic.map(|v| (v / step).round() * step);
            for k in -40..=40 {
                let along = length * f64::from(k) / 20.0;
                let at = splat.mean + DVec2::new(along * c, along * s);
                if (at - splat.mean).length() > 500.0 {
                    continue;
                }
                let exact = splat.alpha(at - splat.mean);
                let kept = alpha(factor, OPACITY.value(r.opacity.into()), at - mean);
                worst = worst.max((kept - exact).abs());
                let o = at - splat.mean;
                let form =
                    coarse[0] * o.x * o.x + 2.0 * coarse[1] * o.x * o.y + coarse[2] * o.y * o.y;
                worst_conic = worst_conic.max((0.75 * (-0.5 * form).exp().min(1.0) - exact).abs());
            }
        }
        // Half a unit of the mean in both axes, at the steepest slope of a
        // Gaussian (e^-1/2 over the least sigma); 2^-31 x 500 of the factors;
        // 2^-17 of the opacity.
        let slope = (-0.5f64).exp() / 0.3f64.sqrt();
        let bound =
            slope * (2f64.sqrt() * 2f64.powi(-13) + 1500.0 * 2f64.powi(-31)) + 2f64.powi(-17);
        assert!(worst < bound, "{worst} {bound}");
        assert!(worst_conic > 0.3, "{worst_conic}");
    }
}
