//! Checkpoints of the authors' code: `kwargs`, `state_dict`, and the mask.

use std::path::Path;

use glam::{DVec3, dvec3};

use super::mask::AlphaMask;
use super::rules::MAX_FREQUENCIES;
use super::{Activation, LINES, PLANES, Rules, TENSORF, Tensorf};
use crate::{FieldError, Layer, Mlp, Table};
use potamoi_containers::torch::{Checkpoint, TorchError};

/// Maximum number of vertices along an axis.
const MAX_POINTS: usize = 1 << 14;
/// Maximum number of components in a mode.
const MAX_COMPONENTS: usize = 1 << 10;
/// Maximum number of appearance features.
const MAX_FEATURES: usize = 1 << 8;
/// Maximum number of vertices in the mask.
const MAX_MASK: usize = 1 << 30;

fn kwarg(name: &str) -> [&str; 2] {
    ["kwargs", name]
}

/// A whole number within a range.
fn whole(
    file: &Checkpoint,
    keys: &[&str],
    value: f64,
    range: std::ops::RangeInclusive<usize>,
) -> Result<usize, TorchError> {
    let (low, high) = (*range.start(), *range.end());
    if value.fract() == 0.0 && (low as f64..=high as f64).contains(&value) {
        return Ok(value as usize);
    }
    let expected = format!("a whole number from {low} to {high}");
    Err(file.field(keys, value.to_string(), &expected))
}

/// Numbers of a list or a tensor.
fn list<const N: usize>(file: &mut Checkpoint, keys: &[&str]) -> Result<[f64; N], TorchError> {
    let values = match file.tensor(keys) {
        Ok(tensor) => tensor.values.iter().map(|v| f64::from(*v)).collect(),
        Err(_) => file.numbers(keys)?,
    };
    let count = values.len();
    values.try_into().map_err(|_| {
        let expected = format!("{N} of them");
        file.field(keys, format!("{count} numbers"), &expected)
    })
}

fn wholes(
    file: &mut Checkpoint,
    name: &str,
    range: std::ops::RangeInclusive<usize>,
) -> Result<[usize; 3], TorchError> {
    let keys = kwarg(name);
    let values = list::<3>(file, &keys)?;
    let mut out = [0; 3];
    for (to, value) in out.iter_mut().zip(values) {
        *to = whole(file, &keys, value, range.clone())?;
    }
    Ok(out)
}

fn named(file: &Checkpoint, name: &str, expected: &str) -> Result<String, TorchError> {
    let keys = kwarg(name);
    let text = file.text(&keys).map(str::to_owned);
    text.ok_or_else(|| file.field(&keys, "no text".to_owned(), expected))
}

fn rules(file: &mut Checkpoint) -> Result<Rules, TorchError> {
    let shading = named(file, "shadingMode", "MLP_Fea")?;
    if shading != "MLP_Fea" {
        let expected = "MLP_Fea: other shading modes are not read";
        return Err(file.field(&kwarg("shadingMode"), shading, expected));
    }
    let activation = named(file, "fea2denseAct", "softplus or relu")?;
    let activation = match activation.as_str() {
        "softplus" => Activation::Softplus,
        "relu" => Activation::Relu,
        _ => return Err(file.field(&kwarg("fea2denseAct"), activation, "softplus or relu")),
    };
    let [ax, ay, az, bx, by, bz] = list(file, &kwarg("aabb"))?;
    let near_far @ [near, far] = list(file, &kwarg("near_far"))?;
    if !(near.is_finite() && far.is_finite() && near >= 0.0 && near < far) {
        let expected = "finite depths from 0, the nearest before the farthest";
        return Err(file.field(&kwarg("near_far"), format!("{near_far:?}"), expected));
    }
    let mut number = |name: &str| file.number(&kwarg(name));
    let mut rules = Rules {
        activation,
        density_shift: number("density_shift")?,
        distance_scale: number("distance_scale")?,
        step_ratio: number("step_ratio")?,
        weight_threshold: number("rayMarch_weight_thres")?,
        near,
        ..Rules::new([dvec3(ax, ay, az), dvec3(bx, by, bz)])
    };
    for (name, to) in [
        ("fea_pe", &mut rules.feature_frequencies),
        ("view_pe", &mut rules.view_frequencies),
    ] {
        let value = file.number(&kwarg(name))?;
        *to = whole(file, &kwarg(name), value, 0..=MAX_FREQUENCIES)?;
    }
    match rules.problem() {
        Some((field, value, expected)) => Err(file.field(&kwarg(field), value, expected)),
        None => Ok(rules),
    }
}

/// Interleaves two tensors of `[1, components, ...]`, components fastest.
fn interleaved(density: &[f32], appearance: &[f32], vertices: usize) -> Vec<f32> {
    let mut all = Vec::with_capacity(density.len() + appearance.len());
    for vertex in 0..vertices {
        for part in [density, appearance] {
            all.extend(part.iter().skip(vertex).step_by(vertices));
        }
    }
    all
}

fn layer(file: &mut Checkpoint, name: &str, shape: [usize; 2]) -> Result<Layer, FieldError> {
    let (weight, bias) = (format!("{name}.weight"), format!("{name}.bias"));
    let weight = file.floats_of(&["state_dict", &weight], &shape)?;
    let bias = file.floats_of(&["state_dict", &bias], &shape[..1])?;
    Layer::new(shape[1], weight.values, bias.values)
}

fn mask(file: &mut Checkpoint) -> Result<Option<AlphaMask>, TorchError> {
    let names = ["alphaMask.shape", "alphaMask.mask", "alphaMask.aabb"];
    if !names.iter().any(|name| file.has(&[name])) {
        return Ok(None);
    }
    let [shape, bits, aabb] = names.map(|name| [name]);
    let sides = file.numbers(&shape)?;
    // The last three are z, y and x; others before them are 1.
    let split = sides.len().saturating_sub(3);
    let (ones, zyx) = sides.split_at(split);
    let &[z, y, x] = zyx else {
        return Err(file.field(&shape, format!("{sides:?}"), "[.., Z, Y, X]"));
    };
    if ones.iter().any(|v| *v != 1.0) {
        return Err(file.field(&shape, format!("{sides:?}"), "1 before Z, Y and X"));
    }
    let mut points = [0; 3];
    for (to, value) in points.iter_mut().zip([x, y, z]) {
        *to = whole(file, &shape, value, 1..=MAX_POINTS)?;
    }
    let count = points.iter().product::<usize>();
    if count > MAX_MASK {
        let expected = format!("at most {MAX_MASK} vertices");
        return Err(file.field(&shape, format!("{sides:?}"), &expected));
    }
    let bytes = file.tensor_of(&bits, &[count.div_ceil(8)])?.values;
    let filled = (0..count).map(|i| {
        // numpy.packbits: the first bit is the highest of its byte.
        (bytes[i / 8] as u8) >> (7 - i % 8) & 1 == 1
    });
    let filled = filled.collect();
    let [ax, ay, az, bx, by, bz] = list(file, &aabb)?;
    let bounds = [dvec3(ax, ay, az), dvec3(bx, by, bz)];
    let size = bounds[1] - bounds[0];
    if !(size.is_finite() && size.cmpgt(DVec3::splat(1e-6)).all()) {
        let found = format!("{} to {}", bounds[0], bounds[1]);
        return Err(file.field(&aabb, found, "two corners, the second above the first"));
    }
    Ok(Some(AlphaMask {
        points,
        bounds,
        filled,
    }))
}

impl Tensorf {
    /// Loads a `.th` checkpoint of the authors' code: `TensorVMSplit` with the shading mode
    /// `MLP_Fea`.
    ///
    /// # Errors
    /// The file is not such a checkpoint, a part is missing or inconsistent, or the variant is not
    /// supported.
    pub fn load(path: &Path) -> Result<Self, FieldError> {
        let mut file = Checkpoint::open(path)?;
        Self::read(&mut file).map_err(|e| e.of_file(path))
    }

    fn read(file: &mut Checkpoint) -> Result<Self, FieldError> {
        file.refuse(&TENSORF)?;
        let rules = rules(file)?;
        let points = wholes(file, "gridSize", 2..=MAX_POINTS)?;
        let density = wholes(file, "density_n_comp", 1..=MAX_COMPONENTS)?;
        let appearance = wholes(file, "appearance_n_comp", 1..=MAX_COMPONENTS)?;
        let features = file.number(&kwarg("app_dim"))?;
        let features = whole(file, &kwarg("app_dim"), features, 1..=MAX_FEATURES)?;

        let mut planes = vec![];
        let mut lines = vec![];
        for mode in 0..3 {
            let [a, b] = PLANES[mode].map(|axis| points[axis]);
            let along = points[LINES[mode]];
            let mut read = |kind: &str, [slow, fast]: [usize; 2]| -> Result<Table, FieldError> {
                let mut one = |of: &str, count| {
                    let name = format!("{of}_{kind}.{mode}");
                    file.floats_of(&["state_dict", &name], &[1, count, slow, fast])
                };
                let (d, c) = (
                    one("density", density[mode])?,
                    one("app", appearance[mode])?,
                );
                let channels = density[mode] + appearance[mode];
                let values = interleaved(&d.values, &c.values, slow * fast);
                let sides = if kind == "plane" {
                    [fast, slow]
                } else {
                    [slow, 1]
                };
                Table::new([sides[0], sides[1], 1], channels, values)
            };
            planes.push(read("plane", [b, a])?);
            lines.push(read("line", [along, 1])?);
        }
        planes.append(&mut lines);
        let Ok(tables) = <[Table; 6]>::try_from(planes) else {
            return Err(super::part("tables", "not six".to_owned(), "six"));
        };

        let products: usize = appearance.iter().sum();
        let keys = ["state_dict", "basis_mat.weight"];
        let basis = file.floats_of(&keys, &[features, products])?;
        let basis = Layer::new(products, basis.values, vec![0.0; features])?;

        let keys = kwarg("featureC");
        let width = file.number(&keys)?;
        let width = whole(file, &keys, width, 1..=1 << 12)?;
        let inputs = rules.inputs(features);
        let layers = vec![
            layer(file, "renderModule.mlp.0", [width, inputs])?,
            layer(file, "renderModule.mlp.2", [width, width])?,
            layer(file, "renderModule.mlp.4", [3, width])?,
        ];
        let mut field = Self::new(tables, density, basis, Mlp::new(layers)?, rules)?;
        field.mask = mask(file)?;
        file.finish(&TENSORF, &mut field.notes)?;
        // Rays end at the box, or where nothing is left.
        field.notes.list("the far end of kwargs/near_far");
        Ok(field)
    }
}
