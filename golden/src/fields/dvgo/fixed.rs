//! DirectVoxGO in the hardware's formats.
//!
//! | step | unit | result |
//! |---|---|---|
//! | density, features | gathering | a format each, the finest that holds the grid |
//! | d + shift | multiply by a power of two, add | the fraction bits of the exponential's input |
//! | softplus | softplus | F fraction bits |
//! | s | multiply by the interval, half even | U4.G, G = `one_minus_frac_bits` |
//! | alpha | 1 - exp(-s) | U0.F |
//! | layers | MAC array, ReLU between them | 16 bits with a scale a layer |
//! | colour | sigmoid | U0.F |
//!
//! A direction and its sines and cosines are found once a ray, in floating
//! point, and rounded to the features' format.

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};

use super::Dvgo;
use crate::fields::codes::{finest, quantised};
use crate::fields::mac::MacMlp;
use crate::fields::{Field, FieldError};
use crate::voxels::{Head, Lanes, MVoxels, Placement, TRANSMITTANCE, VoxelError};

/// Fraction bits of the interval.
const INTERVAL_BITS: u32 = 24;
/// Samples with which the perceptron's scales are found.
const CALIBRATION: u32 = 8192;

/// A model in codes, ready to be rendered MVoxel by MVoxel.
#[derive(Debug)]
pub struct FixedDvgo {
    mvoxels: MVoxels,
    placement: Placement,
    head: DvgoHead,
}

impl FixedDvgo {
    /// Its MVoxels.
    #[must_use]
    pub fn mvoxels(&self) -> &MVoxels {
        &self.mvoxels
    }

    /// Where they lie.
    #[must_use]
    pub fn placement(&self) -> Placement {
        self.placement
    }

    /// What makes opacity and colour.
    #[must_use]
    pub fn head(&self) -> &DvgoHead {
        &self.head
    }
}

/// Feature computation of DirectVoxGO in codes.
#[derive(Debug)]
pub struct DvgoHead {
    channels: usize,
    density_bits: u32,
    /// Fraction bits of features and directions, the perceptron's input.
    input_bits: u32,
    shift: i32,
    interval: i32,
    /// Fraction bits of the exponential's input, of its results, and of s.
    engine: [u32; 3],
    least: [i32; 2],
    frequencies: Vec<f64>,
    mlp: MacMlp,
}

impl Dvgo {
    /// Rounds the model to the formats of a configuration. The perceptron's
    /// scales come from a fixed set of places and directions, spread evenly
    /// over the box and the sphere, at which the model is not empty.
    ///
    /// # Errors
    /// A configuration whose units lack an operation or have other formats than
    /// rendering needs, or values that no format holds.
    pub fn fixed(&self, config: &Config) -> Result<FixedDvgo, FieldError> {
        let exp = &config.vu.exp;
        for op in [
            OpCode::Relu,
            OpCode::Add,
            OpCode::Multiply,
            OpCode::OneMinusExp,
            OpCode::Softplus,
            OpCode::Sigmoid,
        ] {
            if !config.vu.ops.contains(&op) {
                return Err(FieldError::Part {
                    part: "vu.ops",
                    found: OpCode::list(&config.vu.ops),
                    expected: format!("\"{}\" among the operations", op.name()),
                });
            }
        }
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
        let engine = [
            exp.input.frac_bits(),
            exp.output_bits,
            exp.one_minus_frac_bits,
        ];
        let largest = self.magnitudes();
        Ok(FixedDvgo {
            mvoxels,
            placement: self.placement(),
            head: DvgoHead {
                channels,
                density_bits,
                input_bits,
                shift: (self.shift * 2f64.powi(engine[0] as i32)).round_ties_even() as i32,
                interval: (self.interval * 2f64.powi(INTERVAL_BITS as i32)).round_ties_even()
                    as i32,
                engine,
                least: [
                    (self.least * 2f64.powi(engine[1] as i32)) as i32,
                    (self.least * 2f64.powi(TRANSMITTANCE.frac_bits() as i32)) as i32,
                ],
                frequencies: self.frequencies.clone(),
                mlp: MacMlp::quantise(&self.mlp, input_bits as i32, &largest)?,
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
    fn magnitudes(&self) -> Vec<f64> {
        let mut largest = vec![0f64; self.mlp.layers().len()];
        let mut features = vec![0.0; self.channels()];
        let mut places = [DVec3::ZERO];
        let mut inputs = vec![];
        let size = self.bounds[1] - self.bounds[0];
        let fraction = |n: u32, step: f64| (f64::from(n) * step).fract();
        let mut found = 0;
        // Most of a box may be empty.
        for n in 1..64 * CALIBRATION {
            // The sequence of Roberts (2018), of low discrepancy in three
            // dimensions: powers of the root of x^4 = x + 1.
            let spread = DVec3::new(
                fraction(n, 0.819_172_513_396_164_4),
                fraction(n, 0.671_043_606_703_789_2),
                fraction(n, 0.549_700_477_901_970_2),
            );
            if !self.index(self.bounds[0] + size * spread, &mut places) {
                continue;
            }
            self.tables[0].gather(places[0], &mut features);
            if -(-self.depth(&features)).exp_m1() <= self.least {
                continue;
            }
            // A spiral over the sphere.
            let height = 2.0 * fraction(n, 0.618_033_988_749_894_8) - 1.0;
            let (sin, cos) = (2.399_963_229_728_653 * f64::from(n)).sin_cos();
            let wide = (1.0 - height * height).sqrt();
            let direction = DVec3::new(wide * cos, wide * sin, height);
            self.inputs(&features, direction, &mut inputs);
            self.mlp.run_watched(&mut inputs, |layer, value| {
                largest[layer] = largest[layer].max(value.abs());
            });
            found += 1;
            if found == CALIBRATION {
                break;
            }
        }
        largest
    }
}

impl DvgoHead {
    /// The perceptron in codes.
    #[must_use]
    pub fn mlp(&self) -> &MacMlp {
        &self.mlp
    }

    /// Brings codes from one number of fraction bits to that of the
    /// exponential's input.
    fn to_engine(
        &self,
        codes: &[i32],
        frac_bits: i32,
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, VoxelError> {
        let up = self.engine[0] as i32 - frac_bits;
        let op = VectorOp {
            code: OpCode::Multiply,
            shift: (-up).max(0) as u8,
            rounding: Rounding::HalfEven,
        };
        lanes.compute_with(op, codes, 1 << up.clamp(0, 30))
    }
}

impl Head for DvgoHead {
    fn channels(&self) -> usize {
        self.channels
    }

    fn alpha_bits(&self) -> u32 {
        self.engine[1]
    }

    fn colour_bits(&self) -> u32 {
        self.engine[1]
    }

    fn least(&self) -> [i32; 2] {
        self.least
    }

    fn direction_codes(&self) -> usize {
        3 + 6 * self.frequencies.len()
    }

    fn encode(&self, direction: DVec3, out: &mut Vec<i16>) {
        let mut inputs = vec![];
        super::encode(direction, &self.frequencies, &mut inputs);
        let scale = 2f64.powi(self.input_bits as i32);
        out.extend(inputs.iter().map(|v| {
            let code = (v * scale).round_ties_even();
            code.clamp(i16::MIN.into(), i16::MAX.into()) as i16
        }));
    }

    fn alphas(&self, features: &[i16], lanes: &mut Lanes<'_>) -> Result<Vec<i32>, VoxelError> {
        let density = features.chunks_exact(self.channels);
        let density: Vec<i32> = density.map(|f| i32::from(f[0])).collect();
        let density = self.to_engine(&density, self.density_bits as i32, lanes)?;
        let shifted = lanes.compute_with(VectorOp::new(OpCode::Add), &density, self.shift)?;
        let positive = lanes.compute_with(VectorOp::new(OpCode::Softplus), &shifted, 0)?;
        let [_, output, depth] = self.engine;
        let to_depth = VectorOp {
            code: OpCode::Multiply,
            shift: (output + INTERVAL_BITS).saturating_sub(depth) as u8,
            rounding: Rounding::HalfEven,
        };
        let depth = lanes.compute_with(to_depth, &positive, self.interval)?;
        lanes.compute_with(VectorOp::new(OpCode::OneMinusExp), &depth, 0)
    }

    fn colours(
        &self,
        features: &[i16],
        directions: &[i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, VoxelError> {
        let samples = features.chunks_exact(self.channels);
        let encoded = directions.chunks_exact(self.direction_codes());
        let mut inputs: Vec<i16> = Vec::with_capacity(features.len() + directions.len());
        for (features, direction) in samples.zip(encoded) {
            inputs.extend_from_slice(&features[1..]);
            inputs.extend_from_slice(direction);
        }
        let layers = self.mlp.layers();
        let mut sums = vec![];
        for (i, layer) in layers.iter().enumerate() {
            sums.clear();
            let held = layer.run(&inputs, &mut sums);
            lanes.count_products((sums.len() * layer.inputs()) as u64, held);
            if i + 1 < layers.len() {
                let positive = lanes.compute_with(VectorOp::new(OpCode::Relu), &sums, 0)?;
                inputs.clear();
                // Sums were held within 16 bits.
                inputs.extend(positive.iter().map(|v| *v as i16));
            }
        }
        let colour = self.to_engine(&sums, self.mlp.output_frac(), lanes)?;
        lanes.compute_with(VectorOp::new(OpCode::Sigmoid), &colour, 0)
    }
}
