//! Perceptrons shared by models of all analytic scenes: from the coefficients of a colour that is
//! linear in the direction, 0 to 1, to that colour. `tools/fit shade` fits them.

use std::io::{Cursor, Read as _};

use ndarray::{Array1, Array2};
use ndarray_npy::ReadNpyExt as _;
use zip::ZipArchive;

use potamoi_fields::{FieldError, Layer, Mlp};

/// Arrays `dvgo.0.weight`, `dvgo.0.bias` and so on, with three layers each.
const FITTED: &[u8] = include_bytes!("../../../models/shade.npz");
/// The largest array, in bytes.
const LIMIT: u64 = 1 << 20;

/// The perceptron of a representation, `dvgo` or `tensorf`.
pub(super) fn perceptron(name: &str) -> Result<Mlp, FieldError> {
    let mut archive = ZipArchive::new(Cursor::new(FITTED)).map_err(wrong)?;
    let mut bytes = |name: String| -> Result<Vec<u8>, FieldError> {
        let file = archive.by_name(&name).map_err(wrong)?;
        let mut bytes = vec![];
        file.take(LIMIT).read_to_end(&mut bytes).map_err(wrong)?;
        Ok(bytes)
    };
    let layers = (0..3).map(|i| {
        let weights = bytes(format!("{name}.{i}.weight.npy"))?;
        let weights = Array2::<f32>::read_npy(&weights[..]).map_err(wrong)?;
        let bias = bytes(format!("{name}.{i}.bias.npy"))?;
        let bias = Array1::<f32>::read_npy(&bias[..]).map_err(wrong)?;
        let inputs = weights.ncols();
        Layer::new(inputs, weights.iter().copied().collect(), bias.to_vec())
    });
    Mlp::new(layers.collect::<Result<_, _>>()?)
}

fn wrong(error: impl ToString) -> FieldError {
    FieldError::Part {
        part: "golden/models/shade.npz",
        found: error.to_string(),
        expected: "what tools/fit shade writes".to_owned(),
    }
}
