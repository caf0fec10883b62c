//! Error bounds of a perceptron's outputs in fixed point.

use super::ErrorInterval;
use crate::Mlp;
use crate::mac::MacMlp;

/// A perceptron in floating point and in fixed point.
///
/// With `z' = W' x' + b'`, rounded, against `z = W x + b`, outputs differ by `W' d + v + r`: `d`
/// is the difference of the inputs, `v = (W' - W) x + b' - b` is known, and `r` is at most half a
/// code. ReLU passes a difference on if both values are positive, removes it if neither is, and
/// otherwise passes a part of it.
pub(crate) struct Pair {
    layers: Vec<Layer>,
}

struct Layer {
    inputs: usize,
    /// Weights in floating point, a row an output.
    weights: Vec<f64>,
    bias: Vec<f64>,
    /// Weights of the codes.
    coded: Vec<f64>,
    coded_bias: Vec<f64>,
    /// Half a code of the outputs, and the value at which they saturate.
    half: f64,
    farthest: f64,
}

/// The effect of ReLU on the error of an output.
#[derive(Clone, Copy, PartialEq)]
enum Passes {
    /// Both values are positive.
    All,
    /// Neither value is positive.
    Nothing,
    /// Unknown: the error after ReLU is at most this.
    Perhaps(f64),
}

/// A layer evaluated at inputs.
struct EvaluatedLayer {
    /// Errors of its outputs from its own weights and bias.
    own: Vec<f64>,
    passes: Vec<Passes>,
}

/// Values, and their errors, between layers.
#[derive(Default)]
pub(crate) struct Outputs {
    pub(crate) values: Vec<f64>,
    pub(crate) off: Vec<ErrorInterval>,
}

impl Pair {
    pub(crate) fn new(mlp: &Mlp, codes: &MacMlp) -> Self {
        let mut input_frac = codes.input_frac();
        let layers = mlp.layers().iter().zip(codes.layers()).map(|(own, coded)| {
            let unit = |frac: i32| 2f64.powi(-frac);
            let of_weights = unit(coded.weight_frac());
            let of_sums = unit(coded.weight_frac() + input_frac);
            input_frac = coded.output_frac();
            let values = |list: &[f32]| list.iter().map(|v| f64::from(*v)).collect();
            Layer {
                inputs: own.inputs(),
                weights: values(own.weights()),
                bias: values(own.bias()),
                coded: (coded.weights().iter())
                    .map(|w| f64::from(*w) * of_weights)
                    .collect(),
                coded_bias: (coded.bias().iter())
                    .map(|b| f64::from(*b) * of_sums)
                    .collect(),
                half: unit(coded.output_frac()) / 2.0,
                farthest: f64::from(i16::MAX) * unit(coded.output_frac()),
            }
        });
        Self {
            layers: layers.collect(),
        }
    }

    /// The floating-point outputs at `inputs`, and the errors of the fixed-point ones for inputs
    /// with errors `off`.
    pub(crate) fn outputs(&self, inputs: &[f64], off: &[ErrorInterval]) -> Outputs {
        let mut values = inputs.to_vec();
        let mut largest: Vec<f64> = off.iter().map(|off| off.largest()).collect();
        let mut seen: Vec<EvaluatedLayer> = vec![];
        for (number, layer) in self.layers.iter().enumerate() {
            let is_last = number + 1 == self.layers.len();
            let made = layer.see(&mut values, &mut largest, is_last);
            seen.push(made);
        }
        let off = (0..values.len())
            .map(|output| self.back(output, &seen, off))
            .collect();
        Outputs { values, off }
    }

    /// The error of an output, propagated back through the layers.
    fn back(&self, output: usize, seen: &[EvaluatedLayer], off: &[ErrorInterval]) -> ErrorInterval {
        let last = self.layers.len() - 1;
        let mut slopes = vec![0.0; self.layers[last].bias.len()];
        slopes[output] = 1.0;
        let mut sum = ErrorInterval::default();
        for (number, layer) in self.layers.iter().enumerate().rev() {
            let own = &seen[number];
            let mut before = vec![0.0; layer.inputs];
            for ((slope, own), row) in slopes
                .iter()
                .zip(&own.own)
                .zip(layer.coded.chunks_exact(layer.inputs))
            {
                if *slope == 0.0 {
                    continue;
                }
                sum.known += slope * own;
                sum.most += slope.abs() * layer.half;
                for (to, w) in before.iter_mut().zip(row) {
                    *to += slope * w;
                }
            }
            if number == 0 {
                for (slope, off) in before.iter().zip(off) {
                    sum.known += slope * off.known;
                    sum.most += slope.abs() * off.most;
                }
                break;
            }
            for (slope, passes) in before.iter_mut().zip(&seen[number - 1].passes) {
                match passes {
                    Passes::All => {}
                    Passes::Nothing => *slope = 0.0,
                    Passes::Perhaps(most) => {
                        sum.most += slope.abs() * most;
                        *slope = 0.0;
                    }
                }
            }
            slopes = before;
        }
        match seen[last].passes[output] {
            Passes::Perhaps(most) => ErrorInterval::within(most),
            Passes::All | Passes::Nothing => sum,
        }
    }
}

impl Layer {
    /// Propagates values, with upper bounds of their errors, from inputs to outputs.
    fn see(&self, values: &mut Vec<f64>, largest: &mut Vec<f64>, is_last: bool) -> EvaluatedLayer {
        let outputs = self.bias.len();
        let mut seen = EvaluatedLayer {
            own: Vec::with_capacity(outputs),
            passes: Vec::with_capacity(outputs),
        };
        let (mut next, mut farthest) = (vec![], vec![]);
        let rows = self.weights.chunks_exact(self.inputs);
        let coded = self.coded.chunks_exact(self.inputs);
        let biases = self.bias.iter().zip(&self.coded_bias);
        for ((row, coded), (bias, coded_bias)) in rows.zip(coded).zip(biases) {
            let (mut value, mut with_codes, mut off) = (*bias, *coded_bias, self.half);
            for ((w, c), (x, most)) in row.iter().zip(coded).zip(values.iter().zip(&*largest)) {
                value += w * x;
                with_codes += c * x;
                off += c.abs() * most;
            }
            let own = with_codes - value;
            off += own.abs();
            // What is held at the end of its codes is off by what it is beyond, too.
            let is_held = value.abs() + off > self.farthest;
            if is_held {
                off += (value.abs() - self.farthest).max(0.0);
            }
            seen.own.push(own);
            seen.passes.push(match () {
                () if is_held => Passes::Perhaps(off),
                () if is_last || value > off => Passes::All,
                () if value < -off => Passes::Nothing,
                () => Passes::Perhaps(off),
            });
            if is_last {
                next.push(value);
                farthest.push(off);
            } else {
                next.push(value.max(0.0));
                farthest.push(if value < -off { 0.0 } else { off });
            }
        }
        (*values, *largest) = (next, farthest);
        seen
    }
}
