//! Error bounds of EfficientNeRF in fixed point.

use glam::DVec3;
use potamoi_formats::config::Config;

use super::fixed::{BASIS_BITS, EfficientHead, head};
use super::{CHANNELS, COEFFICIENTS, EfficientNerf};
use crate::FieldError;
use crate::bound::{Bounds, ErrorInterval, UnitErrors};
use potamoi_base::sh;
use potamoi_march::Head as _;
use potamoi_reference::bounds::VectorBounds;

pub(super) struct EfficientBounds {
    head: EfficientHead,
    frac_bits: [Vec<u32>; 1],
    errors: UnitErrors,
}

pub(super) fn bounds(
    field: &EfficientNerf,
    config: &Config,
    vector: &VectorBounds,
) -> Result<EfficientBounds, FieldError> {
    let head = head(field, config)?;
    Ok(EfficientBounds {
        frac_bits: [head.frac_bits()],
        errors: UnitErrors::of(config, vector),
        head,
    })
}

impl Bounds for EfficientBounds {
    fn frac_bits(&self) -> &[Vec<u32>] {
        &self.frac_bits
    }

    fn alpha(&self, features: &[f64], off: &[ErrorInterval]) -> f64 {
        let bits = self.head.density_bits as i32;
        self.head
            .opacity
            .off(&self.errors, features[0], off[0], bits)
    }

    fn colour(&self, features: &[f64], off: &[ErrorInterval], direction: DVec3) -> f64 {
        let mut codes = vec![];
        self.head.encode(direction, &mut codes);
        let scale = 2f64.powi(BASIS_BITS as i32);
        let basis = sh::basis(direction);
        let colours = features[1..CHANNELS].chunks_exact(COEFFICIENTS);
        let colours = colours
            .zip(off[1..].chunks_exact(COEFFICIENTS))
            .map(|(own, off)| {
                let mut logit = 0.0;
                let mut sum = ErrorInterval::default();
                for ((value, off), (exact, code)) in
                    own.iter().zip(off).zip(basis.iter().zip(&codes))
                {
                    let of_basis = ErrorInterval::exactly(f64::from(*code) / scale - exact);
                    logit += value * exact;
                    sum = sum + ErrorInterval::product([*value, *exact], [*off, of_basis]);
                }
                let bits = (self.head.coefficient_bits + BASIS_BITS) as i32;
                self.errors.logistic(logit, sum, bits)
            });
        colours.fold(0.0, f64::max)
    }
}
