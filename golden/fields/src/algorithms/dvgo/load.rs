//! Checkpoints of the authors' code: `model_kwargs` and `model_state_dict`.

use std::path::Path;

use glam::{DVec3, dvec3};

use super::{DVGO, Dvgo, LEAST, MAX_FREQUENCIES};
use crate::calibrate::Magnitudes;
use crate::volume::{Blocks, Mask};
use crate::{FieldError, Layer, Mlp, Table};
use potamoi_base::file_keys::Notes;
use potamoi_containers::torch::{Checkpoint, Tensor};

/// Nearest and farthest depth of samples, which checkpoints do not state: those of NeRF's
/// synthetic scenes.
const RANGE: [f64; 2] = [2.0, 6.0];

fn state(name: &str) -> [&str; 2] {
    ["model_state_dict", name]
}

impl Dvgo {
    /// Loads a `fine_last.tar` of the authors' code. `step` is the distance of samples in voxels;
    /// models are trained with 0.5.
    ///
    /// # Errors
    /// The file is not such a checkpoint, a part is missing or inconsistent, or the variant is not
    /// supported (compressed grids, an implicit colour network).
    pub fn load(path: &Path, step: f64) -> Result<Self, FieldError> {
        let mut file = Checkpoint::open(path)?;
        Self::read(&mut file, step).map_err(|e| e.of_file(path))
    }

    fn read(file: &mut Checkpoint, step: f64) -> Result<Self, FieldError> {
        file.refuse(&DVGO)?;
        for (name, wanted) in [
            // 1 is True to Python.
            ("rgbnet_direct", &["True", "1"][..]),
            ("density_type", &["'DenseGrid'"]),
            ("k0_type", &["'DenseGrid'"]),
        ] {
            file.says_only(&["model_kwargs", name], wanted)?;
        }
        let Grids {
            points,
            density,
            features,
            count,
        } = Grids::read(file)?;
        let bounds = corners(file)?;
        let size = bounds[1] - bounds[0];
        let voxels = within(file, &["model_kwargs", "num_voxels"], ABOVE_0)?;
        let voxel = (size.element_product() / voxels).cbrt();
        let ratio = within(file, &["model_kwargs", "voxel_size_ratio"], ABOVE_0)?;
        let mlp = perceptron(file)?;
        let frequencies = frequencies(file)?;
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
            blocks: Blocks::default(),
            magnitudes: Magnitudes::default(),
        })
    }
}

/// The two grids of a model.
struct Grids {
    points: [usize; 3],
    density: Tensor,
    features: Tensor,
    /// Features a vertex.
    count: usize,
}

impl Grids {
    fn read(file: &mut Checkpoint) -> Result<Self, FieldError> {
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
        Ok(Self {
            points,
            density,
            features,
            count,
        })
    }
}

/// Corners of the box whose faces contain the outer vertices.
fn corners(file: &mut Checkpoint) -> Result<[DVec3; 2], FieldError> {
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
    Ok(bounds)
}

/// Frequencies of the direction's encoding.
fn frequencies(file: &mut Checkpoint) -> Result<Vec<f64>, FieldError> {
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
    Ok(frequencies)
}

/// A range of allowed numbers, and its description. NaN is in no range.
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

/// The most places of layers that are looked at.
const MAX_PLACES: usize = 16;

/// Layers `rgbnet.0`, `rgbnet.2.0`, `rgbnet.3.0`, ..., `rgbnet.N`, as the authors' code nests them:
/// a rectifier follows a layer in the place behind it, or is nested with it. The last layer has none.
/// Layers beyond a gap are left in the file, and [`Checkpoint::finish`] refuses them.
fn perceptron(file: &mut Checkpoint) -> Result<Mlp, FieldError> {
    let is_there = |file: &Checkpoint, name: &str| {
        ["weight", "bias"].iter().any(|part| {
            let key = format!("{name}.{part}");
            file.has(&["model_state_dict", &key])
        })
    };
    let mut layers = vec![];
    let (mut place, mut is_last) = (0, false);
    while place < MAX_PLACES {
        let plain = format!("rgbnet.{place}");
        let nested = format!("{plain}.0");
        if !is_there(file, &plain) && is_there(file, &nested) {
            layers.push(layer(file, &nested)?);
            (place, is_last) = (place + 1, false);
        } else if is_last && !is_there(file, &plain) {
            break;
        } else {
            layers.push(layer(file, &plain)?);
            // Whatever follows, a rectifier is between.
            (place, is_last) = (place + 2, true);
        }
    }
    Mlp::new(layers)
}

fn layer(file: &mut Checkpoint, name: &str) -> Result<Layer, FieldError> {
    let weight = format!("{name}.weight");
    let keys = ["model_state_dict", weight.as_str()];
    let tensor = file.floats(&keys)?;
    let [outputs, inputs] = tensor.shape[..] else {
        let found = format!("of shape {:?}", tensor.shape);
        return Err(file.field(&keys, found, "[outputs, inputs]").into());
    };
    let bias = format!("{name}.bias");
    let bias = file.floats_of(&["model_state_dict", &bias], &[outputs])?;
    Layer::new(inputs, tensor.values, bias.values)
}

/// The mask. Its positions are relative to vertices of the grid, the first of which is at
/// `corner`.
fn mask(file: &mut Checkpoint, corner: DVec3, spacing: DVec3) -> Result<Option<Mask>, FieldError> {
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

/// Reorders values from z fastest to x fastest.
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
