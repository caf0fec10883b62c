//! Work of one step of a frame: counted as events, and priced with a vector unit and an array.

use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;
use potamoi_reference::Product;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::mac_array::MacArray;
use super::{ClosedVector, WorkError};

/// Bytes of a feature code or an activation.
const CODE: u64 = 2;
/// Bytes of an operand or a result of the vector unit.
const OPERAND: u64 = 4;

/// One step of a frame's pipeline: a gathering and the computation on its results. A batch begins
/// with the first gather after a vector operation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Batch {
    /// Runs of the gathering unit, each from reset.
    pub runs: u64,
    /// Tasks, one for each MVoxel.
    pub mvoxels: u64,
    /// RIT entries.
    pub entries: u64,
    /// Cycles of the gathering unit with streams always ready.
    pub gather_cycles: u64,
    /// Busy cycles of the gathering unit, in which it issues.
    pub gather_busy: u64,
    /// Codes read from the MFT: entries times vertices times channels.
    pub codes_read: u64,
    /// Bytes of rows loaded into the MFT.
    pub row_bytes: u64,
    /// Bytes of RIT entries, each counted once.
    pub rit_bytes: u64,
    /// Bytes of RIT entries read by the gathering unit. Entries that exceed both halves of its
    /// buffer are read again for each further segment.
    pub rit_read_bytes: u64,
    /// Bytes of gathered features.
    pub feature_bytes: u64,
    /// Vector operations.
    pub operations: u64,
    /// Elements of vector operations.
    pub elements: u64,
    /// Cycles of the vector unit with streams always ready, each operation from reset.
    pub vector_cycles: u64,
    /// Busy cycles of the vector unit.
    pub vector_busy: u64,
    /// Bytes of operands; the unit keeps none between operations.
    pub operand_bytes: u64,
    /// Bytes of results.
    pub result_bytes: u64,
    /// Matrix products.
    pub products: u64,
    /// Multiply-accumulates of the products.
    pub macs: u64,
    /// Cycles of the MAC array.
    pub array_cycles: u64,
    /// Bytes of the products' inputs, read once for each fold of columns.
    pub input_bytes: u64,
    /// Bytes of weights, counted at each load.
    pub weight_bytes: u64,
    /// Bytes of outputs of products.
    pub output_bytes: u64,
    /// Bytes of partial sums written and read again.
    pub partial_bytes: u64,
    /// Jobs of splat units, one a ray group.
    #[serde(default)]
    pub splat_jobs: u64,
    /// Cycles of all jobs, whichever unit did them, with streams always ready.
    #[serde(default)]
    pub splat_cycles: u64,
    /// Cycles until all jobs are done on the units side by side.
    #[serde(default)]
    pub splat_elapsed: u64,
    /// Records in tiles that splat units took.
    #[serde(default)]
    pub splat_records: u64,
    /// Pairs of pixel and record that splat units evaluated.
    #[serde(default)]
    pub splat_square_sums: u64,
    /// Pairs that drew or ended a pixel in splat units.
    #[serde(default)]
    pub splat_counted: u64,
    /// Pixels that splat units returned, those beyond the picture included.
    #[serde(default)]
    pub splat_pixels: u64,
}

impl Batch {
    /// All counts.
    fn counts(&mut self) -> [&mut u64; 30] {
        [
            &mut self.runs,
            &mut self.mvoxels,
            &mut self.entries,
            &mut self.gather_cycles,
            &mut self.gather_busy,
            &mut self.codes_read,
            &mut self.row_bytes,
            &mut self.rit_bytes,
            &mut self.rit_read_bytes,
            &mut self.feature_bytes,
            &mut self.operations,
            &mut self.elements,
            &mut self.vector_cycles,
            &mut self.vector_busy,
            &mut self.operand_bytes,
            &mut self.result_bytes,
            &mut self.products,
            &mut self.macs,
            &mut self.array_cycles,
            &mut self.input_bytes,
            &mut self.weight_bytes,
            &mut self.output_bytes,
            &mut self.partial_bytes,
            &mut self.splat_jobs,
            &mut self.splat_cycles,
            &mut self.splat_elapsed,
            &mut self.splat_records,
            &mut self.splat_square_sums,
            &mut self.splat_counted,
            &mut self.splat_pixels,
        ]
    }

    /// Splits into equal parts, up to one of each count; the parts sum to the whole.
    pub fn parts(mut self, number: u64) -> impl Iterator<Item = Self> {
        let whole = self.counts().map(|count| *count);
        (0..number).map(move |i| {
            let mut part = Self::default();
            for (own, whole) in part.counts().into_iter().zip(whole) {
                let upto = |i: u64| (u128::from(whole) * u128::from(i) / u128::from(number)) as u64;
                *own = upto(i + 1) - upto(i);
            }
            part
        })
    }
}

impl std::ops::AddAssign for Batch {
    fn add_assign(&mut self, mut other: Self) {
        for (sum, own) in self.counts().into_iter().zip(other.counts()) {
            *sum += *own;
        }
    }
}

/// What the units do in a step, without what depends on the vector unit's lanes and pipeline or on
/// the array. [`BatchEvents::priced`] adds that.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BatchEvents {
    /// Counts of the gathering unit and of splat units; those of vector unit and array are 0.
    pub gathered: Batch,
    /// Vector operations, equal ones once.
    pub operations: Vec<Operations>,
    /// Matrix products, equal ones once: rows, depth and columns, and their number.
    pub products: Vec<([u64; 3], u64)>,
}

/// Equal vector operations.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Operations {
    /// The operation.
    pub code: OpCode,
    /// Elements of each.
    pub elements: u64,
    /// Number of operations.
    pub count: u64,
    /// Cycles and busy cycles of each, where they depend on operands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycles: Option<[u64; 2]>,
}

/// Vector unit and array that events are priced with.
#[derive(Debug, Clone)]
pub struct Pricing {
    vector: ClosedVector,
    array: MacArray,
}

impl Pricing {
    /// The units of a configuration beside an array.
    ///
    /// # Errors
    /// A configuration that breaks its rules.
    pub fn new(config: &Config, array: MacArray) -> Result<Self, WorkError> {
        Ok(Self {
            vector: ClosedVector::new(config)?,
            array,
        })
    }

    fn operations(&self, own: &Operations) -> Batch {
        let [elapsed, busy] = own.cycles.unwrap_or_else(|| {
            let cycles = self.vector.cycles_of_any(own.code, own.elements);
            [cycles.elapsed, cycles.busy]
        });
        let elements = own.count * own.elements;
        Batch {
            operations: own.count,
            elements,
            vector_cycles: own.count * elapsed,
            vector_busy: own.count * busy,
            operand_bytes: OPERAND * elements * (1 + u64::from(own.code.takes_both())),
            result_bytes: OPERAND * elements,
            ..Batch::default()
        }
    }

    fn products(&self, [rows, depth, columns]: [u64; 3], count: u64) -> Batch {
        let product = Product {
            rows,
            depth,
            columns,
        };
        let (folds, _) = self.array.folds(&product);
        let across = columns.div_ceil(self.array.columns);
        Batch {
            products: count,
            macs: count * product.operations(),
            array_cycles: count * self.array.cycles(&product),
            input_bytes: count * rows * depth * across * CODE,
            weight_bytes: count * folds * self.array.units() * CODE,
            output_bytes: count * rows * columns * CODE,
            partial_bytes: count * self.array.partial_bytes(&product),
            ..Batch::default()
        }
    }
}

impl BatchEvents {
    /// The counts of a step with these units.
    #[must_use]
    pub fn priced(&self, with: &Pricing) -> Batch {
        let mut sum = self.gathered;
        for own in &self.operations {
            sum += with.operations(own);
        }
        for (product, count) in &self.products {
            sum += with.products(*product, *count);
        }
        sum
    }

    pub(super) fn computed(&mut self, code: OpCode, elements: u64, cycles: Option<[u64; 2]>) {
        let alike = |own: &&mut Operations| {
            (own.code, own.elements, own.cycles) == (code, elements, cycles)
        };
        match self.operations.iter_mut().rev().find(alike) {
            Some(own) => own.count += 1,
            None => self.operations.push(Operations {
                code,
                elements,
                count: 1,
                cycles,
            }),
        }
    }

    pub(super) fn multiplied(&mut self, product: [u64; 3]) {
        match self.products.iter_mut().find(|(own, _)| *own == product) {
            Some((_, count)) => *count += 1,
            None => self.products.push((product, 1)),
        }
    }

    pub(super) fn is_some(&self) -> bool {
        self.gathered.runs > 0
            || self.gathered.splat_jobs > 0
            || !self.operations.is_empty()
            || !self.products.is_empty()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Without early termination the cycles of an operation follow from its length.
        #[test]
        fn lengths_alone_decide_cycles(
            elements in 0usize..400,
            lanes in 1u32..40,
            pipelined in any::<bool>(),
            code in prop::sample::select(&[OpCode::Add, OpCode::Exp, OpCode::Multiply][..]),
        ) {
            let text = format!("[vu]\nlanes = {lanes}\n[vu.exp]\npipelined = {pipelined}\n");
            let vector = ClosedVector::new(&Config::from_toml(&text, "test").unwrap()).unwrap();
            let values: Vec<i32> = (0..elements as i32).map(|i| i * 977).collect();
            let any = vector.cycles_of_any(code, elements as u64);
            prop_assert_eq!(vector.cycles(&[(code, &values)]), any);
        }
    }
}
