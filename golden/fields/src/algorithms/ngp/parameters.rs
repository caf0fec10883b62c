//! The consecutive parameters of a snapshot, as matrices and tables.

use half::f16;

use super::document::{Document, Network};
use super::grid::Level;
use super::wrong::{Wrong, check, finite, is};
use crate::{FieldError, HashUnit, Layer, Mlp, Table};

/// Widths of a fully fused network are rounded up to a multiple of this.
pub(super) const ALIGNMENT: usize = 16;
/// Maximum number of hidden layers.
const MAX_HIDDEN: usize = 8;

/// A network's matrices as stored, and the inputs of the first one.
pub(super) struct Widths {
    inputs: usize,
    /// Outputs and inputs.
    matrices: Vec<[usize; 2]>,
}

pub(super) fn widths(
    network: &Network,
    name: &str,
    inputs: usize,
    outputs: usize,
) -> Result<Widths, Wrong> {
    let field = |part: &str| format!("{name}.{part}");
    let fused = network.otype.eq_ignore_ascii_case("FullyFusedMLP");
    check(fused, &field("otype"), &network.otype, "FullyFusedMLP")?;
    for (part, found, wanted) in [
        ("activation", &network.activation, "ReLU"),
        ("output_activation", &network.output_activation, "None"),
    ] {
        let text = found.as_deref().unwrap_or_default();
        check(is(found, wanted), &field(part), text, wanted)?;
    }
    let neurons = network.n_neurons.unwrap_or(128) as usize;
    let known = [16, 32, 64, 128].contains(&neurons);
    check(known, &field("n_neurons"), neurons, "16, 32, 64 or 128")?;
    let hidden = network.n_hidden_layers.unwrap_or(5) as usize;
    let known = (1..=MAX_HIDDEN).contains(&hidden);
    check(known, &field("n_hidden_layers"), hidden, "1 to 8")?;
    let given = network.n_output_dims.unwrap_or(outputs as u32);
    let known = (1..=128).contains(&given) && given as usize <= outputs;
    let expected = format!("1 to {}", outputs.min(128));
    check(known, &field("n_output_dims"), given, expected)?;
    let mut matrices = vec![[neurons, inputs.next_multiple_of(ALIGNMENT)]];
    matrices.extend(vec![[neurons, neurons]; hidden - 1]);
    matrices.push([outputs.next_multiple_of(ALIGNMENT), neurons]);
    Ok(Widths { inputs, matrices })
}

pub(super) fn parameters(widths: &Widths) -> usize {
    widths
        .matrices
        .iter()
        .map(|[rows, columns]| rows * columns)
        .sum()
}

/// The parameters, in 16 or 32 bits, and the number read so far.
pub(super) struct Numbers<'a> {
    bytes: &'a [u8],
    half: bool,
}

impl<'a> Numbers<'a> {
    pub(super) fn new(document: &'a Document, expected: usize) -> Result<Self, Wrong> {
        let snapshot = &document.snapshot;
        let kind = snapshot.params_type.as_deref().unwrap_or("__half");
        let half = kind == "__half";
        let field = "snapshot.params_type";
        check(half || kind == "float", field, kind, "__half or float")?;
        let bytes = &snapshot.params_binary.0[..];
        let size = expected * if half { 2 } else { 4 };
        let found = format!("{} bytes", bytes.len());
        let wanted = format!("{size}: {expected} parameters of type {kind}");
        check(bytes.len() == size, "snapshot.params_binary", found, wanted)?;
        if let Some(count) = snapshot.n_params {
            let field = "snapshot.n_params";
            check(count == expected as u64, field, count, expected.to_string())?;
        }
        let all = Self { bytes, half };
        finite(&Self { ..all }.take(expected), "snapshot.params_binary")?;
        Ok(all)
    }

    /// The next `count` numbers, which must exist: the sum has been checked.
    pub(super) fn take(&mut self, count: usize) -> Vec<f32> {
        let width = if self.half { 2 } else { 4 };
        let (own, rest) = self.bytes.split_at(count * width);
        self.bytes = rest;
        if self.half {
            halves(own).collect()
        } else {
            let (words, _) = own.as_chunks::<4>();
            words.iter().map(|b| f32::from_le_bytes(*b)).collect()
        }
    }
}

pub(super) fn halves(bytes: &[u8]) -> impl Iterator<Item = f32> + '_ {
    let (words, _) = bytes.as_chunks::<2>();
    words.iter().map(|b| f16::from_le_bytes(*b).to_f32())
}

/// Layers without bias; only the first `outputs` of the last layer.
pub(super) fn perceptron(
    widths: &Widths,
    outputs: usize,
    numbers: &mut Numbers<'_>,
) -> Result<Mlp, FieldError> {
    let last = widths.matrices.len() - 1;
    let layers = widths
        .matrices
        .iter()
        .enumerate()
        .map(|(i, [rows, columns])| {
            let weights = numbers.take(rows * columns);
            let kept = if i == last { outputs } else { *rows };
            let inputs = if i == 0 { widths.inputs } else { *columns };
            let rows = weights.chunks_exact(*columns).take(kept);
            let weights = rows.flat_map(|row| &row[..inputs]).copied().collect();
            Layer::new(inputs, weights, vec![0.0; kept])
        });
    Mlp::new(layers.collect::<Result<_, _>>()?)
}

/// A level's table. The reference numbers the vertices of a dense level modulo its entries and
/// reads one vertex past the last along an axis. A table with one more vertex, filled by that
/// rule, returns the same values.
pub(crate) fn table(
    level: &Level,
    unit: HashUnit,
    features: usize,
    values: Vec<f32>,
) -> Result<Table, FieldError> {
    let resolution = level.resolution as usize;
    let side = resolution + 1;
    if level.is_hashed() {
        return Table::hashed_by(unit, [side; 3], level.entries, features, values);
    }
    let mut all = Vec::with_capacity(side.pow(3) * features);
    for z in 0..side {
        for y in 0..side {
            for x in 0..side {
                let entry = (x + resolution * (y + resolution * z)) % level.entries;
                all.extend_from_slice(&values[entry * features..][..features]);
            }
        }
    }
    Table::new([side; 3], features, all)
}
