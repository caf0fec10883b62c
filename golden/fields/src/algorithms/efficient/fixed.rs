//! EfficientNeRF in the hardware's formats.
//!
//! | step | unit | result |
//! |---|---|---|
//! | features | gathering, ids alone | a format for densities, one for coefficients |
//! | alpha | softplus, 1 - exp(-s) (`fields::opacity`) | U0.F |
//! | logits | MAC array: nine products a colour, exact, half even | the exponential's input |
//! | colour | sigmoid | U0.F |

use std::borrow::Cow;

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::fixed::{Rounding, round_shift};
use potamoi_formats::units::{OpCode, VectorOp};

use super::{CHANNELS, COEFFICIENTS, EfficientNerf, LEAST_WEIGHT, STEP};
use crate::gather_plan::finest_of;
use crate::opacity::{Curve, Opacity, need};
use crate::quantisation::held;
use crate::{FieldError, QuantisedField};
use potamoi_base::sh;
use potamoi_march::{Head, Lanes, MarchError, Opacities, TRANSMITTANCE};
use potamoi_reference::Product;

/// Fraction bits of spherical harmonics, which are below 2.
pub(super) const BASIS_BITS: u32 = 14;

/// Fixed-point feature computation of EfficientNeRF.
pub(super) struct EfficientHead {
    pub(super) density_bits: u32,
    pub(super) coefficient_bits: u32,
    pub(super) opacity: Opacity,
    /// Fraction bits of the exponential's input.
    logit_bits: u32,
}

pub(super) fn coded<'a>(
    field: &EfficientNerf,
    config: &Config,
) -> Result<QuantisedField<'a>, FieldError> {
    let head = head(field, config)?;
    Ok(QuantisedField::in_tables(
        vec![head.frac_bits()],
        Box::new(head),
    ))
}

pub(super) fn head(field: &EfficientNerf, config: &Config) -> Result<EfficientHead, FieldError> {
    need(config, &[OpCode::Sigmoid])?;
    Ok(EfficientHead {
        density_bits: finest_of(&field.tables, |c| c == 0, config, "density")?,
        coefficient_bits: finest_of(&field.tables, |c| c > 0, config, "coefficients")?,
        opacity: Opacity::new(Curve::Softplus { shift: 0.0 }, STEP, config)?,
        logit_bits: config.vu.exp.input.frac_bits(),
    })
}

impl EfficientHead {
    /// Fraction bits of each channel's codes.
    pub(super) fn frac_bits(&self) -> Vec<u32> {
        let mut frac_bits = vec![self.coefficient_bits; CHANNELS];
        frac_bits[0] = self.density_bits;
        frac_bits
    }
}

impl Head for EfficientHead {
    fn channels(&self) -> usize {
        CHANNELS
    }

    fn alpha_bits(&self) -> u32 {
        self.opacity.alpha_bits()
    }

    fn colour_bits(&self) -> u32 {
        self.opacity.alpha_bits()
    }

    fn least(&self) -> [i32; 2] {
        let weight = LEAST_WEIGHT * 2f64.powi(TRANSMITTANCE.frac_bits() as i32);
        [0, weight as i32]
    }

    fn operations(&self) -> Vec<OpCode> {
        [vec![OpCode::Sigmoid], self.opacity.operations()].concat()
    }

    fn direction_codes(&self) -> usize {
        COEFFICIENTS
    }

    fn encode(&self, direction: DVec3, out: &mut Vec<i16>) {
        let scale = 2f64.powi(BASIS_BITS as i32);
        let basis = &sh::basis(direction)[..COEFFICIENTS];
        out.extend(basis.iter().map(|v| held(v * scale)));
    }

    fn opacities<'f>(
        &self,
        features: &'f [i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Opacities<'f>, MarchError> {
        let density = features.iter().step_by(CHANNELS);
        let density: Vec<i32> = density.map(|code| i32::from(*code)).collect();
        let bits = self.density_bits as i32;
        Ok(Opacities {
            alpha: self.opacity.alphas(&density, bits, lanes)?,
            kept: Cow::Borrowed(features),
        })
    }

    fn colours(
        &self,
        kept: Vec<i16>,
        directions: &[i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError> {
        let from = self.coefficient_bits + BASIS_BITS;
        let down = from.saturating_sub(self.logit_bits);
        let up = self.logit_bits.saturating_sub(from);
        let samples = kept.as_chunks::<CHANNELS>().0;
        let mut logits = Vec::with_capacity(3 * samples.len());
        for (features, basis) in samples.iter().zip(directions.as_chunks::<COEFFICIENTS>().0) {
            for own in features[1..].as_chunks::<COEFFICIENTS>().0 {
                let products = own.iter().zip(basis);
                // Nine products of 16 bits: below 2^34.
                let sum: i64 = products.map(|(a, b)| i64::from(*a) * i64::from(*b)).sum();
                let logit = round_shift(i128::from(sum) << up, down, Rounding::HalfEven);
                logits.push(logit.clamp(i32::MIN.into(), i32::MAX.into()) as i32);
            }
        }
        let sums = Product {
            rows: logits.len() as u64,
            depth: COEFFICIENTS as u64,
            columns: 1,
        };
        lanes.multiply(sums, 0);
        lanes.compute_with(VectorOp::new(OpCode::Sigmoid), &logits, 0)
    }
}
