//! Colours of Compact-3DGS in fixed point, computed before splat records are written.
//!
//! | step | unit | result |
//! |---|---|---|
//! | features | gathering, level after level | one format, the finest that holds them |
//! | colour | MAC array, ReLU between layers | 16 bits with a scale a layer |
//!
//! Harmonics, and the ones that act as a bias, are larger than features. They enter the first
//! layer divided by a power of two, which its weights compensate.

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::rit::Vertices;
use potamoi_formats::units::OpCode;

use super::{FEATURES, HARMONICS, HashedColour, LEVELS, MATRICES, ONES, harmonics};
use crate::calibrate::direction;
use crate::gather_plan::{CodedTable, Located, finest_of};
use crate::mac::MacMlp;
use crate::opacity::need_of;
use crate::quantisation::held;
use crate::{FieldError, FieldWork, Layer, Mlp};
use potamoi_march::{FixedStats, Lanes, Work};
use potamoi_reference::Units;

/// Number of features of a Gaussian.
const WIDTH: usize = (LEVELS * FEATURES) as usize;
/// Harmonics are below two to this power.
const HARMONICS_INT_BITS: i32 = 4;
/// Number of Gaussians and directions from which the perceptron's scales are determined.
const CALIBRATION: usize = 4096;

/// The quantised field.
pub struct FixedColour<'a> {
    field: &'a HashedColour,
    tables: Vec<CodedTable>,
    pub(super) head: MacMlp,
    /// Fraction bits of features, and of harmonics at the first layer.
    pub(super) feature_bits: u32,
    pub(super) harmonic_bits: i32,
}

impl<'a> FixedColour<'a> {
    /// Number of Gaussians gathered at a time.
    pub const BATCH: usize = 1 << 15;

    /// Quantises the field for a configuration and for Gaussians at `centres`. Some of them, seen
    /// from all sides, determine the perceptron's scales.
    ///
    /// # Errors
    /// The configuration's units lack an operation or format, or a value fits no format.
    pub fn new(
        field: &'a HashedColour,
        centres: &[DVec3],
        config: &Config,
    ) -> Result<Self, FieldError> {
        // Vertices of the tables, and records of Gaussians, which are single ids.
        let gathers_both = |preset: &Config| {
            let own = preset.supported_vertices();
            [Vertices::One, Vertices::Eight]
                .iter()
                .all(|kind| own.contains(kind))
        };
        need_of(config, &[OpCode::Relu], gathers_both)?;
        let frac = finest_of(&field.tables, |_| true, config, "features")?;
        let tables = field.tables.iter();
        let tables = tables.map(|table| CodedTable::new(table, &[frac; FEATURES as usize], config));
        let down = (frac as i32 + HARMONICS_INT_BITS - 15).max(0);
        Ok(Self {
            field,
            tables: tables.collect::<Result<_, _>>()?,
            head: MacMlp::quantise(
                &with_first_columns(&field.head, down)?,
                frac as i32,
                &magnitudes(field, centres),
            )?,
            feature_bits: frac,
            harmonic_bits: frac as i32 - down,
        })
    }

    /// Coefficients of the constant harmonic of every Gaussian, seen from `eye`. `stats` receives
    /// the counts.
    ///
    /// # Errors
    /// A unit fails.
    pub fn seen_from(
        &self,
        eye: DVec3,
        centres: &[DVec3],
        done: FieldWork,
        units: &mut dyn Units,
        stats: &mut FixedStats,
    ) -> Result<Vec<[f32; 3]>, FieldError> {
        let mut work = Work::default();
        let mut colours = Vec::with_capacity(centres.len());
        let unit = 2f64.powi(-self.head.output_frac());
        let one = held(2f64.powi(self.harmonic_bits));
        for batch in centres.chunks(Self::BATCH) {
            let mut inputs = vec![0; batch.len() * MATRICES[0][1]];
            let seen = CentreBatch {
                eye,
                first: colours.len(),
                batch,
            };
            self.gather(&seen, &mut inputs, done, units, stats)?;
            for (at, row) in batch.iter().zip(inputs.chunks_exact_mut(MATRICES[0][1])) {
                let towards = harmonics((*at - eye).normalize_or_zero());
                for (to, v) in row[WIDTH..]
                    .iter_mut()
                    .zip(towards)
                    .take(done.direction_codes)
                {
                    *to = held(v * 2f64.powi(self.harmonic_bits));
                }
                row[WIDTH + HARMONICS..].fill(one);
            }
            let mut lanes = Lanes {
                units,
                work: &mut work,
            };
            let codes = self.head.run(inputs, &mut lanes)?;
            let codes = codes.as_chunks::<3>().0.iter();
            colours.extend(codes.map(|c| c.map(|v| (f64::from(v) * unit) as f32)));
        }
        stats.take(work);
        Ok(colours)
    }

    /// Gathers the features of a batch into the inputs of the perceptron.
    fn gather(
        &self,
        seen: &CentreBatch<'_>,
        inputs: &mut [i16],
        done: FieldWork,
        units: &mut dyn Units,
        stats: &mut FixedStats,
    ) -> Result<(), FieldError> {
        let mut eyes = [DVec3::ZERO; LEVELS as usize];
        self.field.index(seen.eye, &mut eyes);
        let mut hashed = 0;
        for (level, table) in self.tables.iter().enumerate() {
            if self.field.tables[level].is_hashed() {
                hashed += 1;
                if hashed > done.hashed {
                    continue;
                }
            }
            let mut places = [DVec3::ZERO; LEVELS as usize];
            let located = (seen.first as u32..).zip(seen.batch).map(|(slot, at)| {
                self.field.index(*at, &mut places);
                Located {
                    slot,
                    place: places[level],
                }
            });
            let located: Vec<_> = located.collect();
            let own = table.gathers(eyes[level], &located);
            table.carry_out(&own, units, stats, |sample, codes| {
                let to = sample as usize * MATRICES[0][1] + level * FEATURES as usize;
                inputs[to..to + codes.len()].copy_from_slice(codes);
            })?;
        }
        Ok(())
    }
}

/// The centres of a batch, the position of the camera, and the index of the first centre.
struct CentreBatch<'a> {
    eye: DVec3,
    first: usize,
    batch: &'a [DVec3],
}

/// The network with the first layer's weights of harmonics and ones multiplied by two to the power
/// of `up`.
pub(super) fn with_first_columns(head: &Mlp, up: i32) -> Result<Mlp, FieldError> {
    let scale = 2f32.powi(up);
    let layers = head.layers().iter().enumerate().map(|(i, layer)| {
        let columns = layer.inputs();
        let weights = layer.weights().iter().enumerate();
        let weights = weights.map(|(at, w)| match i {
            0 if at % columns >= WIDTH => w * scale,
            _ => *w,
        });
        Layer::new(columns, weights.collect(), layer.bias().to_vec())
    });
    Mlp::new(layers.collect::<Result<_, _>>()?)
}

/// The largest magnitude of each layer's outputs over some of the Gaussians, each seen from a
/// direction of its own.
fn magnitudes(field: &HashedColour, centres: &[DVec3]) -> Vec<f64> {
    let mut largest = vec![0f64; field.head.layers().len()];
    let mut values = vec![];
    let step = centres.len().div_ceil(CALIBRATION).max(1);
    for (n, at) in (0..).zip(centres.iter().step_by(step)) {
        values.clear();
        field.gathered(*at, &mut values);
        values.extend(harmonics(direction(n)));
        values.extend([1.0; ONES]);
        field.head.run_watched(&mut values, |layer, value| {
            largest[layer] = largest[layer].max(value.abs());
        });
    }
    largest
}
