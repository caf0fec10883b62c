//! The feature record of a projected Gaussian: 16 channels of 16 bits, so
//! that one record fills one row of the MVoxel feature table.
//!
//! | channels | what | format |
//! |---|---|---|
//! | 0-1, 2-3 | mean x, y in pixels | S19.12 |
//! | 4-5, 6-7, 8-9 | Cholesky factors L11, L21, L22 of the conic | S1.30 |
//! | 10 | opacity, U0.16; or its negated natural logarithm, U3.13, with `su.opacity = "in-power"` | |
//! | 11-13 | red, green, blue | U4.12 |
//! | 14-15 | sort rank | 32-bit integer |
//!
//! Two-channel values are little-endian: the lower channel holds the low half.
//! The 0.3-pixel dilation bounds the factors by 1.826, so S1.30 never saturates
//! on them.

use serde::Serialize;

use crate::fixed::Format;

/// Channels of a record.
pub const RECORD_CHANNELS: usize = 16;
/// Format of the means, in pixels.
pub const MEAN: Format = Format::signed(19, 12);
/// Format of the Cholesky factors of the conic.
pub const FACTOR: Format = Format::signed(1, 30);
/// Format of the opacity, of exponentials and of alpha.
pub const OPACITY: Format = Format::unsigned(0, 16);
/// Format of the negated natural logarithm of an opacity. Opacities below exp(-8) have its largest code.
pub const LOG_OPACITY: Format = Format::unsigned(3, 13);
/// Format of a colour channel.
pub const COLOUR: Format = Format::unsigned(4, 12);

/// Codes of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct SplatRecord {
    /// Mean x, y, [`MEAN`] codes.
    pub mean: [i32; 2],
    /// L11, L21, L22, [`FACTOR`] codes.
    pub factor: [i32; 3],
    /// [`OPACITY`] code, or [`LOG_OPACITY`] code.
    pub opacity: u16,
    /// Red, green, blue, [`COLOUR`] codes.
    pub colour: [u16; 3],
    /// Rank in the frame's depth order, 0 in front.
    pub rank: u32,
}

impl SplatRecord {
    /// Packs the record into a row of the MFT.
    #[must_use]
    pub fn to_channels(self) -> [i16; RECORD_CHANNELS] {
        let mut row = [0i16; RECORD_CHANNELS];
        let words = [
            self.mean[0] as u32,
            self.mean[1] as u32,
            self.factor[0] as u32,
            self.factor[1] as u32,
            self.factor[2] as u32,
        ];
        for (i, word) in words.into_iter().enumerate() {
            row[2 * i] = word as i16;
            row[2 * i + 1] = (word >> 16) as i16;
        }
        row[10] = self.opacity as i16;
        for (i, c) in self.colour.into_iter().enumerate() {
            row[11 + i] = c as i16;
        }
        row[14] = self.rank as i16;
        row[15] = (self.rank >> 16) as i16;
        row
    }

    /// Unpacks a row.
    #[must_use]
    pub fn from_channels(row: &[i16; RECORD_CHANNELS]) -> Self {
        let half = |i: usize| u32::from(row[i] as u16);
        let word = |i: usize| half(i) | half(i + 1) << 16;
        Self {
            mean: [word(0) as i32, word(2) as i32],
            factor: [word(4) as i32, word(6) as i32, word(8) as i32],
            opacity: row[10] as u16,
            colour: [row[11] as u16, row[12] as u16, row[13] as u16],
            rank: word(14),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn records_read_back(
            mean in any::<[i32; 2]>(), factor in any::<[i32; 3]>(), opacity in any::<u16>(),
            colour in any::<[u16; 3]>(), rank in any::<u32>()
        ) {
            let record = SplatRecord { mean, factor, opacity, colour, rank };
            prop_assert_eq!(SplatRecord::from_channels(&record.to_channels()), record);
        }
    }

    #[test]
    fn the_dilation_bounds_the_factors() {
        // The conic's largest eigenvalue is 1 / 0.3, its square root 1.826 < 2.
        assert!((1.0f64 / 0.3).sqrt() < FACTOR.value(FACTOR.max()));
    }
}
