//! A digest of a trace that is too long to be kept.

use potamoi_formats::units::VectorOp;
use potamoi_reference::{GatherTask, Product, UnitError, Units};

/// Units that digest the work and the results of other units: those of two frames are equal where
/// their traces are.
pub struct Digest<'u> {
    units: &'u mut dyn Units,
    state: blake3::Hasher,
}

impl<'u> Digest<'u> {
    /// Of what goes through `units`.
    pub fn new(units: &'u mut dyn Units) -> Self {
        Self {
            units,
            state: blake3::Hasher::new(),
        }
    }

    /// Of all so far, as 16 hexadecimal digits.
    #[must_use]
    pub fn finish(self) -> String {
        self.state.finalize().to_hex()[..16].to_owned()
    }

    fn number(&mut self, number: usize) {
        self.state.update(&(number as u64).to_le_bytes());
    }

    fn words(&mut self, words: impl Iterator<Item = i32>) {
        let bytes: Vec<u8> = words.flat_map(i32::to_le_bytes).collect();
        self.number(bytes.len());
        self.state.update(&bytes);
    }

    fn tasks(&mut self, tasks: &[GatherTask]) {
        self.number(tasks.len());
        for task in tasks {
            self.number(task.vertices.count());
            self.number(task.channels);
            self.words(task.rows.iter().map(|code| i32::from(*code)));
            for entry in &task.entries {
                self.state.update(&entry.slot.to_le_bytes());
                for (row, weight) in entry.rows.iter().zip(entry.weights) {
                    self.state.update(&row.to_le_bytes());
                    self.state.update(&weight.to_le_bytes());
                }
            }
        }
    }
}

impl Units for Digest<'_> {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        let begin = features.len();
        self.units.gather(tasks, features)?;
        self.tasks(tasks);
        self.words(features[begin..].iter().map(|code| i32::from(*code)));
        Ok(())
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        let begin = sums.len();
        self.units.sums(tasks, sums)?;
        self.tasks(tasks);
        self.words(sums[begin..].iter().copied());
        Ok(())
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        self.units.vector(op, a, b, out)?;
        self.state.update(&op.field().to_le_bytes());
        for words in [a, b, out] {
            self.words(words.iter().copied());
        }
        Ok(())
    }

    fn multiplied(&mut self, product: Product) {
        for size in [product.rows, product.depth, product.columns] {
            self.state.update(&size.to_le_bytes());
        }
        self.units.multiplied(product);
    }
}
