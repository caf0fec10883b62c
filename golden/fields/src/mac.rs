//! Perceptrons in the formats of the MAC array: activations and weights of 16
//! bits with one power-of-two scale a layer, exact sums of 32.
//!
//! A scale is the finest at which an output's weights and bias cannot carry the sum past 31 bits
//! for any inputs: overflow is impossible, not clamped. Between layers sums are rounded once, half
//! to even, and saturate at 16 bits; saturation is counted.

use potamoi_formats::units::{OpCode, VectorOp};
use rayon::prelude::*;

use super::{FieldError, Layer, Mlp};
use potamoi_march::{Lanes, MarchError};
use potamoi_reference::Product;

/// Bits of activations and weights.
const CODE_BITS: u32 = 16;
/// Upper limit of a sum's magnitude, exclusive.
const SUM_LIMIT: i64 = 1 << 31;
/// Range of fraction bits of a scale.
const FRACTIONS: std::ops::RangeInclusive<i32> = -8..=30;

/// One layer in codes.
#[derive(Debug, Clone, PartialEq)]
pub struct MacLayer {
    inputs: usize,
    weights: Vec<i16>,
    /// Biases at the scale of the sum.
    bias: Vec<i32>,
    /// Bits that a sum loses when it becomes a code of the next layer.
    shift: u32,
    /// Fraction bits of weights and of outputs.
    weight_frac: i32,
    output_frac: i32,
}

/// A quantised perceptron.
#[derive(Debug, Clone, PartialEq)]
pub struct MacMlp {
    layers: Vec<MacLayer>,
    input_frac: i32,
}

impl MacMlp {
    /// Quantises `mlp` for inputs of `input_frac` fraction bits. `largest` is the magnitude that
    /// each layer's outputs must be able to hold, measured by running the perceptron on samples.
    ///
    /// # Errors
    /// The number of magnitudes is not the number of layers, or no scale holds a layer's weights
    /// or outputs.
    pub fn quantise(mlp: &Mlp, input_frac: i32, largest: &[f64]) -> Result<Self, FieldError> {
        if largest.len() != mlp.layers().len() {
            return Err(FieldError::Part {
                part: "calibration",
                found: format!("{} magnitudes", largest.len()),
                expected: format!("one a layer, {}", mlp.layers().len()),
            });
        }
        let mut layers = vec![];
        let mut frac = input_frac;
        for (number, (layer, largest)) in mlp.layers().iter().zip(largest).enumerate() {
            let made = MacLayer::quantise(layer, frac, *largest);
            let made = made.ok_or_else(|| FieldError::Part {
                part: "layer",
                found: format!("layer {number}, outputs up to {largest}"),
                expected: "weights and outputs that a scale of 2^-30 to 2^8 holds".to_owned(),
            })?;
            frac = made.output_frac;
            layers.push(made);
        }
        Ok(Self { layers, input_frac })
    }

    /// Evaluates consecutive samples: layers in the MAC array, ReLU between them in the vector
    /// unit. The results fit 16 bits.
    ///
    /// # Errors
    /// A unit fails.
    pub fn run(&self, mut inputs: Vec<i16>, lanes: &mut Lanes<'_>) -> Result<Vec<i32>, MarchError> {
        let mut sums = vec![];
        for (i, layer) in self.layers.iter().enumerate() {
            sums.clear();
            let held = layer.run(&inputs, &mut sums);
            let product = Product {
                rows: (inputs.len() / layer.inputs()) as u64,
                depth: layer.inputs() as u64,
                columns: layer.outputs() as u64,
            };
            lanes.multiply(product, held);
            if i + 1 < self.layers.len() {
                let positive = lanes.compute_with(VectorOp::new(OpCode::Relu), &sums, 0)?;
                inputs.clear();
                // Sums were held within 16 bits.
                inputs.extend(positive.iter().map(|v| *v as i16));
            }
        }
        Ok(sums)
    }

    /// The layers.
    #[must_use]
    pub fn layers(&self) -> &[MacLayer] {
        &self.layers
    }

    /// Number of outputs of the last layer.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.layers.last().map_or(0, MacLayer::outputs)
    }

    /// Fraction bits of the inputs.
    #[must_use]
    pub(crate) const fn input_frac(&self) -> i32 {
        self.input_frac
    }

    /// Fraction bits of the last layer's outputs.
    #[must_use]
    pub fn output_frac(&self) -> i32 {
        self.layers
            .last()
            .map_or(self.input_frac, |l| l.output_frac)
    }
}

impl MacLayer {
    fn quantise(layer: &Layer, input_frac: i32, largest: f64) -> Option<Self> {
        let most = f64::from(i16::MAX);
        let output_frac = FRACTIONS.rev().find(|f| largest * 2f64.powi(*f) <= most)?;
        FRACTIONS.rev().find_map(|weight_frac| {
            let shift = u32::try_from(weight_frac + input_frac - output_frac).ok()?;
            let code = |v: &f32| {
                let code = (f64::from(*v) * 2f64.powi(weight_frac)).round_ties_even();
                (code.abs() <= most).then_some(code as i16)
            };
            let weights: Vec<i16> = layer.weights().iter().map(code).collect::<Option<_>>()?;
            let scale = 2f64.powi(weight_frac + input_frac);
            let bias = layer.bias().iter().map(|b| {
                let code = (f64::from(*b) * scale).round_ties_even();
                (code.abs() < SUM_LIMIT as f64).then_some(code as i32)
            });
            let bias: Vec<i32> = bias.collect::<Option<_>>()?;
            let rows = weights.chunks_exact(layer.inputs());
            let fits = rows.zip(&bias).all(|(row, bias)| {
                let total: i64 = row.iter().map(|w| i64::from(*w).abs()).sum();
                (total << (CODE_BITS - 1)) + i64::from(*bias).abs() < SUM_LIMIT
            });
            (fits && shift < 48).then_some(Self {
                inputs: layer.inputs(),
                weights,
                bias,
                shift,
                weight_frac,
                output_frac,
            })
        })
    }

    /// Number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.bias.len()
    }

    /// Number of inputs.
    #[must_use]
    pub const fn inputs(&self) -> usize {
        self.inputs
    }

    /// Codes of the weights, a row of inputs for each output.
    #[must_use]
    pub fn weights(&self) -> &[i16] {
        &self.weights
    }

    /// Codes of the biases, at the scale of the sums.
    pub(super) fn bias(&self) -> &[i32] {
        &self.bias
    }

    /// Fraction bits of the outputs.
    #[must_use]
    pub const fn output_frac(&self) -> i32 {
        self.output_frac
    }

    /// Fraction bits of the weights.
    #[must_use]
    pub(crate) const fn weight_frac(&self) -> i32 {
        self.weight_frac
    }

    /// Evaluates sample after sample and returns how many outputs saturated at 16 bits. `outputs`
    /// has one element for each output of each sample.
    pub fn run(&self, inputs: &[i16], outputs: &mut Vec<i32>) -> u64 {
        let from = outputs.len();
        outputs.resize(from + inputs.len() / self.inputs * self.outputs(), 0);
        let samples = inputs.par_chunks_exact(self.inputs);
        let results = outputs[from..].par_chunks_exact_mut(self.outputs());
        samples
            .zip(results)
            .with_min_len(64)
            .map(|(sample, out)| self.sample(sample, out))
            .sum()
    }

    fn sample(&self, sample: &[i16], out: &mut [i32]) -> u64 {
        let mut held = 0;
        let rows = self.weights.chunks_exact(self.inputs);
        for ((row, bias), to) in rows.zip(&self.bias).zip(out) {
            let products = row.iter().zip(sample);
            let sum: i32 = products.map(|(w, x)| i32::from(*w) * i32::from(*x)).sum();
            let code = self.requantised(sum + bias);
            *to = code.clamp(i16::MIN.into(), i16::MAX.into());
            held += u64::from(*to != code);
        }
        held
    }

    /// Rounds a sum to the scale of the outputs, half to even.
    fn requantised(&self, sum: i32) -> i32 {
        match self.shift {
            0 => sum,
            // Below a half code whatever the sum.
            33.. => 0,
            shift => {
                let sum = i64::from(sum);
                let (half, odd) = (1i64 << (shift - 1), sum >> shift & 1);
                ((sum + half - 1 + odd) >> shift) as i32
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_formats::fixed::{Rounding, round_shift};
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    fn layer(random: &mut Pcg64Mcg, inputs: usize, outputs: usize, scale: f32) -> Layer {
        let mut list = |n| (0..n).map(|_| random.random_range(-scale..scale)).collect();
        Layer::new(inputs, list(inputs * outputs), list(outputs)).unwrap()
    }

    /// No input can overflow a sum, however large the weights: checked against
    /// sums of 128 bits at the inputs that reach farthest.
    #[test]
    fn sums_cannot_overflow() {
        for seed in 0..40 {
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            let scale = [1e-3, 0.1, 1.0, 50.0][random.random_range(0..4)];
            let inputs = random.random_range(1..200);
            let layer = layer(&mut random, inputs, 5, scale);
            let made = MacLayer::quantise(&layer, 8, 100.0).unwrap();
            for (row, bias) in made.weights.chunks_exact(inputs).zip(&made.bias) {
                for sign in [1i128, -1] {
                    // Each input at the end that its weight makes the farthest.
                    let reach: i128 = row
                        .iter()
                        .map(|w| sign * i128::from(w.unsigned_abs()) * 32_768)
                        .sum();
                    let sum = reach + i128::from(*bias);
                    assert!(i32::try_from(sum).is_ok(), "seed {seed}: {sum}");
                }
            }
            // The finest scale: with one bit more something would not fit.
            let finer = layer
                .weights()
                .iter()
                .map(|w| f64::from(w.abs()))
                .fold(0.0, f64::max)
                * 2f64.powi(made.weight_frac + 1);
            let row = made
                .weights
                .chunks_exact(inputs)
                .zip(&made.bias)
                .map(|(row, bias)| {
                    let total: i64 = row.iter().map(|w| i64::from(w.unsigned_abs())).sum();
                    (2 * total + 2 * inputs as i64) * 32_768 + 2 * i64::from(*bias).abs() + 2
                });
            let full = row.max().unwrap() >= SUM_LIMIT;
            assert!(
                finer >= 32_766.0 || full || made.weight_frac == 30,
                "seed {seed}"
            );
        }
    }

    /// Codes are within the derived distance of the exact result of the rounded
    /// inputs: half a code of the output, and half a code of each weight times
    /// its input.
    #[test]
    fn results_keep_to_their_bound() {
        for seed in 0..40 {
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            let layer = layer(&mut random, 39, 16, 0.3);
            let made = MacLayer::quantise(&layer, 10, 60.0).unwrap();
            let codes: Vec<i16> = (0..39 * 7)
                .map(|_| random.random_range(-8000..8000))
                .collect();
            let mut found = vec![];
            assert_eq!(made.run(&codes, &mut found), 0);
            let mut mismatch = 0.0f64;
            for (sample, out) in codes.chunks_exact(39).zip(found.chunks_exact(16)) {
                let x: Vec<f64> = sample.iter().map(|c| f64::from(*c) / 1024.0).collect();
                let reach: f64 = x.iter().map(|v| v.abs()).sum();
                for ((row, bias), code) in
                    layer.weights().chunks_exact(39).zip(layer.bias()).zip(out)
                {
                    let exact: f64 = row.iter().zip(&x).map(|(w, x)| f64::from(*w) * x).sum();
                    let exact = exact + f64::from(*bias);
                    let value = f64::from(*code) * 2f64.powi(-made.output_frac);
                    let bound = 2f64.powi(-made.output_frac - 1)
                        + (reach + 2f64.powi(-10)) * 2f64.powi(-made.weight_frac - 1);
                    assert!(
                        (value - exact).abs() <= bound,
                        "seed {seed}: {value} {exact}"
                    );
                    mismatch = mismatch.max((value - exact).abs() / bound);
                }
            }
            assert!(mismatch > 0.05, "the bound means something: {mismatch}");
        }
    }

    /// The quick rounding is the stated one.
    #[test]
    fn sums_are_rounded_half_to_even() {
        let one = Layer::new(1, vec![1.0], vec![0.0]).unwrap();
        let mut made = MacLayer::quantise(&one, 8, 1.0).unwrap();
        let mut random = Pcg64Mcg::seed_from_u64(11);
        for shift in 0..48 {
            made.shift = shift;
            let ends = [0, 1, -1, i32::MAX, i32::MIN + 1];
            let ties = (-9..9).map(|n| (i64::from(n) << shift.min(40) >> 1) as i32);
            let any: Vec<i32> = (0..200).map(|_| random.random()).collect();
            for sum in ends.into_iter().chain(ties).chain(any) {
                let exact = round_shift(i128::from(sum), shift, Rounding::HalfEven);
                assert_eq!(i128::from(made.requantised(sum)), exact, "{sum} >> {shift}");
            }
        }
    }

    #[test]
    fn outputs_past_their_range_are_held_and_counted() {
        let one = Layer::new(1, vec![1.0], vec![0.0]).unwrap();
        let made = MacLayer::quantise(&one, 8, 1.0).unwrap();
        let mut found = vec![];
        let held = made.run(&[256, 512, -256, i16::MIN], &mut found);
        assert_eq!(held, 2);
        assert_eq!(found[1], 32_767);
        assert_eq!(found[3], -32_768);
    }

    #[test]
    fn layers_follow_one_another_in_scale() {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let layers = vec![layer(&mut random, 4, 8, 1.0), layer(&mut random, 8, 3, 1.0)];
        let mlp = Mlp::new(layers).unwrap();
        let made = MacMlp::quantise(&mlp, 12, &[6.0, 20.0]).unwrap();
        assert_eq!(made.input_frac(), 12);
        assert_eq!(made.layers()[0].output_frac(), 12);
        assert_eq!(made.output_frac(), 10);
        assert!(MacMlp::quantise(&mlp, 12, &[6.0]).is_err());
        assert!(MacMlp::quantise(&mlp, 12, &[6.0, 1e9]).is_err());
    }
}
