//! TensoRF (Chen, Xu, Geiger, Yu, Su, ECCV 2022) in its vector-matrix form: a
//! volume is a sum of products of planes and lines.
//!
//! Mode `m` pairs the plane of two axes with the line of the third. A sample gathers density and
//! appearance components of three planes and three lines. The sum of the density products is the
//! density before its activation. The appearance products, times a matrix, are the inputs of a
//! small perceptron that computes the colour.
//!
//! Samples lie as in the authors' code: from the entry of a ray into the box, or from the nearest
//! distance if that is farther, in steps of a mean voxel edge times the step ratio. Colour is
//! computed if the weight in the pixel is above a threshold. Rays terminate at a transmittance of
//! one millionth.

mod bound;
mod fixed;
#[cfg(test)]
mod fuzz;
mod keys;
mod load;
mod mask;
mod planes;
mod rules;
#[cfg(test)]
mod tests;

use glam::{DVec3, dvec3};
use potamoi_formats::config::Config;

use crate::calibrate::Magnitudes;
use crate::{
    Algorithm, Along, AnyField, Bounds, Directions, Field, FieldError, FieldFile, Layer,
    LoadedField, Mlp, QuantisedField, Sampling, Size, Stepped, Table, sigmoid, softplus,
    unverified_work,
};
pub use keys::TENSORF;
use mask::AlphaMask;
pub use planes::KnownValues;
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Notes;
use potamoi_reference::bounds::VectorBounds;
pub use rules::{Activation, Rules};

/// Axes of each plane, the faster one first.
pub const PLANES: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];
/// Axis of the line that goes with each plane.
pub const LINES: [usize; 3] = [2, 1, 0];
/// Early-termination threshold (transmittance): too small to be seen in a picture.
const STOP: f64 = 1e-6;

/// A TensoRF model.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Tensorf {
    /// The planes, then the lines; density components precede those of appearance.
    tables: [Table; 6],
    /// Number of density components in each mode.
    density: [usize; 3],
    /// Matrix from products of appearance components to features.
    basis: Mlp,
    mlp: Mlp,
    rules: Rules,
    mask: Option<AlphaMask>,
    /// Unused parts of the checkpoint.
    #[serde(skip)]
    notes: Notes,
    /// Of the outputs of its perceptrons.
    #[serde(skip)]
    magnitudes: Magnitudes,
    /// Number of vertices along x, y, z.
    points: [usize; 3],
}

fn part(part: &'static str, found: String, expected: impl Into<String>) -> FieldError {
    FieldError::Part {
        part,
        found,
        expected: expected.into(),
    }
}

impl Tensorf {
    /// A model of three planes and three lines in the order of [`PLANES`] and [`LINES`]. The first
    /// `density` channels of each are density components, the others appearance components.
    /// `basis` computes features from the products of the latter.
    ///
    /// # Errors
    /// The parts do not fit one another.
    pub fn new(
        tables: [Table; 6],
        density: [usize; 3],
        basis: Layer,
        mlp: Mlp,
        rules: Rules,
    ) -> Result<Self, FieldError> {
        if let Some((field, value, expected)) = rules.problem() {
            return Err(part(field, value, expected));
        }
        let [x, y] = [tables[0].points()[0], tables[0].points()[1]];
        let points = [x, y, tables[3].points()[0]];
        if points.iter().any(|p| *p < 2) {
            let found = format!("{points:?} vertices");
            return Err(part("gridSize", found, "2 or more along each axis"));
        }
        for mode in 0..3 {
            let [a, b] = PLANES[mode].map(|axis| points[axis]);
            let (plane, line) = (&tables[mode], &tables[3 + mode]);
            let (wanted, along) = ([a, b, 1], [points[LINES[mode]], 1, 1]);
            if plane.points() != wanted || line.points() != along {
                let found = format!("{:?} and {:?} vertices", plane.points(), line.points());
                let expected = format!("{wanted:?} and {along:?}, as the others have");
                return Err(part("plane and line", found, expected));
            }
            let channels = plane.channels();
            if line.channels() != channels || !(1..channels).contains(&density[mode]) {
                let found = format!(
                    "{channels} and {} channels, {} of them of density",
                    line.channels(),
                    density[mode]
                );
                let expected = "as many, at least one of density and one of appearance";
                return Err(part("plane and line", found, expected));
            }
        }
        let products: usize = (0..3).map(|m| tables[m].channels() - density[m]).sum();
        if basis.inputs() != products {
            let found = format!("of {} inputs", basis.inputs());
            let expected = format!("{products}, one an appearance component");
            return Err(part("basis_mat", found, expected));
        }
        let inputs = rules.inputs(basis.outputs());
        if mlp.inputs() != inputs || mlp.outputs() != 3 {
            let found = format!("of {} inputs, {} outputs", mlp.inputs(), mlp.outputs());
            let expected = format!(
                "{inputs} inputs ({} features, the direction, and their sines and cosines), \
                 3 outputs",
                basis.outputs()
            );
            return Err(part("renderModule.mlp", found, expected));
        }
        Ok(Self {
            tables,
            density,
            basis: Mlp::new(vec![basis])?,
            mlp,
            rules,
            mask: None,
            notes: Notes::default(),
            magnitudes: Magnitudes::default(),
            points,
        })
    }

    /// Activation, sampling and thresholds.
    #[must_use]
    pub const fn rules(&self) -> &Rules {
        &self.rules
    }

    /// The same planes and lines with `points` vertices along x, y, z, at least 2 each, interpolated
    /// between their own. Steps are shorter in proportion.
    ///
    /// # Errors
    /// The sizes are out of range.
    pub fn resampled(&self, points: [usize; 3]) -> Result<Self, FieldError> {
        let mut tables = self.tables.clone();
        for mode in 0..3 {
            let [a, b] = PLANES[mode].map(|axis| points[axis]);
            tables[mode] = resampled(&tables[mode], [a, b, 1])?;
            tables[3 + mode] = resampled(&tables[3 + mode], [points[LINES[mode]], 1, 1])?;
        }
        Ok(Self {
            tables,
            points,
            magnitudes: Magnitudes::default(),
            ..self.clone()
        })
    }

    /// Number of vertices along x, y, z.
    #[must_use]
    pub const fn points(&self) -> [usize; 3] {
        self.points
    }

    /// Distance between samples, in world units.
    fn step(&self) -> f64 {
        let [low, high] = self.rules.bounds;
        let last = DVec3::from(self.points.map(|p| p as f64 - 1.0));
        ((high - low) / last).element_sum() / 3.0 * self.rules.step_ratio
    }

    /// Calls `with` for each mode, with the components of its plane and of its line, and the
    /// number of density components.
    fn modes(&self, features: &[f64], mut with: impl FnMut(&[f64], &[f64], usize)) {
        let half: usize = self.tables[..3].iter().map(Table::channels).sum();
        let (mut planes, mut lines) = features.split_at(half);
        for mode in 0..3 {
            let channels = self.tables[mode].channels();
            let (plane, line) = (&planes[..channels], &lines[..channels]);
            with(plane, line, self.density[mode]);
            (planes, lines) = (&planes[channels..], &lines[channels..]);
        }
    }

    /// The sum of all products of density components.
    fn density(&self, features: &[f64]) -> f64 {
        let mut sum = 0.0;
        self.modes(features, |plane, line, density| {
            let pairs = plane.iter().zip(line).take(density);
            sum += pairs.map(|(p, l)| p * l).sum::<f64>();
        });
        sum
    }

    /// Features of appearance.
    fn appearance(&self, features: &[f64], out: &mut Vec<f64>) {
        out.clear();
        self.products(features, out);
        self.basis.run(out);
    }

    /// Appends the products of appearance components.
    fn products(&self, features: &[f64], out: &mut Vec<f64>) {
        self.modes(features, |plane, line, density| {
            let pairs = plane.iter().zip(line).skip(density);
            out.extend(pairs.map(|(p, l)| p * l));
        });
    }

    /// Appends the encodings of features and direction, the other inputs of the perceptron.
    fn inputs(&self, direction: DVec3, values: &mut Vec<f64>) {
        let count = values.len();
        values.extend(direction.to_array());
        encode(0..count, self.rules.feature_frequencies, values);
        encode(count..count + 3, self.rules.view_frequencies, values);
    }
}

/// A dense table with `points` vertices along each axis, interpolated between its own.
fn resampled(table: &Table, points: [usize; 3]) -> Result<Table, FieldError> {
    let channels = table.channels();
    let finer = [0, 1, 2].map(|axis| {
        let edges = |points: [usize; 3]| (points[axis] - 1) as f64;
        edges(table.points()) / edges(points).max(1.0)
    });
    let [nx, ny, nz] = points;
    let mut values = Vec::with_capacity(nx * ny * nz * channels);
    let mut own = vec![0.0; channels];
    for i in 0..nx * ny * nz {
        let vertex = [i % nx, i / nx % ny, i / (nx * ny)];
        let place = [0, 1, 2].map(|axis| vertex[axis] as f64 * finer[axis]);
        table.gather(DVec3::from(place), &mut own);
        values.extend(own.iter().map(|v| *v as f32));
    }
    Table::new(points, channels, values)
}

/// Appends the sines of each value times 1, 2, 4 and so on, value after value, then the cosines.
fn encode(from: std::ops::Range<usize>, frequencies: usize, all: &mut Vec<f64>) {
    for wave in [f64::sin, f64::cos] {
        for i in from.clone() {
            let value = all[i];
            all.extend((0..frequencies).map(|k| wave(value * 2f64.powi(k as i32))));
        }
    }
}

/// Description of the algorithm for reports.
pub static ALGORITHM: Algorithm = Algorithm {
    name: "TensoRF",
    outside: &[
        unverified_work::INDEXING,
        unverified_work::MASK,
        unverified_work::RIT,
        unverified_work::MATRIX,
        unverified_work::FEATURE_WAVES,
        unverified_work::WAVES,
        unverified_work::PERCEPTRONS,
        unverified_work::COMPOSITING,
    ],
    full_size: Some(Size::Points(300)),
    preset: "fields",
    file: Some(FieldFile {
        kind: "tensorf",
        endings: &["th"],
        format: &TENSORF,
        keys: &["path"],
        // On which such models of objects are trained.
        background: [1.0; 3],
        load: |path, _| {
            let field = Tensorf::load(path)?;
            Ok(LoadedField {
                notes: field.notes.clone(),
                field: AnyField::new(field),
            })
        },
    }),
};

impl Field for Tensorf {
    fn algorithm(&self) -> &'static Algorithm {
        &ALGORITHM
    }

    fn tables(&self) -> &[Table] {
        &self.tables
    }

    fn holds(&self, at: DVec3) -> bool {
        self.mask.as_ref().is_none_or(|mask| mask.holds(at))
    }

    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        let [low, high] = self.rules.bounds;
        let last = DVec3::from(self.points.map(|p| p as f64 - 1.0));
        let place = (at - low) / (high - low) * last;
        for mode in 0..3 {
            let [a, b] = PLANES[mode];
            places[mode] = dvec3(place[a], place[b], 0.0);
            places[3 + mode] = dvec3(place[LINES[mode]], 0.0, 0.0);
        }
    }

    fn depth(&self, features: &[f64]) -> f64 {
        let sum = self.density(features);
        let density = match self.rules.activation {
            Activation::Softplus => softplus(sum + self.rules.density_shift),
            Activation::Relu => sum.max(0.0),
        };
        density * self.step() * self.rules.distance_scale
    }

    fn colour(&self, features: &[f64], direction: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
        self.appearance(features, scratch);
        self.inputs(direction, scratch);
        self.mlp.run(scratch);
        DVec3::from([0, 1, 2].map(|channel| sigmoid(scratch[channel])))
    }

    /// The products of appearance components.
    fn kept(&self) -> usize {
        self.basis.inputs()
    }

    fn depths(&self, features: &[f64], depths: &mut Vec<f64>, kept: &mut Vec<f64>) {
        depths.clear();
        kept.clear();
        for features in features.chunks_exact(self.channels()) {
            depths.push(self.depth(features));
            self.products(features, kept);
        }
    }

    fn encoded(&self) -> usize {
        3 + 6 * self.rules.view_frequencies
    }

    fn encode(&self, direction: DVec3, out: &mut Vec<f64>) {
        let first = out.len();
        out.extend(direction.to_array());
        encode(first..first + 3, self.rules.view_frequencies, out);
    }

    fn colours(&self, kept: &[f64], directions: &[f64], out: &mut Vec<DVec3>) {
        let mut features = kept.to_vec();
        self.basis.run(&mut features);
        let samples = features.chunks_exact(self.basis.outputs());
        let mut values = Vec::with_capacity(self.mlp.inputs() * samples.len());
        for (features, direction) in samples.zip(directions.chunks_exact(self.encoded())) {
            let first = values.len();
            let (direction, waves) = direction.split_at(3);
            values.extend_from_slice(features);
            values.extend_from_slice(direction);
            let encoded = first..first + features.len();
            encode(encoded, self.rules.feature_frequencies, &mut values);
            values.extend_from_slice(waves);
        }
        self.mlp.run(&mut values);
        out.clear();
        let logits = values.as_chunks::<3>().0.iter();
        out.extend(logits.map(|logits| DVec3::from(logits.map(sigmoid))));
    }

    fn perceptrons(&self) -> Vec<&Mlp> {
        vec![&self.basis, &self.mlp]
    }

    fn directions(&self) -> Directions<'_> {
        let features = self.basis.outputs();
        let waves = features + 3 + 2 * features * self.rules.feature_frequencies;
        Directions::Perceptron {
            mlp: &self.mlp,
            inputs: (features..features + 3)
                .chain(waves..self.mlp.inputs())
                .collect(),
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
            bounds: self.rules.bounds,
            step: self.step(),
            range: [self.rules.near, f64::INFINITY],
            along: Along::Ray,
            least_opacity: 0.0,
            least_weight: self.rules.weight_threshold,
            stop: STOP,
        }
    }

    fn stepped(&self) -> Option<&dyn Stepped> {
        Some(self)
    }

    fn coded(&self, config: &Config) -> Result<QuantisedField<'_>, FieldError> {
        fixed::coded(self, config)
    }

    fn bounds(
        &self,
        config: &Config,
        vector: &VectorBounds,
        _: &Camera,
    ) -> Result<Option<Box<dyn Bounds + '_>>, FieldError> {
        Ok(Some(Box::new(bound::bounds(self, config, vector)?)))
    }
}

impl Stepped for Tensorf {
    fn with_step(&self, step: f64) -> AnyField {
        let mut other = self.clone();
        other.rules.step_ratio = step;
        AnyField::new(other)
    }
}
