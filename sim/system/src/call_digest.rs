//! Digest of a trace that is too long to keep.

use potamoi_reference::observer::{GatherCall, Observer, SplatCall, VectorCall};
use potamoi_reference::{GatherTask, Product, UnitError};

/// Digests all calls of the units with their results. Two frames have the same digest where their
/// traces are equal.
#[derive(Default)]
pub struct CallDigest {
    state: blake3::Hasher,
}

impl CallDigest {
    /// Digest of all calls so far, as 16 hexadecimal digits.
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

impl Observer for CallDigest {
    fn gathered(&mut self, call: &GatherCall<'_>) -> Result<(), UnitError> {
        self.tasks(call.tasks);
        match (call.codes, call.sums) {
            (Some(codes), _) => self.words(codes.iter().map(|code| i32::from(*code))),
            (None, sums) => self.words(sums.unwrap_or_default().iter().copied()),
        }
        Ok(())
    }

    fn computed(&mut self, call: &VectorCall<'_>) -> Result<(), UnitError> {
        self.state.update(&call.op.field().to_le_bytes());
        for words in [call.a, call.b, call.out] {
            self.words(words.iter().copied());
        }
        Ok(())
    }

    fn composited(&mut self, call: &SplatCall<'_>) -> Result<(), UnitError> {
        let settings = &call.job.settings;
        let thresholds = &settings.thresholds;
        for number in [
            u64::from(thresholds.alpha_cap),
            thresholds.alpha_min.into(),
            thresholds.stop,
            thresholds.spare.into(),
            settings.is_centred.into(),
            call.job.tiles as u64,
        ] {
            self.state.update(&number.to_le_bytes());
        }
        self.number(call.job.entries.len());
        for entry in call.job.entries {
            self.state.update(&entry.slot.to_le_bytes());
            for at in entry.tile {
                self.state.update(&at.to_le_bytes());
            }
            self.state.update(&entry.last);
            for channel in entry.record.to_channels() {
                self.state.update(&channel.to_le_bytes());
            }
        }
        self.number(call.done.pixels.len());
        for pixel in &call.done.pixels {
            self.state.update(&pixel.transmittance.to_le_bytes());
            for sum in pixel.colour {
                self.state.update(&sum.to_le_bytes());
            }
        }
        Ok(())
    }

    fn multiplied(&mut self, product: &Product) {
        for size in [product.rows, product.depth, product.columns] {
            self.state.update(&size.to_le_bytes());
        }
    }
}
