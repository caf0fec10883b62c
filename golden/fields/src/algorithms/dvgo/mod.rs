//! DirectVoxGO (Sun, Sun, Chen, CVPR 2022): a dense grid of densities, one of
//! twelve features, and a small perceptron that turns features and viewing
//! direction into colour.
//!
//! Densities are interpolated before their activation, `alpha = 1 - (1 +
//! exp(d + shift))^-interval`, which is `1 - exp(-interval softplus(d +
//! shift))`: softplus, a product, and `one-minus-exp`.

mod bound;
mod fixed;
mod keys;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::{DVec3, dvec3};
use potamoi_formats::config::Config;

use crate::voxels::Mask;
use crate::{
    Algorithm, Along, AnyField, Bounds, Coded, Directions, Field, FieldError, FieldFile, Layer,
    LoadedField, Mlp, Sampling, Size, Stepped, Storage, Table, outside, softplus,
};
use potamoi_base::camera::Camera;
use potamoi_base::record::Notes;
use potamoi_containers::torch::{Checkpoint, Tensor};
use potamoi_reference::bounds::VectorBounds;

use fixed::FixedDvgo;
pub use keys::DVGO;

/// Rounds of sines and cosines of the direction, by the factor 2.
const MAX_FREQUENCIES: usize = 16;
/// Samples and weights below are left out, unless a file says otherwise.
const LEAST: f64 = 1e-4;
/// A ray ends where less than this is left.
const STOP: f64 = 1e-3;
/// Nearest and farthest depth of samples in checkpoints, which do not say: those
/// of NeRF's synthetic scenes.
const RANGE: [f64; 2] = [2.0, 6.0];

/// Voxels from sample to sample as its authors train it.
const TRAINED_STEP: f64 = 0.5;

/// A DirectVoxGO model of its fine stage.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Dvgo {
    /// Channel 0 is the density, the features follow.
    tables: [Table; 1],
    bounds: [DVec3; 2],
    /// Where something may be, at the vertices of a grid of its own.
    mask: Option<Mask>,
    shift: f64,
    interval: f64,
    step: f64,
    /// The step in voxels.
    spacing_of_steps: f64,
    /// Depths of the nearest and the farthest sample.
    range: [f64; 2],
    least: f64,
    /// Factors of the direction whose sines and cosines are inputs.
    frequencies: Vec<f64>,
    mlp: Mlp,
    /// What a checkpoint says that is not used.
    #[serde(skip)]
    notes: Notes,
}

impl Dvgo {
    /// Loads `fine_last.tar` of that code base's own layout. `step` is the
    /// distance of samples in voxels, 0.5 as it was trained.
    ///
    /// # Errors
    /// No such checkpoint, a part that is missing or does not fit, or a variant
    /// that is not read (compressed grids, an implicit colour network).
    pub fn load(path: &Path, step: f64) -> Result<Self, FieldError> {
        let mut file = Checkpoint::open(path)?;
        Self::read(&mut file, step).map_err(|e| e.of_file(path))
    }

    fn read(file: &mut Checkpoint, step: f64) -> Result<Self, FieldError> {
        file.refuse(&DVGO)?;
        let state = |name| ["model_state_dict", name];
        for (name, wanted) in [
            // 1 is True to Python.
            ("rgbnet_direct", &["True", "1"][..]),
            ("density_type", &["'DenseGrid'"]),
            ("k0_type", &["'DenseGrid'"]),
        ] {
            file.says_only(&["model_kwargs", name], wanted)?;
        }
        let density = file.floats(&state("density.grid"))?;
        let [1, 1, x, y, z] = density.shape[..] else {
            let found = format!("of shape {:?}", density.shape);
            let expected = "a tensor of shape [1, 1, X, Y, Z]";
            return Err(file.field(&state("density.grid"), found, expected).into());
        };
        let points = [x, y, z];
        if points.iter().any(|p| *p < 2) {
            let found = format!("of shape {:?}", density.shape);
            let expected = "2 or more vertices along each axis";
            return Err(file.field(&state("density.grid"), found, expected).into());
        }
        let features = file.floats(&state("k0.grid"))?;
        let count = match features.shape[..] {
            [1, c, fx, fy, fz] if [fx, fy, fz] == points && c > 0 => c,
            _ => {
                let found = format!("of shape {:?}", features.shape);
                let expected = format!("[1, C, {x}, {y}, {z}], as density.grid has");
                return Err(file.field(&state("k0.grid"), found, &expected).into());
            }
        };
        let corner = |file: &mut Checkpoint, name| -> Result<DVec3, FieldError> {
            let values = file.floats_of(&state(name), &[3])?.values;
            Ok(dvec3(values[0].into(), values[1].into(), values[2].into()))
        };
        let bounds = [corner(file, "xyz_min")?, corner(file, "xyz_max")?];
        let size = bounds[1] - bounds[0];
        if !(size.is_finite() && size.cmpgt(DVec3::splat(1e-6)).all()) {
            let found = bounds[1].to_string();
            let expected = format!("finite and above xyz_min, {}", bounds[0]);
            return Err(file.field(&state("xyz_max"), found, &expected).into());
        }
        let voxels = within(file, &["model_kwargs", "num_voxels"], ABOVE_0)?;
        let voxel = (size.element_product() / voxels).cbrt();
        let ratio = within(file, &["model_kwargs", "voxel_size_ratio"], ABOVE_0)?;
        let mlp = perceptron(file)?;
        let frequencies: Vec<f64> = match file.floats(&state("viewfreq"))?.values {
            list if list.len() <= MAX_FREQUENCIES => list.iter().map(|v| f64::from(*v)).collect(),
            list => {
                let found = format!("{} frequencies", list.len());
                return Err(file.field(&state("viewfreq"), found, "at most 16").into());
            }
        };
        if let Some(v) = frequencies.iter().find(|v| !v.is_finite()) {
            let expected = "finite numbers";
            return Err(file
                .field(&state("viewfreq"), v.to_string(), expected)
                .into());
        }
        let inputs = count + 3 + 6 * frequencies.len();
        if mlp.inputs() != inputs || mlp.outputs() != 3 {
            let found = format!("{} inputs and {} outputs", mlp.inputs(), mlp.outputs());
            let expected =
                format!("{inputs} inputs ({count} features and the direction), 3 outputs");
            return Err(file.field(&state("rgbnet"), found, &expected).into());
        }
        let least = if file.has(&["model_kwargs", "fast_color_thres"]) {
            within(file, &["model_kwargs", "fast_color_thres"], SHARE)?
        } else {
            LEAST
        };
        let last = DVec3::from(points.map(|p| (p - 1) as f64));
        let mask = mask(file, bounds[0], size / last)?;
        let shift = within(file, &state("act_shift"), FINITE)?;
        let mut notes = Notes::default();
        file.finish(&DVGO, &mut notes)?;
        Ok(Self {
            tables: [Table::new(
                points,
                1 + count,
                interleave(points, &density, &features),
            )?],
            bounds,
            mask,
            shift,
            interval: step * ratio,
            step: step * voxel,
            spacing_of_steps: step,
            range: RANGE,
            least,
            frequencies,
            mlp,
            notes,
        })
    }
}

/// What a model is made of, besides a checkpoint.
#[derive(Debug, Clone, PartialEq)]
pub struct Parts {
    /// A volume whose channel 0 is the density before its activation; features
    /// follow.
    pub table: Table,
    /// Vertices of the table about which something may be, x fastest.
    pub filled: Vec<bool>,
    /// The corners of the box on whose faces its outer vertices lie.
    pub bounds: [DVec3; 2],
    /// Added to densities.
    pub shift: f64,
    /// Optical depth of a mean voxel edge where softplus gives 1.
    pub scale: f64,
    /// Mean voxel edges from sample to sample.
    pub step: f64,
    /// Depths of the nearest and the farthest sample; the latter may be
    /// infinite.
    pub range: [f64; 2],
    /// Rounds of sines and cosines of the direction, by the factor 2.
    pub frequencies: usize,
    /// From features and the direction to logits of colour.
    pub mlp: Mlp,
}

impl Dvgo {
    /// A model of its parts.
    ///
    /// # Errors
    /// A perceptron or a mask that does not fit the table, or numbers out of
    /// range.
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
        })
    }
}

/// A range that a number may be in, and how that is said. Not a number is in none.
type Allowed = (fn(f64) -> bool, &'static str);
const ABOVE_0: Allowed = (|v| v > 0.0 && v.is_finite(), "a number above 0");
const SHARE: Allowed = (|v| (0.0..1.0).contains(&v), "0 and up, below 1");
const FINITE: Allowed = (f64::is_finite, "a finite number");

fn within(
    file: &mut Checkpoint,
    keys: &[&str],
    (right, expected): Allowed,
) -> Result<f64, FieldError> {
    let value = file.number(keys)?;
    if right(value) {
        return Ok(value);
    }
    Err(file.field(keys, value.to_string(), expected).into())
}

/// Layers `rgbnet.0`, `rgbnet.2.0`, ..., `rgbnet.N`, as that code base nests
/// them.
fn perceptron(file: &mut Checkpoint) -> Result<Mlp, FieldError> {
    let mut layers = vec![];
    for i in 0..16 {
        for name in [format!("rgbnet.{i}"), format!("rgbnet.{i}.0")] {
            let weight = format!("{name}.weight");
            if !file.has(&["model_state_dict", &weight]) {
                continue;
            }
            let tensor = file.floats(&["model_state_dict", &weight])?;
            let [outputs, inputs] = tensor.shape[..] else {
                let found = format!("of shape {:?}", tensor.shape);
                let keys = ["model_state_dict", weight.as_str()];
                return Err(file.field(&keys, found, "[outputs, inputs]").into());
            };
            let bias = format!("{name}.bias");
            let bias = file.floats_of(&["model_state_dict", &bias], &[outputs])?;
            layers.push(Layer::new(inputs, tensor.values, bias.values)?);
        }
    }
    Mlp::new(layers)
}

/// The mask, its places told from vertices of the grid, the first of which is at
/// `corner`.
fn mask(file: &mut Checkpoint, corner: DVec3, spacing: DVec3) -> Result<Option<Mask>, FieldError> {
    let state = |name| ["model_state_dict", name];
    if !file.has(&state("mask_cache.mask")) {
        return Ok(None);
    }
    let tensor = file.tensor(&state("mask_cache.mask"))?;
    let [x, y, z] = tensor.shape[..] else {
        let found = format!("of shape {:?}", tensor.shape);
        return Err(file
            .field(&state("mask_cache.mask"), found, "[X, Y, Z]")
            .into());
    };
    let mut three = |name| -> Result<DVec3, FieldError> {
        let v = file.floats_of(&state(name), &[3])?.values;
        let v = dvec3(v[0].into(), v[1].into(), v[2].into());
        if v.is_finite() {
            return Ok(v);
        }
        Err(file
            .field(&state(name), v.to_string(), "finite numbers")
            .into())
    };
    let (scale, shift) = (
        three("mask_cache.xyz2ijk_scale")?,
        three("mask_cache.xyz2ijk_shift")?,
    );
    Ok(Some(Mask {
        points: [x, y, z],
        scale: spacing * scale,
        shift: corner * scale + shift,
        filled: transposed([x, y, z], &tensor.values)
            .map(|v| v != 0.0)
            .collect(),
    }))
}

/// Values that are stored z fastest, x fastest.
fn transposed(points: [usize; 3], values: &[f32]) -> impl Iterator<Item = f32> {
    let [x, y, z] = points;
    (0..x * y * z).map(move |i| {
        let (ix, iy, iz) = (i % x, i / x % y, i / (x * y));
        values[(ix * y + iy) * z + iz]
    })
}

fn interleave(points: [usize; 3], density: &Tensor, features: &Tensor) -> Vec<f32> {
    let vertices = points.iter().product::<usize>();
    let count = features.values.len() / vertices;
    let mut all = vec![0.0; vertices * (1 + count)];
    let grids = std::iter::once(&density.values[..]).chain(features.values.chunks_exact(vertices));
    for (channel, grid) in grids.enumerate() {
        for (vertex, value) in transposed(points, grid).enumerate() {
            all[vertex * (1 + count) + channel] = value;
        }
    }
    all
}

/// A direction, and the sines and then the cosines of its parts times each
/// frequency.
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
    /// Where a point of the world lies, in vertices.
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

/// As reports tell it.
pub static ALGORITHM: Algorithm = Algorithm {
    name: "DirectVoxGO",
    outside: &[
        outside::INDEXING,
        outside::MASK,
        outside::RIT,
        outside::WAVES,
        outside::PERCEPTRONS,
        outside::COMPOSITING,
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

    fn depth(&self, features: &[f64]) -> f64 {
        self.interval * softplus(features[0] + self.shift)
    }

    fn colour(&self, features: &[f64], direction: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
        self.inputs(features, direction, scratch);
        self.mlp.run(scratch);
        let sigmoid = |x: f64| 1.0 / (1.0 + (-x).exp());
        dvec3(
            sigmoid(scratch[0]),
            sigmoid(scratch[1]),
            sigmoid(scratch[2]),
        )
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
            "depths of samples, {near} to {far}: assumed, the file does not say"
        ))
    }

    fn coded(&self, config: &Config) -> Result<Coded<'_>, FieldError> {
        let FixedDvgo { volume, head } = self.fixed(config)?;
        Ok(Coded {
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
