//! DirectVoxGO in the hardware's formats.
//!
//! | step | unit | result |
//! |---|---|---|
//! | density, features | gathering | a format each, the finest that holds the grid |
//! | alpha | softplus, 1 - exp(-s) ([`crate::opacity`]) | U0.F |
//! | layers | MAC array, ReLU between them | 16 bits with a scale a layer |
//! | colour | sigmoid | U0.F |
//!
//! A direction and its sines and cosines are computed once a ray in floating point, and rounded to
//! the features' format.

use std::borrow::Cow;

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::units::{OpCode, VectorOp};

use super::Dvgo;
use crate::mac::MacMlp;
use crate::opacity::{Curve, Opacity, need, rescale};
use crate::quantisation::{finest, held, quantised};
use crate::volume::{MVoxels, Placement};
use crate::{CodedVolume, Field, FieldError, calibrate};
use potamoi_march::{Head, Lanes, MarchError, Opacities, TRANSMITTANCE};

/// A quantised model.
#[derive(Debug)]
pub(super) struct FixedDvgo {
    pub(super) volume: CodedVolume,
    pub(super) head: DvgoHead,
}

/// Fixed-point feature computation of DirectVoxGO.
#[derive(Debug)]
pub(super) struct DvgoHead {
    pub(super) channels: usize,
    pub(super) density_bits: u32,
    /// Fraction bits of features and directions, the inputs of the perceptron.
    pub(super) input_bits: u32,
    pub(super) opacity: Opacity,
    /// Fraction bits of the exponential's input.
    logit_bits: u32,
    least: [i32; 2],
    frequencies: Vec<f64>,
    pub(super) mlp: MacMlp,
}

impl Dvgo {
    /// Quantises the model for a configuration. The perceptron's scales come from a fixed set of
    /// positions and directions, spread evenly over the non-empty part of the box and over the
    /// sphere.
    ///
    /// # Errors
    /// The configuration's units lack an operation or have unsuitable formats, or a value fits no
    /// format.
    pub(super) fn fixed(&self, config: &Config) -> Result<FixedDvgo, FieldError> {
        need(config, &[OpCode::Relu, OpCode::Multiply, OpCode::Sigmoid])?;
        let curve = Curve::Softplus { shift: self.shift };
        let opacity = Opacity::new(curve, self.interval, config)?;
        let least = (self.least * 2f64.powi(opacity.alpha_bits() as i32)) as i32;
        let opacity = opacity.with_least(least, config);
        let [table] = &self.tables;
        let channels = table.channels();
        let bits = config.gu.feature_bits;
        let density_bits = finest(table.values().iter().step_by(channels), bits, "density")?;
        let features = table.values().iter().enumerate();
        let features = features.filter(|(i, _)| i % channels != 0).map(|(_, v)| v);
        // Directions, up to 1, share the scale.
        let input_bits = finest(features.chain([&1.0]), bits, "features")?;
        let code = |(i, v): (usize, &f32)| {
            let frac = if i % channels == 0 {
                density_bits
            } else {
                input_bits
            };
            quantised(*v, bits, frac)
        };
        let codes: Vec<i16> = table.values().iter().enumerate().map(code).collect();
        let mvoxels = MVoxels::of_codes(table.points(), channels, &codes, config, |_| true)?;
        let mvoxels = match &self.mask {
            Some(mask) => mvoxels.masked(mask.clone()),
            None => mvoxels,
        };
        let [largest, _] = self
            .magnitudes
            .or_find(|| [self.found_magnitudes(), vec![]]);
        Ok(FixedDvgo {
            volume: CodedVolume {
                mvoxels,
                placement: self.placement(),
                step: self.spacing_of_steps,
            },
            head: DvgoHead {
                channels,
                density_bits,
                input_bits,
                logit_bits: config.vu.exp.input.frac_bits(),
                least: [
                    least,
                    (self.least * 2f64.powi(TRANSMITTANCE.frac_bits() as i32)) as i32,
                ],
                opacity,
                frequencies: self.frequencies.clone(),
                mlp: MacMlp::quantise(&self.mlp, input_bits as i32, largest)?,
            },
        })
    }

    fn placement(&self) -> Placement {
        let points = self.tables[0].points();
        let last = DVec3::from(points.map(|p| (p - 1) as f64));
        Placement {
            points,
            corner: self.bounds[0],
            spacing: (self.bounds[1] - self.bounds[0]) / last,
            edge: self.step / self.spacing_of_steps,
            range: self.sampling().range,
        }
    }

    /// The largest magnitude of each layer's outputs on the calibration set.
    fn found_magnitudes(&self) -> Vec<f64> {
        let mut largest = vec![0f64; self.mlp.layers().len()];
        let mut inputs = vec![];
        calibrate::visit(self, |features, alpha, direction| {
            if alpha > self.least {
                self.inputs(features, direction, &mut inputs);
                self.mlp.run_watched(&mut inputs, |layer, value| {
                    largest[layer] = largest[layer].max(value.abs());
                });
            }
        });
        largest
    }
}

impl Head for DvgoHead {
    fn channels(&self) -> usize {
        self.channels
    }

    fn alpha_bits(&self) -> u32 {
        self.opacity.alpha_bits()
    }

    fn colour_bits(&self) -> u32 {
        self.opacity.alpha_bits()
    }

    fn least(&self) -> [i32; 2] {
        self.least
    }

    fn operations(&self) -> Vec<OpCode> {
        [
            vec![OpCode::Relu, OpCode::Multiply, OpCode::Sigmoid],
            self.opacity.operations(),
        ]
        .concat()
    }

    fn direction_codes(&self) -> usize {
        3 + 6 * self.frequencies.len()
    }

    fn encode(&self, direction: DVec3, out: &mut Vec<i16>) {
        let mut inputs = vec![];
        super::encode(direction, &self.frequencies, &mut inputs);
        let scale = 2f64.powi(self.input_bits as i32);
        out.extend(inputs.iter().map(|v| held(v * scale)));
    }

    fn opacities<'f>(
        &self,
        features: &'f [i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Opacities<'f>, MarchError> {
        let density = features.chunks_exact(self.channels);
        let density: Vec<i32> = density.map(|f| i32::from(f[0])).collect();
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
        let samples = kept.chunks_exact(self.channels);
        let encoded = directions.chunks_exact(self.direction_codes());
        let mut inputs: Vec<i16> = Vec::with_capacity(kept.len() + directions.len());
        for (features, direction) in samples.zip(encoded) {
            inputs.extend_from_slice(&features[1..]);
            inputs.extend_from_slice(direction);
        }
        drop(kept);
        let sums = self.mlp.run(inputs, lanes)?;
        let logits = rescale(&sums, self.mlp.output_frac(), self.logit_bits, lanes)?;
        lanes.compute_with(VectorOp::new(OpCode::Sigmoid), &logits, 0)
    }
}
