//! Geometry of the feature-major unit.

use potamoi_formats::config::Config;

use crate::circuits::bits_for;

/// Sizes shared by its modules. The number of banks is a power of two: a row's low bits are its
/// bank, and the others its line there.
pub(super) struct Shape {
    pub(super) banks: u32,
    pub(super) lanes: u32,
    /// Width in bits of a bank's index, and of a channel's.
    pub(super) bank_bits: u32,
    /// Width in bits of a line, the position of a row in its bank.
    pub(super) line_bits: u32,
    /// Rows of an MVoxel.
    pub(super) rows: u32,
}

impl Shape {
    pub(super) fn of(config: &Config) -> Self {
        let (banks, rows) = (config.gu.banks, config.mvoxel.rows);
        let bank_bits = bits_for(banks - 1);
        Self {
            banks,
            lanes: config.gu.lanes,
            bank_bits,
            line_bits: bits_for(rows - 1) - bank_bits,
            rows,
        }
    }

    /// Width in bits of a number of rows.
    pub(super) fn rows_bits(&self) -> u32 {
        bits_for(self.rows)
    }
}
