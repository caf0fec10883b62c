//! Configuration of the splat unit.

use serde::{Deserialize, Serialize};

use super::Config;
use crate::units::OpCode;

/// The splat unit, which composites the records of Gaussians into the pixels of tiles. Its
/// exponential has the bits of that of the vector unit, [`VuConfig::exp`](super::VuConfig).
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SuConfig {
    /// Lanes of the exponential. Pipelined, one keeps up with the rest of the unit.
    pub lanes: u32,
    /// Tiles in flight, a power of two: the unit holds transmittance and colour of their pixels.
    pub tiles: u32,
    /// Units side by side, which take the ray groups of a frame in turn; 1 to 64.
    pub units: u32,
    /// Whether its exponential takes a power a clock, whatever `vu.exp.pipelined` is. Sigmoid and
    /// softplus, of fields, exclude a pipelined exponential from the vector unit alone.
    #[serde(skip_serializing_if = "is_false")]
    pub pipelined: bool,
    /// How an opacity enters an alpha.
    pub opacity: SplatOpacity,
}

/// How an opacity `o` enters the alpha `o exp(-u)` of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SplatOpacity {
    /// As a factor of the exponential, U0.16.
    #[default]
    Multiplied,
    /// As a part of the power, `exp(-(u - ln o))`: records hold `-ln o`, U3.13, in place of `o`.
    InPower,
}

/// What to do where a configuration has no splat unit.
pub const NO_SPLAT_UNIT: &str = "the configuration has no splat unit: add a table [su] with lanes and \
     tiles, for instance [su] lanes = 1 tiles = 16 pipelined = true";

impl Default for SuConfig {
    fn default() -> Self {
        Self {
            lanes: 12,
            tiles: 16,
            units: 1,
            pipelined: false,
            opacity: SplatOpacity::default(),
        }
    }
}

impl SuConfig {
    /// Columns and rows of the largest group of tiles that the unit holds, as square as a power of two
    /// allows.
    #[must_use]
    pub const fn group_tiles(&self) -> [u32; 2] {
        let order = match self.tiles.checked_ilog2() {
            None => 0,
            Some(order) => order,
        };
        [1 << order.div_ceil(2), 1 << (order / 2)]
    }

    /// Bits of a tile's number in the unit.
    #[must_use]
    pub const fn slot_bits(&self) -> u32 {
        match self.tiles.checked_ilog2() {
            None | Some(0) => 1,
            Some(bits) => bits,
        }
    }
}

// Serde passes a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
const fn is_false(value: &bool) -> bool {
    !*value
}

impl Config {
    /// The vector unit inside a splat unit: lanes of exponentials, and no other operation.
    #[must_use]
    pub fn splat_lanes(&self, su: &SuConfig) -> Self {
        let mut own = self.clone();
        own.vu.lanes = su.lanes;
        own.vu.ops = vec![OpCode::Exp];
        own.vu.operands = None;
        own.vu.exp.pipelined |= su.pipelined;
        own.su = None;
        own
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::config::{PRESETS, rules};

    #[test]
    fn the_lanes_of_every_splat_unit_keep_the_rules() {
        let mut units = 0;
        for (name, text) in PRESETS {
            let config = Config::from_toml(text, name).unwrap();
            let Some(su) = &config.su else { continue };
            let own = config.splat_lanes(su);
            let breaches = rules::check(&own);
            assert!(breaches.is_empty(), "{name}: {breaches}");
            assert!(own.vu.exp.pipelined, "{name}: a power a clock");
            units += 1;
        }
        assert_eq!(units, 2, "lean-splats and lean");
    }
}
