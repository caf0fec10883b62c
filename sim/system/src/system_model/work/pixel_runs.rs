//! The pixels of a picture that are rendered, as lengths of runs.

use potamoi_base::mask::Mask;
use serde::{Deserialize, Serialize};

/// Pixels of a mask: lengths of runs, of pixels that are not in it and that are, by turns. Empty
/// where no pixel is.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PixelRuns(Vec<u32>);

impl PixelRuns {
    pub(super) fn of(mask: &Mask, pixels: usize) -> Self {
        let (mut runs, mut is_in, mut length) = (vec![], false, 0);
        for pixel in 0..pixels {
            if mask.has(pixel) != is_in {
                runs.push(length);
                (is_in, length) = (!is_in, 0);
            }
            length += 1;
        }
        runs.push(length);
        Self(runs)
    }

    /// The mask of a picture of this size.
    pub(super) fn mask(&self, size: [u32; 2]) -> Mask {
        let mut has = vec![];
        for (turn, length) in self.0.iter().enumerate() {
            has.extend(std::iter::repeat_n(turn % 2 == 1, *length as usize));
        }
        Mask::new(size, |pixel| has.get(pixel).copied().unwrap_or(false))
    }

    /// The mask of a picture of this size, if any pixel is in it.
    pub(super) fn rendered(&self, size: [u32; 2]) -> Option<Mask> {
        (!self.0.is_empty()).then(|| self.mask(size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn runs_are_their_mask(pixels in prop::collection::vec(any::<bool>(), 12)) {
            let mask = Mask::new([4, 3], |i| pixels[i]);
            let again = PixelRuns::of(&mask, 12).mask([4, 3]);
            prop_assert!((0..12).all(|i| again.has(i) == pixels[i]));
        }
    }
}
