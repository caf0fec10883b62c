//! The numbers of tensors and arrays, in members or within the pickle.

use half::{bf16, f16};

use potamoi_base::file_keys::told;

use super::members::{length, member};
use super::value::{Kind, StorageLocation, Value};
use super::{Checkpoint, Tensor, TorchError};

/// Maximum number of elements in a tensor.
const MAX_NUMBERS: usize = 1 << 30;

impl Checkpoint {
    /// As [`Checkpoint::tensor`], for floating-point tensors. Grids and weights stored as integers
    /// were packed in some way, and their codes are not densities.
    ///
    /// # Errors
    /// Those of [`Checkpoint::tensor`], or a tensor of integers or truth values.
    pub fn floats(&mut self, keys: &[&str]) -> Result<Tensor, TorchError> {
        self.are_floats(keys)?;
        self.tensor(keys)
    }

    /// As [`Checkpoint::floats`], for a tensor that must have this shape.
    ///
    /// # Errors
    /// Those of [`Checkpoint::floats`], or the shape differs.
    pub fn floats_of(&mut self, keys: &[&str], shape: &[usize]) -> Result<Tensor, TorchError> {
        self.are_floats(keys)?;
        self.tensor_of(keys, shape)
    }

    fn are_floats(&self, keys: &[&str]) -> Result<(), TorchError> {
        let kind = match self.find(keys) {
            Some(Value::Tensor(at)) => {
                Some(self.arena.storages[self.arena.tensors[at].storage].kind)
            }
            Some(Value::Array(at)) => self.arena.arrays[at].kind,
            _ => None,
        };
        if let Some(kind) = kind.filter(|kind| !kind.is_float()) {
            let expected = "floating-point numbers: save it as it was trained, not packed into \
                            integers";
            return Err(self.field(keys, format!("of type {}", kind.name()), expected));
        }
        Ok(())
    }

    pub(super) fn view(&mut self, keys: &[&str], at: usize) -> Result<Tensor, TorchError> {
        let view = self.arena.tensors[at].clone();
        let storage = self.arena.storages[view.storage].clone();
        let count = self.count(keys, &view.shape)?;
        // The last number that is reached.
        let reach = view
            .shape
            .iter()
            .zip(&view.strides)
            .try_fold(view.offset, |sum, (length, stride)| {
                sum.checked_add(length.saturating_sub(1).checked_mul(*stride)?)
            });
        let fits = count == 0 || reach.is_some_and(|reach| reach < storage.count);
        // A view that repeats its numbers could be of any size.
        if !fits || storage.count > MAX_NUMBERS || count > storage.count {
            let found = format!(
                "a view of {} stored numbers that leaves them",
                storage.count
            );
            return Err(self.field(keys, found, "a view within its numbers"));
        }
        let owned;
        let bytes = match storage.place {
            StorageLocation::Within(blob, from) => &self.arena.bytes[blob][from..],
            StorageLocation::Member(key) => {
                owned = self.beside(keys, key, storage.count * storage.kind.bytes())?;
                &owned
            }
        };
        let mut values = Vec::with_capacity(count);
        let mut index = vec![0usize; view.shape.len()];
        for _ in 0..count {
            let steps = index.iter().zip(&view.strides).map(|(i, s)| i * s);
            let at = view.offset + steps.sum::<usize>();
            values.push(number(storage.kind, bytes, at));
            for axis in (0..index.len()).rev() {
                index[axis] += 1;
                if index[axis] < view.shape[axis] {
                    break;
                }
                index[axis] = 0;
            }
        }
        let shape = view.shape;
        Ok(Tensor { shape, values })
    }

    /// The bytes of a storage in a member, at most `most`.
    fn beside(&mut self, keys: &[&str], key: usize, most: usize) -> Result<Vec<u8>, TorchError> {
        let name = format!("{}data/{}", self.prefix, self.arena.texts[key]);
        let read = match &mut self.archive {
            Some(archive) => member(archive, &name, most as u64),
            None => Err(format!("it has no member {name}")),
        };
        let bytes = read.map_err(|problem| TorchError::Container {
            path: self.path.clone(),
            problem,
        })?;
        let all = self.archive.as_mut().map_or(0, |own| length(own, &name));
        if let Some(left @ 1..) = all.checked_sub(most as u64) {
            let key = format!("bytes after the numbers of {} ({left})", told(&name));
            if !self.beside.contains(&key) {
                self.beside.push(key);
            }
        }
        if bytes.len() < most {
            let found = format!("{} bytes in {name}", bytes.len());
            return Err(self.field(keys, found, &format!("{most} bytes")));
        }
        Ok(bytes)
    }

    pub(super) fn array(&self, keys: &[&str], at: usize) -> Result<Tensor, TorchError> {
        let array = &self.arena.arrays[at];
        let count = self.count(keys, &array.shape)?;
        let bytes = array.bytes.map(|b| &self.arena.bytes[b]);
        let (Some(kind), Some(bytes)) = (array.kind, bytes) else {
            let found = "an array of objects".to_owned();
            return Err(self.field(keys, found, "an array of numbers"));
        };
        if bytes.len() < count * kind.bytes() {
            let found = format!("{count} numbers in {} bytes", bytes.len());
            return Err(self.field(keys, found, "all of its numbers"));
        }
        Ok(Tensor {
            shape: array.shape.clone(),
            values: (0..count).map(|at| number(kind, bytes, at)).collect(),
        })
    }

    fn count(&self, keys: &[&str], shape: &[usize]) -> Result<usize, TorchError> {
        let count = shape
            .iter()
            .try_fold(1usize, |n, side| n.checked_mul(*side));
        count.filter(|n| *n <= MAX_NUMBERS).ok_or_else(|| {
            let expected = format!("at most {MAX_NUMBERS} numbers");
            self.field(keys, format!("of shape {shape:?}"), &expected)
        })
    }
}

/// Number `at` of little-endian numbers, which must exist.
fn number(kind: Kind, bytes: &[u8], at: usize) -> f32 {
    let own = &bytes[at * kind.bytes()..][..kind.bytes()];
    let mut wide = [0; 8];
    wide[..own.len()].copy_from_slice(own);
    let word = u64::from_le_bytes(wide);
    match kind {
        Kind::F16 => f16::from_bits(word as u16).to_f32(),
        Kind::BF16 => bf16::from_bits(word as u16).to_f32(),
        Kind::F32 => f32::from_bits(word as u32),
        Kind::F64 => f64::from_bits(word) as f32,
        Kind::I16 => f32::from(word as u16 as i16),
        Kind::I32 => word as u32 as i32 as f32,
        Kind::I64 => word as i64 as f32,
        Kind::U8 => f32::from(word as u8),
        Kind::Bool => f32::from(u8::from(word != 0)),
    }
}
