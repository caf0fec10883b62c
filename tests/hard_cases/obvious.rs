//! Units of which one operation is done as one would write it first.

use std::collections::{BTreeMap, VecDeque};

use potamoi_formats::config::Config;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::splat_unit::{Composited, SplatJob};
use potamoi_reference::{GatherTask, Product, ReferenceUnits, UnitError, Units};

/// Which operation, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Obvious {
    /// `1 - exp(-s)` as 65,536 less the exponential of s, which it takes in U3.13.
    OpacityFromExp,
    /// Weights as products of transmittance and opacity, each cut off to U1.20.
    WeightsAlone,
    /// Each of the eight weights of an interpolation rounded by itself.
    RoundedAlone,
    /// A weight for each row, of corners that share one the last.
    WeightPerRow,
}

impl Obvious {
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::OpacityFromExp => "65,536 less the exponential's result",
            Self::WeightsAlone => "weights T alpha, each cut off to U1.20",
            Self::RoundedAlone => "each weight rounded by itself",
            Self::WeightPerRow => "a weight for each row, the last kept",
        }
    }
}

pub(crate) struct ObviousUnits {
    form: Obvious,
    twins: ReferenceUnits,
    weight_bits: u32,
    /// Of samples whose transmittance is known and whose colour is not yet: the weight as it is,
    /// and cut off.
    weights: VecDeque<(i32, i32)>,
}

impl ObviousUnits {
    pub(crate) fn new(form: Obvious, config: &Config) -> Self {
        Self {
            form,
            twins: ReferenceUnits::new(config),
            weight_bits: config.gu.weight_bits,
            weights: VecDeque::new(),
        }
    }

    fn interpolated(&self, task: &GatherTask) -> GatherTask {
        let mut task = task.clone();
        for entry in &mut task.entries {
            match self.form {
                Obvious::WeightPerRow => {
                    let last: BTreeMap<u16, usize> = entry.rows.into_iter().zip(0..).collect();
                    for (corner, row) in entry.rows.into_iter().enumerate() {
                        if last[&row] != corner {
                            entry.weights[corner] = 0;
                        }
                    }
                }
                Obvious::RoundedAlone => {
                    let one = f64::from(1u32 << self.weight_bits);
                    let weights = entry.weights.map(|w| f64::from(w) / one);
                    // What the corners on the far side of each axis share is the fraction.
                    let far = [0, 1, 2].map(|axis| -> f64 {
                        let own = weights.iter().enumerate();
                        own.filter(|(c, _)| c >> axis & 1 == 1)
                            .map(|(_, w)| w)
                            .sum()
                    });
                    entry.weights = [0, 1, 2, 3, 4, 5, 6, 7].map(|corner| {
                        let side = |axis: usize| match corner >> axis & 1 {
                            1 => far[axis],
                            _ => 1.0 - far[axis],
                        };
                        (side(0) * side(1) * side(2) * one).round() as u16
                    });
                }
                _ => {}
            }
        }
        task
    }
}

impl Units for ObviousUnits {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        let tasks: Vec<_> = tasks.iter().map(|task| self.interpolated(task)).collect();
        self.twins.gather(&tasks, features)
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        let tasks: Vec<_> = tasks.iter().map(|task| self.interpolated(task)).collect();
        self.twins.sums(&tasks, sums)
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        match (self.form, op.code, op.rounding) {
            (Obvious::OpacityFromExp, OpCode::OneMinusExp, _) => {
                // From 20 fraction bits to 13.
                let s: Vec<i32> = a.iter().map(|s| (s + 64) >> 7).collect();
                self.twins.vector(VectorOp::new(OpCode::Exp), &s, b, out)?;
                out.iter_mut().for_each(|v| *v = 65_536 - *v);
                Ok(())
            }
            (Obvious::WeightsAlone, OpCode::Multiply, Rounding::HalfUp) => {
                self.twins.vector(op, a, b, out)?;
                for ((a, b), next) in a.iter().zip(b).zip(out) {
                    if *next < *a {
                        let alpha = i64::from((1 << op.shift) - b);
                        let cut = ((i64::from(*a) * alpha) >> op.shift) as i32;
                        self.weights.push_back((a - *next, cut));
                    }
                }
                Ok(())
            }
            (Obvious::WeightsAlone, OpCode::Multiply, Rounding::HalfEven) => {
                let mut cut = Vec::with_capacity(a.len());
                for weight in a.as_chunks::<3>().0 {
                    let (whole, alone) = self.weights.pop_front().expect("a weight a colour");
                    assert_eq!(*weight, [whole; 3]);
                    cut.extend([alone; 3]);
                }
                self.twins.vector(op, &cut, b, out)
            }
            _ => self.twins.vector(op, a, b, out),
        }
    }

    fn splats(&mut self, job: &SplatJob<'_>) -> Result<Composited, UnitError> {
        self.twins.splats(job)
    }

    fn multiplied(&mut self, product: Product) {
        self.twins.multiplied(product);
    }
}
