//! What the outputs of a perceptron in codes are off by.

use super::Off;
use crate::Mlp;
use crate::mac::MacMlp;

/// A perceptron, and the same in codes.
///
/// With `z' = W' x' + b'`, rounded, beside `z = W x + b`, outputs differ by `W' d + v + r`: `d` by
/// which inputs do, `v = (W' - W) x + b' - b`, which is known, and `r` of at most half a code. ReLU
/// hands a difference on where both are positive, none where neither is, and a part of it where
/// that is not certain.
pub(crate) struct Pair {
    layers: Vec<Layer>,
}

struct Layer {
    inputs: usize,
    /// Of the float one, a row an output.
    weights: Vec<f64>,
    bias: Vec<f64>,
    /// Of the codes.
    coded: Vec<f64>,
    coded_bias: Vec<f64>,
    /// Half a code of the outputs, and the farthest that they are held at.
    half: f64,
    farthest: f64,
}

/// What ReLU does to an output of a layer.
#[derive(Clone, Copy, PartialEq)]
enum Passes {
    /// Both values.
    All,
    /// Neither.
    Nothing,
    /// Not known: what comes is off by this at most.
    Perhaps(f64),
}

/// A layer at inputs.
struct Seen {
    /// What its outputs are off by for its own weights and bias.
    own: Vec<f64>,
    passes: Vec<Passes>,
}

/// Values and what is known of them as they go through.
#[derive(Default)]
pub(crate) struct Outputs {
    pub(crate) values: Vec<f64>,
    pub(crate) off: Vec<Off>,
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

    /// The float outputs at `inputs`, and what those in codes are off by where the inputs are off
    /// by so much.
    pub(crate) fn outputs(&self, inputs: &[f64], off: &[Off]) -> Outputs {
        let mut values = inputs.to_vec();
        let mut largest: Vec<f64> = off.iter().map(|off| off.largest()).collect();
        let mut seen: Vec<Seen> = vec![];
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

    /// What an output is off by, from what each layer does to it.
    fn back(&self, output: usize, seen: &[Seen], off: &[Off]) -> Off {
        let last = self.layers.len() - 1;
        let mut slopes = vec![0.0; self.layers[last].bias.len()];
        slopes[output] = 1.0;
        let mut sum = Off::default();
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
            Passes::Perhaps(most) => Off::within(most),
            Passes::All | Passes::Nothing => sum,
        }
    }
}

impl Layer {
    /// Takes values from inputs to outputs, and the largest differences with them.
    fn see(&self, values: &mut Vec<f64>, largest: &mut Vec<f64>, is_last: bool) -> Seen {
        let outputs = self.bias.len();
        let mut seen = Seen {
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
