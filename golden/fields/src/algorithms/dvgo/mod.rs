//! DirectVoxGO (Sun, Sun, Chen, CVPR 2022): a dense grid of densities, one of twelve features, and
//! a small perceptron that computes colour from features and viewing direction.
//!
//! Densities are interpolated before their activation, `alpha = 1 - (1 +
//! exp(d + shift))^-interval`, which is `1 - exp(-interval softplus(d +
//! shift))`: softplus, a product, and `one-minus-exp`.

mod bound;
mod fixed;
mod keys;
mod load;
#[cfg(test)]
mod tests;

use glam::DVec3;
use potamoi_formats::config::Config;

use crate::calibrate::Magnitudes;
use crate::volume::{Blocks, Mask};
use crate::{
    Algorithm, Along, AnyField, Bounds, Directions, Field, FieldError, FieldFile, LoadedField, Mlp,
    QuantisedField, Sampling, Size, Stepped, Storage, Table, sigmoid, softplus, unverified_work,
};
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Notes;
use potamoi_reference::bounds::VectorBounds;

use fixed::FixedDvgo;
pub use keys::DVGO;

/// Maximum number of frequencies in the encoding of the direction.
const MAX_FREQUENCIES: usize = 16;
/// Default alpha and weight threshold.
const LEAST: f64 = 1e-4;
/// Early-termination threshold (transmittance).
const STOP: f64 = 1e-3;

/// Step in voxels with which the authors train it.
const TRAINED_STEP: f64 = 0.5;

/// The fine stage of a DirectVoxGO model.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Dvgo {
    /// The table: channel 0 is the density, the features follow.
    tables: [Table; 1],
    bounds: [DVec3; 2],
    /// Vertices of a separate grid around which the field may be non-empty.
    mask: Option<Mask>,
    #[serde(skip)]
    blocks: Blocks,
    shift: f64,
    interval: f64,
    step: f64,
    /// Step in voxels.
    spacing_of_steps: f64,
    /// Depths of the nearest and the farthest sample.
    range: [f64; 2],
    least: f64,
    /// Frequencies of the direction's encoding.
    frequencies: Vec<f64>,
    mlp: Mlp,
    /// Unused parts of the checkpoint.
    #[serde(skip)]
    notes: Notes,
    /// Of the outputs of its perceptrons.
    #[serde(skip)]
    magnitudes: Magnitudes,
}

/// The parts of a model that does not come from a checkpoint.
#[derive(Debug, Clone, PartialEq)]
pub struct Parts {
    /// A volume whose channel 0 is the density before its activation; features follow.
    pub table: Table,
    /// Vertices of the table around which the field may be non-empty, x fastest.
    pub filled: Vec<bool>,
    /// Corners of the box whose faces contain the outer vertices.
    pub bounds: [DVec3; 2],
    /// Shift added to densities.
    pub shift: f64,
    /// Optical depth of a mean voxel edge where softplus returns 1.
    pub scale: f64,
    /// Step in mean voxel edges.
    pub step: f64,
    /// Depths of the nearest and the farthest sample; the latter may be infinite.
    pub range: [f64; 2],
    /// Number of frequencies in the encoding of the direction, powers of two.
    pub frequencies: usize,
    /// Perceptron from features and direction to colour logits.
    pub mlp: Mlp,
}

impl Dvgo {
    /// Builds a model from its parts.
    ///
    /// # Errors
    /// The perceptron or the mask does not fit the table, or a number is out of range.
    pub fn new(parts: Parts) -> Result<Self, FieldError> {
        let [low, high] = parts.bounds;
        let inputs = parts.table.channels() + 2 + 6 * parts.frequencies;
        let sizes = [parts.mlp.inputs(), parts.mlp.outputs()];
        let step = parts.step;
        let refuse = |part, found: String, expected: String| {
            Err(FieldError::Part {
                part,
                found,
                expected,
            })
        };
        if parts.frequencies > MAX_FREQUENCIES || sizes != [inputs, 3] {
            let found = format!("{} inputs and {} outputs", sizes[0], sizes[1]);
            return refuse("mlp", found, format!("{inputs} inputs, 3 outputs"));
        }
        if parts.table.points().iter().any(|p| *p < 2) {
            let found = format!("{:?} vertices", parts.table.points());
            return refuse("table", found, "2 or more along each axis".to_owned());
        }
        let vertices = parts.table.rows();
        if parts.filled.len() != vertices {
            let found = format!("{} vertices", parts.filled.len());
            return refuse("filled", found, format!("{vertices}, as the table has"));
        }
        let box_is_right = (high - low).cmpgt(DVec3::splat(1e-6)).all();
        let numbers = [parts.shift, parts.scale, step];
        let right = numbers.iter().all(|v| v.is_finite()) && parts.scale > 0.0 && step > 0.0;
        let [near, far] = parts.range;
        let range_is_right = near >= 0.0 && far > near;
        if !(box_is_right && (high - low).is_finite() && right && range_is_right) {
            let found = format!("{:?}, {numbers:?}, {:?}", parts.bounds, parts.range);
            let expected = "a box, a shift, a scale and a step above 0, and a range from 0 up";
            return refuse("numbers", found, expected.to_owned());
        }
        let last = DVec3::from(parts.table.points().map(|p| (p - 1) as f64));
        let voxel = ((high - low) / last).element_product().cbrt();
        let mask = Mask {
            points: parts.table.points(),
            filled: parts.filled,
            scale: DVec3::ONE,
            shift: DVec3::ZERO,
        };
        Ok(Self {
            tables: [parts.table],
            bounds: parts.bounds,
            mask: Some(mask),
            blocks: Blocks::default(),
            shift: parts.shift,
            interval: step * parts.scale,
            step: step * voxel,
            spacing_of_steps: step,
            range: parts.range,
            least: LEAST,
            frequencies: (0..parts.frequencies as i32)
                .map(|k| 2f64.powi(k))
                .collect(),
            mlp: parts.mlp,
            notes: Notes::default(),
            magnitudes: Magnitudes::default(),
        })
    }
}

/// Encodes a direction: its components, then the sines and then the cosines of each component
/// times each frequency.
fn encode(direction: DVec3, frequencies: &[f64], out: &mut Vec<f64>) {
    let parts = direction.to_array();
    out.extend(parts);
    for wave in [f64::sin, f64::cos] {
        for part in parts {
            out.extend(frequencies.iter().map(|f| wave(part * f)));
        }
    }
}

impl Dvgo {
    /// The position of a world point, in vertices.
    fn vertex(&self, at: DVec3) -> DVec3 {
        let last = DVec3::from(self.tables[0].points().map(|p| (p - 1) as f64));
        (at - self.bounds[0]) / (self.bounds[1] - self.bounds[0]) * last
    }

    /// Inputs of the perceptron.
    fn inputs(&self, features: &[f64], direction: DVec3, out: &mut Vec<f64>) {
        out.clear();
        out.extend_from_slice(&features[1..]);
        encode(direction, &self.frequencies, out);
    }
}

/// Description of the algorithm for reports.
pub static ALGORITHM: Algorithm = Algorithm {
    name: "DirectVoxGO",
    outside: &[
        unverified_work::INDEXING,
        unverified_work::MASK,
        unverified_work::RIT,
        unverified_work::WAVES,
        unverified_work::PERCEPTRONS,
        unverified_work::COMPOSITING,
    ],
    full_size: Some(Size::Points(160)),
    preset: "fields",
    file: Some(FieldFile {
        kind: "dvgo",
        endings: &["tar"],
        format: &DVGO,
        keys: &["path"],
        // On which such models of objects are trained.
        background: [1.0; 3],
        load: |path, _| {
            let field = Dvgo::load(path, TRAINED_STEP)?;
            Ok(LoadedField {
                notes: field.notes.clone(),
                field: AnyField::new(field),
            })
        },
    }),
};

impl Field for Dvgo {
    fn algorithm(&self) -> &'static Algorithm {
        &ALGORITHM
    }

    fn tables(&self) -> &[Table] {
        &self.tables
    }

    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        places[0] = self.vertex(at);
    }

    fn holds(&self, at: DVec3) -> bool {
        let mask = self.mask.as_ref();
        mask.is_none_or(|mask| mask.holds(self.vertex(at)))
    }

    fn empty_for(&self, at: DVec3, direction: DVec3) -> Option<f64> {
        let mask = self.mask.as_ref()?;
        let last = DVec3::from(self.tables[0].points().map(|p| (p - 1) as f64));
        let vertices = direction / (self.bounds[1] - self.bounds[0]) * last;
        self.blocks.empty_for(mask, self.vertex(at), vertices)
    }

    fn depth(&self, features: &[f64]) -> f64 {
        self.interval * softplus(features[0] + self.shift)
    }

    fn colour(&self, features: &[f64], direction: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
        self.inputs(features, direction, scratch);
        self.mlp.run(scratch);
        DVec3::from([0, 1, 2].map(|channel| sigmoid(scratch[channel])))
    }

    fn encoded(&self) -> usize {
        3 + 6 * self.frequencies.len()
    }

    fn encode(&self, direction: DVec3, out: &mut Vec<f64>) {
        encode(direction, &self.frequencies, out);
    }

    fn colours(&self, kept: &[f64], directions: &[f64], out: &mut Vec<DVec3>) {
        let samples = kept.chunks_exact(self.tables[0].channels());
        let mut values = Vec::with_capacity(kept.len() + directions.len());
        for (features, direction) in samples.zip(directions.chunks_exact(self.encoded())) {
            values.extend_from_slice(&features[1..]);
            values.extend_from_slice(direction);
        }
        self.mlp.run(&mut values);
        out.clear();
        let logits = values.as_chunks::<3>().0.iter();
        out.extend(logits.map(|logits| DVec3::from(logits.map(sigmoid))));
    }

    fn perceptrons(&self) -> Vec<&Mlp> {
        vec![&self.mlp]
    }

    fn directions(&self) -> Directions<'_> {
        Directions::Perceptron {
            mlp: &self.mlp,
            inputs: (self.tables[0].channels() - 1..self.mlp.inputs()).collect(),
            are_harmonics: false,
        }
    }

    fn void(&self) -> Option<[u64; 2]> {
        let filled = &self.mask.as_ref()?.filled;
        let void = filled.iter().filter(|filled| !**filled).count();
        Some([void as u64, filled.len() as u64])
    }

    fn sampling(&self) -> Sampling {
        Sampling {
            bounds: self.bounds,
            step: self.step,
            range: self.range,
            along: Along::Axis,
            least_opacity: self.least,
            least_weight: self.least,
            stop: STOP,
        }
    }

    fn stepped(&self) -> Option<&dyn Stepped> {
        Some(self)
    }

    fn assumed(&self) -> Option<String> {
        let [near, far] = self.range;
        Some(format!(
            "depths of samples, {near} to {far}: assumed, since the file does not state them"
        ))
    }

    fn coded(&self, config: &Config) -> Result<QuantisedField<'_>, FieldError> {
        let FixedDvgo { volume, head } = self.fixed(config)?;
        Ok(QuantisedField {
            storage: Storage::Volume(Box::new(volume)),
            head: Box::new(head),
        })
    }

    fn bounds(
        &self,
        config: &Config,
        vector: &VectorBounds,
        camera: &Camera,
    ) -> Result<Option<Box<dyn Bounds + '_>>, FieldError> {
        Ok(Some(Box::new(bound::bounds(self, config, vector, camera)?)))
    }
}

impl Stepped for Dvgo {
    fn with_step(&self, step: f64) -> AnyField {
        let scale = step / self.spacing_of_steps;
        AnyField::new(Self {
            interval: self.interval * scale,
            step: self.step * scale,
            spacing_of_steps: step,
            ..self.clone()
        })
    }
}
