//! Residual vector quantisation: a value is the sum of one codebook entry from every stage.
//! Indices are packed without gaps, Gaussian by Gaussian, stage by stage.

use std::path::Path;

use rayon::prelude::*;

use super::npz::Array;
use potamoi_containers::torch::Checkpoint;
use potamoi_gaussians::files::{FileError, Origin};

/// Maximum number of stages.
const MAX_STAGES: i64 = 32;

/// The stages of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stages {
    /// Number of codes in a value.
    pub(super) count: usize,
    /// Bits of a code, 1 to 8.
    pub(super) bits: usize,
}

impl Stages {
    /// Reads both numbers from an array.
    pub(super) fn read(info: &Array<'_>) -> Result<Self, FileError> {
        let expected = format!("two: 1 to {MAX_STAGES} stages and 1 to 8 bits of a code");
        match info.integers()?[..] {
            [count @ 1..=MAX_STAGES, bits @ 1..=8] if info.shape.len() == 1 => Ok(Self {
                count: count as usize,
                bits: bits as usize,
            }),
            ref other => {
                let shown = &other[..other.len().min(8)];
                Err(info.wrong("content", format!("{shown:?}"), expected))
            }
        }
    }

    fn codes(self) -> usize {
        1 << self.bits
    }

    /// The entries of all stages, `D` numbers each: an array of them, stage by stage, or the
    /// `state_dict` of a `ResidualVQ` (vector-quantize-pytorch).
    pub(super) fn codebooks<const D: usize>(
        self,
        array: &Array<'_>,
        name: Origin<'_>,
    ) -> Result<Vec<[f32; D]>, FileError> {
        let (count, codes) = (self.count, self.codes());
        let values = if array.is_object() {
            let dict = Checkpoint::of_object_array(Path::new(name.0), array.pickle());
            let read = dict.and_then(|mut dict| {
                let mut all = vec![];
                for stage in 0..count {
                    let key = format!("layers.{stage}._codebook.embed");
                    all.extend(dict.tensor_of(&[&key], &[1, codes, D])?.values);
                }
                Ok(all)
            });
            read.map_err(|e| array.refused(e))?
        } else {
            let right = array.shape == [count, codes, D];
            array.shaped(right, &format!("({count}, {codes}, {D})"))?;
            array.floats()?
        };
        if let Some(at) = values.iter().position(|v| !v.is_finite()) {
            let what = format!("number {at}");
            return Err(array.wrong(&what, values[at], "a finite number"));
        }
        Ok(values.as_chunks().0.to_vec())
    }

    /// Decodes the values of `count` Gaussians.
    pub(super) fn decode<const D: usize>(
        self,
        gaussians: usize,
        indices: &Array<'_>,
        codebooks: &[[f32; D]],
    ) -> Result<Vec<[f64; D]>, FileError> {
        let bytes = indices.bytes()?;
        let wanted = (gaussians as u128 * (self.count * self.bits) as u128).div_ceil(8);
        let right = indices.shape.len() == 1 && bytes.len() as u128 == wanted;
        let expected = format!(
            "({wanted},): {gaussians} Gaussians, {} codes of {} bits",
            self.count, self.bits
        );
        indices.shaped(right, &expected)?;
        let value = |gaussian: usize| {
            let mut sum = [0.0; D];
            for stage in 0..self.count {
                let code = self.code(bytes, gaussian * self.count + stage);
                let entry = codebooks[stage * self.codes() + code];
                for (sum, part) in sum.iter_mut().zip(entry) {
                    *sum += f64::from(part);
                }
            }
            sum
        };
        let all = (0..gaussians).into_par_iter().with_min_len(1 << 12);
        Ok(all.map(value).collect())
    }

    /// A code. Its bits start at the lowest; those of a byte start at the highest.
    fn code(self, bytes: &[u8], index: usize) -> usize {
        (0..self.bits).fold(0, |code, bit| {
            let at = index * self.bits + bit;
            code | usize::from(bytes[at / 8] >> (7 - at % 8) & 1) << bit
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Codes 0b000001 and 0b110100, as NumPy packs them: 100000 001011.
    #[test]
    fn codes_come_back_from_their_bits() {
        let stages = Stages { count: 2, bits: 6 };
        let bytes = [0b1000_0000, 0b1011_0000];
        assert_eq!(stages.code(&bytes, 0), 0b00_0001);
        assert_eq!(stages.code(&bytes, 1), 0b11_0100);
        let bytes: Vec<u8> = (0..=255).collect();
        let whole = Stages { count: 1, bits: 8 };
        for at in 0..=255u8 {
            let expected = usize::from(at.reverse_bits());
            assert_eq!(whole.code(&bytes, at.into()), expected);
        }
    }
}
