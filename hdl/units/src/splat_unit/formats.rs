//! Widths of the splat unit's signals.

use potamoi_formats::config::{Config, SplatOpacity, SuConfig};
use potamoi_formats::record::{FACTOR, MEAN};

/// Fraction bits of exact forms.
pub(super) const EXACT: u32 = FACTOR.frac_bits() + MEAN.frac_bits();
/// Bits of a form's start value at a tile: within 128 with the sign.
pub(super) const START: u32 = 8 + EXACT;
/// Bits of a form at a row: 30 more at the last row.
pub(super) const AT_ROW: u32 = START + 1;
/// Bits of a factor.
pub(super) const STEP: u32 = 32;
/// Fraction bits of start values and steps in the search for spans.
pub(super) const SEARCH: u32 = 10;
/// Fraction bits of a form that is compared.
pub(super) const COMPARE: u32 = 6;
/// Bits of a rounded form's magnitude, 16 of them a fraction; larger ones count nowhere.
pub(super) const MAGNITUDE: u32 = 18;
/// Bits of the root of a limit, with [`COMPARE`] fraction bits.
pub(super) const ROOT: u32 = 2 + COMPARE;
/// Bits of a limit in the search, with 2 [`COMPARE`] fraction bits.
pub(super) const SEARCH_LIMIT: u32 = 2 * ROOT;
/// Bits of a transmittance, U1.20.
pub(super) const TRANSMITTANCE: u32 = 21;
/// Bits of a colour sum: below 16, 32 fraction bits.
pub(super) const COLOUR_SUM: u32 = 36;
/// Bits of a pixel's place in its tile: row, column.
pub(super) const PIXEL: u32 = 8;
/// Entries whose pixels are in flight before the exponential.
pub(super) const ENTRIES: u32 = 8;

/// Widths that depend on the configuration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Widths {
    /// A tile's number.
    pub(super) slot: u32,
    /// A power: the exponential's input.
    pub(super) power: u32,
    /// Fraction bits of a power.
    pub(super) power_fraction: u32,
    /// An exponential's result.
    pub(super) exponential: u32,
    /// Lanes of the exponential.
    pub(super) lanes: u32,
    /// Tiles in flight.
    pub(super) tiles: u32,
    /// How opacities enter alphas.
    pub(super) opacity: SplatOpacity,
}

impl Widths {
    pub(super) fn of(config: &Config, su: &SuConfig) -> Self {
        let exp = &config.vu.exp;
        Self {
            slot: su.slot_bits(),
            power: exp.input.width(),
            power_fraction: exp.input.frac_bits(),
            exponential: exp.output_bits,
            lanes: su.lanes,
            tiles: su.tiles,
            opacity: su.opacity,
        }
    }

    /// A pixel of a tile in flight: slot, row, column.
    pub(super) const fn pixel(&self) -> u32 {
        self.slot + PIXEL
    }

    /// What goes along with a power: colour and pixel, and above them the opacity if it is a factor.
    pub(super) const fn info(&self) -> u32 {
        let opacity = match self.opacity {
            SplatOpacity::Multiplied => 16,
            SplatOpacity::InPower => 0,
        };
        opacity + 48 + self.pixel()
    }
}
