//! Multilayer perceptrons: fully connected layers with ReLU between them.

use super::FieldError;
use super::layer_sums::{Passed, Weights};

/// Maximum number of inputs or outputs of a layer.
const MAX_WIDTH: usize = 1 << 12;

/// One layer: `y = W x + b`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Layer {
    inputs: usize,
    /// Weights, a row for each output.
    weights: Vec<f32>,
    /// The weights in the order in which they are summed.
    #[serde(skip)]
    ordered: Weights,
    bias: Vec<f32>,
}

impl Layer {
    /// A layer of `weights`, a row of `inputs` for each output, and one bias for each output.
    ///
    /// # Errors
    /// Sizes are inconsistent or out of range, or a number is not finite.
    pub fn new(inputs: usize, weights: Vec<f32>, bias: Vec<f32>) -> Result<Self, FieldError> {
        let refuse = |found: String, expected: &str| {
            Err(FieldError::Part {
                part: "layer",
                found,
                expected: expected.to_owned(),
            })
        };
        let sizes = 1..=MAX_WIDTH;
        if !sizes.contains(&inputs) || !sizes.contains(&bias.len()) {
            let found = format!("{inputs} inputs, {} outputs", bias.len());
            return refuse(found, "1 to 4096 of each");
        }
        if weights.len() != inputs * bias.len() {
            let found = format!("{} weights", weights.len());
            return refuse(found, "one an input and output");
        }
        if !weights.iter().chain(&bias).all(|v| v.is_finite()) {
            return refuse("not finite".to_owned(), "finite weights and biases");
        }
        Ok(Self {
            inputs,
            ordered: Weights::new(inputs, &weights, &bias),
            weights,
            bias,
        })
    }

    /// Number of inputs.
    #[must_use]
    pub const fn inputs(&self) -> usize {
        self.inputs
    }

    /// Number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.bias.len()
    }

    /// Weights, a row of inputs for each output.
    #[must_use]
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Biases, one for each output.
    #[must_use]
    pub fn bias(&self) -> &[f32] {
        &self.bias
    }
}

/// Consecutive layers, with ReLU between them and none after the last.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Mlp {
    layers: Vec<Layer>,
    widest: usize,
}

impl Mlp {
    /// A perceptron of at least one layer.
    ///
    /// # Errors
    /// There are no layers, or a layer's inputs are not the outputs of the one before.
    pub fn new(layers: Vec<Layer>) -> Result<Self, FieldError> {
        let fits = layers.windows(2).all(|l| l[0].outputs() == l[1].inputs());
        if layers.is_empty() || !fits {
            let sizes: Vec<_> = layers.iter().map(|l| [l.inputs(), l.outputs()]).collect();
            return Err(FieldError::Part {
                part: "mlp",
                found: format!("layers of {sizes:?} inputs and outputs"),
                expected: "one or more, each taking what the one before gives".to_owned(),
            });
        }
        let widest = layers.iter().map(Layer::outputs).max().unwrap_or(0);
        Ok(Self { layers, widest })
    }

    /// The layers.
    #[must_use]
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Number of weights and biases.
    #[must_use]
    #[allow(clippy::len_without_is_empty)] // There is always one.
    pub fn len(&self) -> usize {
        let each = self.layers.iter();
        each.map(|layer| layer.weights.len() + layer.bias.len())
            .sum()
    }

    /// Number of inputs of the first layer.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.layers.first().map_or(0, Layer::inputs)
    }

    /// Number of outputs of the last layer.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.layers.last().map_or(0, Layer::outputs)
    }

    /// Evaluates in place: `values` holds the inputs of any number of samples, sample after sample,
    /// then their outputs. A sample's outputs depend on its own inputs alone, to the last bit.
    pub fn run(&self, values: &mut Vec<f64>) {
        self.run_watched(values, |_, _| ());
    }

    /// As [`Mlp::run`], and calls `watch` with each output of each layer before its ReLU.
    pub(crate) fn run_watched(&self, values: &mut Vec<f64>, mut watch: impl FnMut(usize, f64)) {
        let (mut passed, mut sums) = (Passed::default(), vec![]);
        for (i, layer) in self.layers.iter().enumerate() {
            // ReLU leaves out what is not above 0.
            passed.keep(values, layer.inputs, i > 0);
            layer.ordered.sums(values, &passed, &mut sums);
            std::mem::swap(values, &mut sums);
            values.iter().for_each(|sum| watch(i, *sum));
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// |x| and x, from ReLU of x and -x.
    #[test]
    fn a_small_one_by_hand() {
        let hidden = Layer::new(1, vec![1.0, -1.0], vec![0.0, 0.0]).unwrap();
        let out = Layer::new(2, vec![1.0, 1.0, 1.0, -1.0], vec![0.5, 0.0]).unwrap();
        let mlp = Mlp::new(vec![hidden, out]).unwrap();
        for x in [-2.0, 0.0, 3.5] {
            let mut values = vec![x];
            mlp.run(&mut values);
            assert_eq!(values, [x.abs() + 0.5, x]);
        }
        assert_eq!((mlp.inputs(), mlp.outputs()), (1, 2));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let layer = |inputs, outputs| {
            Layer::new(inputs, vec![0.0; inputs * outputs], vec![0.0; outputs]).unwrap()
        };
        assert!(Mlp::new(vec![]).is_err());
        let error = Mlp::new(vec![layer(2, 3), layer(4, 1)]).unwrap_err();
        assert!(error.to_string().contains("[[2, 3], [4, 1]]"), "{error}");
        assert!(Layer::new(2, vec![0.0; 3], vec![0.0; 2]).is_err());
        assert!(Layer::new(0, vec![], vec![0.0]).is_err());
        assert!(Layer::new(1, vec![f32::NAN], vec![0.0]).is_err());
    }
}
