//! Error bounds of Instant-NGP in fixed point.

use glam::DVec3;
use potamoi_formats::config::Config;

use super::fixed::{NgpHead, head};
use super::{Ngp, cycled};
use crate::FieldError;
use crate::bound::{Bounds, ErrorInterval, Pair, UnitErrors};
use potamoi_base::sh;
use potamoi_march::Head as _;
use potamoi_reference::bounds::VectorBounds;

pub(super) struct NgpBounds {
    head: NgpHead,
    frac_bits: Vec<Vec<u32>>,
    density: Pair,
    colour: Pair,
    errors: UnitErrors,
}

pub(super) fn bounds(
    field: &Ngp,
    config: &Config,
    vector: &VectorBounds,
) -> Result<NgpBounds, FieldError> {
    let (frac_bits, head) = head(field, config)?;
    Ok(NgpBounds {
        density: Pair::new(&field.density, &head.density),
        colour: Pair::new(&field.colour, &head.colour),
        errors: UnitErrors::of(config, vector),
        frac_bits,
        head,
    })
}

impl Bounds for NgpBounds {
    fn frac_bits(&self) -> &[Vec<u32>] {
        &self.frac_bits
    }

    fn alpha(&self, features: &[f64], off: &[ErrorInterval]) -> f64 {
        let latents = self.density.outputs(features, off);
        let bits = self.head.density.output_frac();
        let (first, off) = (latents.values[0], latents.off[0]);
        self.head.opacity.off(&self.errors, first, off, bits)
    }

    fn colour(&self, features: &[f64], off: &[ErrorInterval], direction: DVec3) -> f64 {
        let mut inputs = self.density.outputs(features, off);
        let mut codes = vec![];
        self.head.encode(direction, &mut codes);
        let scale = 2f64.powi(self.head.density.output_frac());
        for (code, exact) in codes.iter().zip(sh::basis(cycled(direction))) {
            inputs.values.push(exact);
            inputs
                .off
                .push(ErrorInterval::exactly(f64::from(*code) / scale - exact));
        }
        let logits = self.colour.outputs(&inputs.values, &inputs.off);
        self.errors.colours(&logits, self.head.colour.output_frac())
    }
}
