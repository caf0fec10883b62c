//! TensoRF in the hardware's formats.
//!
//! | step | unit | result |
//! |---|---|---|
//! | components | gathering | a format a table for density, one for appearance |
//! | products of planes and lines | multiply, half even | a format each for density, appearance |
//! | their sum, density | MAC array, weights of 1, exact | 32 bits |
//! | alpha | softplus or ReLU, 1 - exp(-s) (`fields::opacity`) | U0.F |
//! | features | MAC array, of the products of appearance | 16 bits |
//! | sines and cosines of features | a table, to nearest | the format of the features |
//! | colour | MAC array, sigmoid | U0.F |
//!
//! No product and no sum of products can overflow. Their formats follow from the largest component
//! of each table, which interpolation does not exceed.

use std::borrow::Cow;

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::units::{OpCode, VectorOp};

use super::{Activation, Tensorf, encode};
use crate::gather_plan::finest_of;
use crate::mac::MacMlp;
use crate::opacity::{Curve, Opacity, multiply, need, rescale};
use crate::quantisation::held;
use crate::{Field as _, FieldError, QuantisedField, calibrate};
use potamoi_march::{Head, Lanes, MarchError, Opacities, TRANSMITTANCE};
use potamoi_reference::Product;

/// The magnitude of a sum is below two to this power.
const SUM_BITS: i32 = 30;
/// Minimum range of the features' format, which they share with sines, at most 1.
const LEAST_RANGE: f64 = 1.0;

/// The components of one mode: their positions in a sample's features.
pub(super) struct Mode {
    pub(super) plane: usize,
    pub(super) line: usize,
    pub(super) channels: usize,
    pub(super) density: usize,
    /// Fraction bits of a product, of density and of appearance.
    pub(super) frac_bits: [u32; 2],
}

/// Fixed-point feature computation of TensoRF.
pub(super) struct TensorfHead {
    channels: usize,
    pub(super) modes: [Mode; 3],
    /// Fraction bits of stored products, of density and of appearance.
    pub(super) product_bits: [u32; 2],
    pub(super) opacity: Opacity,
    pub(super) basis: MacMlp,
    pub(super) mlp: MacMlp,
    frequencies: [usize; 2],
    least_weight: i32,
    /// Fraction bits of the exponential's input.
    logit_bits: u32,
}

/// A field with its fixed-point feature computation and formats.
pub(super) fn coded<'a>(
    field: &Tensorf,
    config: &Config,
) -> Result<QuantisedField<'a>, FieldError> {
    let (frac_bits, head) = head(field, config)?;
    Ok(QuantisedField::in_tables(frac_bits, Box::new(head)))
}

/// Fraction bits of the codes of each table, and the head.
pub(super) fn head(
    field: &Tensorf,
    config: &Config,
) -> Result<(Vec<Vec<u32>>, TensorfHead), FieldError> {
    need(config, &[OpCode::Relu, OpCode::Multiply, OpCode::Sigmoid])?;
    let tables = &field.tables;
    let bits = |number: usize, appearance: bool| {
        let density = field.density[number % 3];
        let own = |channel: usize| (channel >= density) == appearance;
        finest_of([&tables[number]], own, config, "components")
    };
    let bits: Vec<[u32; 2]> = (0..6)
        .map(|number| Ok([bits(number, false)?, bits(number, true)?]))
        .collect::<Result<_, FieldError>>()?;
    let mut from = 0;
    let starts = [0, 1, 2, 3, 4, 5].map(|number| {
        from += tables[number].channels();
        from - tables[number].channels()
    });
    let modes = [0, 1, 2].map(|m| Mode {
        plane: starts[m],
        line: starts[3 + m],
        channels: tables[m].channels(),
        density: field.density[m],
        frac_bits: [0, 1].map(|kind| bits[m][kind] + bits[3 + m][kind]),
    });
    let product_bits = product_bits(field, &modes);
    let [features, sums] = field.magnitudes.or_find(|| magnitudes(field));
    let appearance_bits = product_bits[1] as i32;
    let basis = MacMlp::quantise(&field.basis, appearance_bits, features)?;
    let mlp = MacMlp::quantise(&field.mlp, basis.output_frac(), sums)?;
    let curve = match field.rules.activation {
        Activation::Softplus => Curve::Softplus {
            shift: field.rules.density_shift,
        },
        Activation::Relu => Curve::Relu,
    };
    let interval = field.step() * field.rules.distance_scale;
    let weight = field.rules.weight_threshold * 2f64.powi(TRANSMITTANCE.frac_bits() as i32);
    let frac_bits = tables.iter().zip(&bits).enumerate();
    let frac_bits = frac_bits.map(|(number, (table, bits))| {
        let density = field.density[number % 3];
        let of = |channel| bits[usize::from(channel >= density)];
        (0..table.channels()).map(of).collect()
    });
    let head = TensorfHead {
        channels: field.channels(),
        modes,
        product_bits,
        opacity: Opacity::new(curve, interval, config)?,
        basis,
        mlp,
        frequencies: [
            field.rules.feature_frequencies,
            field.rules.view_frequencies,
        ],
        least_weight: weight as i32,
        logit_bits: config.vu.exp.input.frac_bits(),
    };
    Ok((frac_bits.collect(), head))
}

/// The largest number of fraction bits with which the sum of all density products, and every
/// product of appearance, fit their formats; at most that of the products.
fn product_bits(field: &Tensorf, modes: &[Mode; 3]) -> [u32; 2] {
    let largest = |number: usize, appearance: bool| {
        let density = field.density[number % 3];
        let table = &field.tables[number];
        let rows = table.values().chunks_exact(table.channels());
        let own = rows.flat_map(|row| {
            if appearance {
                &row[density..]
            } else {
                &row[..density]
            }
        });
        own.fold(0f64, |most, v| most.max(f64::from(v.abs())))
    };
    let product = |m: usize, appearance| largest(m, appearance) * largest(3 + m, appearance);
    let sum: f64 = (0..3)
        .map(|m| field.density[m] as f64 * product(m, false))
        .sum();
    let one = (0..3).map(|m| product(m, true)).fold(0.0, f64::max);
    let most = |value: f64, bits: i32, kind: usize| {
        // Half a code more than the exact product, and a code of each table.
        let fits = |frac: &i32| value * 2f64.powi(*frac) < 2f64.powi(bits) * 0.99 - 1.0;
        let own = modes.iter().map(|m| m.frac_bits[kind] as i32).min();
        (0..=own.unwrap_or(0)).rev().find(fits).unwrap_or(0) as u32
    };
    [most(sum, SUM_BITS, 0), most(one, 15, 1)]
}

/// The largest magnitude of the features, and of each layer's outputs of the perceptron, on the
/// calibration set.
fn magnitudes(field: &Tensorf) -> [Vec<f64>; 2] {
    let mut features = LEAST_RANGE;
    let mut sums = vec![0f64; field.mlp.layers().len()];
    let mut values = vec![];
    calibrate::visit(field, |gathered, alpha, direction| {
        if alpha > calibrate::SEEN_FROM {
            field.appearance(gathered, &mut values);
            features = values.iter().fold(features, |most, v| most.max(v.abs()));
            field.inputs(direction, &mut values);
            field.mlp.run_watched(&mut values, |layer, value| {
                sums[layer] = sums[layer].max(value.abs());
            });
        }
    });
    [vec![features], sums]
}

impl TensorfHead {
    /// Products of planes and lines, of density or of appearance, as they are stored: sample after
    /// sample, mode after mode.
    fn products<T: Copy + Default>(
        &self,
        features: &[i16],
        kind: usize,
        stored: impl Fn(i32) -> T,
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<T>, MarchError> {
        let samples = features.len() / self.channels;
        let own = self.modes.each_ref().map(|mode| match kind {
            0 => 0..mode.density,
            _ => mode.density..mode.channels,
        });
        let width: usize = own.iter().map(std::ops::Range::len).sum();
        let mut products = vec![T::default(); samples * width];
        let mut first = 0;
        for (mode, own) in self.modes.iter().zip(own) {
            let take = |from: usize| -> Vec<i32> {
                let rows = features.chunks_exact(self.channels);
                let picked = rows.flat_map(|row| &row[from + own.start..from + own.end]);
                picked.map(|code| i32::from(*code)).collect()
            };
            let down = mode.frac_bits[kind] - self.product_bits[kind];
            let found = lanes.compute(multiply(down), &take(mode.plane), &take(mode.line))?;
            let rows = products.chunks_exact_mut(width);
            for (row, found) in rows.zip(found.chunks_exact(own.len().max(1))) {
                let to = &mut row[first..first + own.len()];
                to.iter_mut()
                    .zip(found)
                    .for_each(|(to, one)| *to = stored(*one));
            }
            first += own.len();
        }
        Ok(products)
    }
}

impl Head for TensorfHead {
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
        [0, self.least_weight]
    }

    fn operations(&self) -> Vec<OpCode> {
        [
            vec![OpCode::Relu, OpCode::Multiply, OpCode::Sigmoid],
            self.opacity.operations(),
        ]
        .concat()
    }

    fn direction_codes(&self) -> usize {
        3 + 6 * self.frequencies[1]
    }

    fn encode(&self, direction: DVec3, out: &mut Vec<i16>) {
        let mut values = direction.to_array().to_vec();
        encode(0..3, self.frequencies[1], &mut values);
        let scale = 2f64.powi(self.basis.output_frac());
        out.extend(values.iter().map(|v| held(v * scale)));
    }

    fn opacities<'f>(
        &self,
        features: &'f [i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Opacities<'f>, MarchError> {
        let products = self.products(features, 0, |product| product, lanes)?;
        let width: usize = self.modes.iter().map(|mode| mode.density).sum();
        let sums = Product {
            rows: (products.len() / width.max(1)) as u64,
            depth: width as u64,
            columns: 1,
        };
        lanes.multiply(sums, 0);
        let sums = products.chunks_exact(width).map(|own| own.iter().sum());
        let sums: Vec<i32> = sums.collect();
        let bits = self.product_bits[0] as i32;
        Ok(Opacities {
            alpha: self.opacity.alphas(&sums, bits, lanes)?,
            kept: Cow::Borrowed(features),
        })
    }

    fn colours(
        &self,
        kept: Vec<i16>,
        directions: &[i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError> {
        // Their format leaves them 16 bits.
        let products = self.products(&kept, 1, |product| product as i16, lanes)?;
        drop(kept);
        let features = self.basis.run(products, lanes)?;
        let scale = 2f64.powi(self.basis.output_frac());
        let samples = features.len() / self.basis.outputs();
        let mut inputs = Vec::with_capacity(samples * self.mlp.layers()[0].inputs());
        let mut values = vec![];
        let samples = features.chunks_exact(self.basis.outputs());
        let encoded = directions.chunks_exact(self.direction_codes());
        for (features, direction) in samples.zip(encoded) {
            values.clear();
            values.extend(features.iter().map(|code| f64::from(*code) / scale));
            encode(0..features.len(), self.frequencies[0], &mut values);
            let waves = &values[features.len()..];
            lanes.count_waves(waves.len() as u64);
            inputs.extend(features.iter().map(|code| *code as i16));
            inputs.extend_from_slice(&direction[..3]);
            inputs.extend(waves.iter().map(|v| held(v * scale)));
            inputs.extend_from_slice(&direction[3..]);
        }
        let sums = self.mlp.run(inputs, lanes)?;
        let logits = rescale(&sums, self.mlp.output_frac(), self.logit_bits, lanes)?;
        lanes.compute_with(VectorOp::new(OpCode::Sigmoid), &logits, 0)
    }
}
