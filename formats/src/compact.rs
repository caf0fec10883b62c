//! The compact RIT entry: one cell instead of its eight vertices.
//!
//! The paper's entry names eight rows and eight weights, 48 bytes, of which the
//! unit can make all but 8: the rows lie at fixed distances from the first
//! ([`offsets`](crate::config::MvoxelConfig::offsets)), and the weights are the
//! split tree of three fractions. A word of 64 bits, little-endian:
//!
//! | bits | what |
//! |---|---|
//! | 8..0 | row of the cell's first vertex |
//! | 21..9, 34..22, 47..35 | fractions along x, y, z, U1.12 of at most 1 |
//! | 63..48 | slot |

/// Width of the row of the first vertex, in bits.
pub const ROW_BITS: u32 = 9;
/// Width of a fraction in bits, U1.12.
pub const FRACTION_BITS: u32 = 13;
/// Lowest bits of the fractions along x, y and z.
pub const FRACTION_AT: [u32; 3] = [9, 22, 35];
/// Lowest bit of the slot.
pub const SLOT_AT: u32 = 48;
/// The largest fraction, 1.
#[cfg(test)]
pub(crate) const FRACTION_ONE: u16 = 1 << 12;

/// A sample in a cell of an MVoxel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CompactEntry {
    /// Slot of the sample's features.
    pub slot: u16,
    /// Row of the cell's first vertex, below 512.
    pub row: u16,
    /// U1.12 fractions along x, y and z, at most 1; 0 along axes that the entry
    /// lacks.
    pub fraction: [u16; 3],
}

impl CompactEntry {
    /// Packs the entry into a word. Rows from 512 and fractions above 1 lose their high bits.
    #[must_use]
    pub fn word(&self) -> u64 {
        let field = |value: u16, bits: u32, at: u32| (u64::from(value) & ((1 << bits) - 1)) << at;
        let mut word = field(self.row, ROW_BITS, 0) | field(self.slot, 16, SLOT_AT);
        for (fraction, at) in self.fraction.into_iter().zip(FRACTION_AT) {
            word |= field(fraction, FRACTION_BITS, at);
        }
        word
    }

    /// Unpacks a word.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn of_word(word: u64) -> Self {
        let field = |bits: u32, at: u32| (word >> at & ((1 << bits) - 1)) as u16;
        Self {
            slot: field(16, SLOT_AT),
            row: field(ROW_BITS, 0),
            fraction: FRACTION_AT.map(|at| field(FRACTION_BITS, at)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Every bit of a word belongs to one field.
        #[test]
        fn words_read_back(word in any::<u64>()) {
            prop_assert_eq!(CompactEntry::of_word(word).word(), word);
        }
    }

    #[test]
    fn fields_lie_where_the_table_says() {
        let entry = CompactEntry {
            slot: 0xbeef,
            row: 0x1a5,
            fraction: [1, FRACTION_ONE, 0xabc],
        };
        let parts = [0x1a5, 1 << 9, 4096 << 22, 0xabc << 35, 0xbeef << 48];
        assert_eq!(entry.word(), parts.iter().sum::<u64>());
    }
}
