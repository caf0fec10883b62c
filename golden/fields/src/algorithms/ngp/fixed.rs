//! Instant-NGP in the hardware's formats.
//!
//! | step | unit | result |
//! |---|---|---|
//! | features | gathering | one format for all levels, the finest that holds them |
//! | latents | MAC array, ReLU between layers | 16 bits with a scale a layer |
//! | alpha | exp of the first latent, 1 - exp(-s) (`fields::opacity`) | U0.F |
//! | colour | MAC array, sigmoid | U0.F |
//!
//! The spherical harmonics of a direction are computed once a ray in floating point, and rounded
//! to the format of the latents.

use std::borrow::Cow;

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::units::{OpCode, VectorOp};

use super::{Ngp, STEP, cycled};
use crate::gather_plan::finest_of;
use crate::mac::MacMlp;
use crate::opacity::{Curve, Opacity, need, rescale};
use crate::quantisation::held;
use crate::{Field as _, FieldError, QuantisedField, calibrate};
use potamoi_base::sh;
use potamoi_march::{Head, Lanes, MarchError, Opacities};

/// Minimum range of the latents' format, which they share with the spherical harmonics, below 2.
const LEAST_RANGE: f64 = 2.0;

/// Fixed-point feature computation of Instant-NGP.
pub(super) struct NgpHead {
    channels: usize,
    pub(super) density: MacMlp,
    pub(super) colour: MacMlp,
    pub(super) opacity: Opacity,
    /// Fraction bits of the exponential's input.
    logit_bits: u32,
}

/// A field with its fixed-point feature computation and formats.
pub(super) fn coded<'a>(field: &Ngp, config: &Config) -> Result<QuantisedField<'a>, FieldError> {
    let (frac_bits, head) = head(field, config)?;
    Ok(QuantisedField::in_tables(frac_bits, Box::new(head)))
}

/// Fraction bits of the codes of each table, and the head.
pub(super) fn head(field: &Ngp, config: &Config) -> Result<(Vec<Vec<u32>>, NgpHead), FieldError> {
    need(config, &[OpCode::Relu, OpCode::Multiply, OpCode::Sigmoid])?;
    let frac = finest_of(&field.tables, |_| true, config, "features")?;
    let [latents, shades] = field.magnitudes.or_find(|| magnitudes(field));
    let density = MacMlp::quantise(&field.density, frac as i32, latents)?;
    let colour = MacMlp::quantise(&field.colour, density.output_frac(), shades)?;
    let channels = field.shape.features as usize;
    let head = NgpHead {
        channels: field.channels(),
        density,
        colour,
        opacity: Opacity::new(Curve::Exp, STEP, config)?,
        logit_bits: config.vu.exp.input.frac_bits(),
    };
    Ok((vec![vec![frac; channels]; field.tables.len()], head))
}

/// The largest magnitude of each layer's outputs on the calibration set, for both perceptrons.
fn magnitudes(field: &Ngp) -> [Vec<f64>; 2] {
    let mut density = vec![0f64; field.density.layers().len()];
    let mut colour = vec![0f64; field.colour.layers().len()];
    let mut values = vec![];
    calibrate::visit(field, |features, alpha, direction| {
        values.clear();
        values.extend_from_slice(features);
        field.density.run_watched(&mut values, |layer, value| {
            density[layer] = density[layer].max(value.abs());
        });
        if alpha > calibrate::SEEN_FROM {
            values.extend(sh::basis(cycled(direction)));
            field.colour.run_watched(&mut values, |layer, value| {
                colour[layer] = colour[layer].max(value.abs());
            });
        }
    });
    if let Some(last) = density.last_mut() {
        *last = last.max(LEAST_RANGE);
    }
    [density, colour]
}

impl Head for NgpHead {
    fn channels(&self) -> usize {
        self.channels
    }

    fn alpha_bits(&self) -> u32 {
        self.opacity.alpha_bits()
    }

    fn colour_bits(&self) -> u32 {
        self.opacity.alpha_bits()
    }

    fn kept(&self) -> usize {
        self.density.outputs()
    }

    fn operations(&self) -> Vec<OpCode> {
        [
            vec![OpCode::Relu, OpCode::Multiply, OpCode::Sigmoid],
            self.opacity.operations(),
        ]
        .concat()
    }

    fn direction_codes(&self) -> usize {
        sh::basis(DVec3::X).len()
    }

    fn encode(&self, direction: DVec3, out: &mut Vec<i16>) {
        let scale = 2f64.powi(self.density.output_frac());
        let basis = sh::basis(cycled(direction));
        out.extend(basis.iter().map(|v| held(v * scale)));
    }

    fn opacities<'f>(
        &self,
        features: &'f [i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Opacities<'f>, MarchError> {
        let latents = self.density.run(features.to_vec(), lanes)?;
        let first = latents.iter().step_by(self.kept());
        let first: Vec<i32> = first.copied().collect();
        let alpha = self
            .opacity
            .alphas(&first, self.density.output_frac(), lanes)?;
        Ok(Opacities {
            alpha,
            // Sums were held within 16 bits.
            kept: Cow::Owned(latents.iter().map(|v| *v as i16).collect()),
        })
    }

    fn colours(
        &self,
        kept: Vec<i16>,
        directions: &[i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError> {
        let samples = kept.chunks_exact(self.kept());
        let encoded = directions.chunks_exact(self.direction_codes());
        let inputs = samples.zip(encoded).flat_map(|(a, b)| a.iter().chain(b));
        let inputs = inputs.copied().collect();
        drop(kept);
        let sums = self.colour.run(inputs, lanes)?;
        let logits = rescale(&sums, self.colour.output_frac(), self.logit_bits, lanes)?;
        lanes.compute_with(VectorOp::new(OpCode::Sigmoid), &logits, 0)
    }
}
