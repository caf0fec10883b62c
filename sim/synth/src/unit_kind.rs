//! The units that can be synthesised.

use std::fmt;
use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_formats::units::{ARRAY_MAC, GATHERING_UNIT, SPLAT_UNIT, VECTOR_UNIT};
use potamoi_netlist::{IrErrors, Module};
use potamoi_units::array_mac::array_mac;
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::splat_unit::splat_unit;
use potamoi_units::vector_unit::vector_unit;

/// A unit that can be synthesised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitKind {
    /// The gathering unit.
    Gathering,
    /// The vector unit.
    Vector,
    /// A multiply-accumulate unit of the array; the same in every configuration.
    ArrayMac,
    /// The splat unit, of a configuration with one.
    Splat,
}

impl UnitKind {
    /// The units of every configuration.
    pub const ALL: [Self; 3] = [Self::Gathering, Self::Vector, Self::ArrayMac];

    /// The units of a configuration with a splat unit.
    pub const WITH_SPLAT_UNIT: [Self; 4] =
        [Self::Gathering, Self::Vector, Self::ArrayMac, Self::Splat];

    /// Its top module.
    #[must_use]
    pub const fn top(self) -> &'static str {
        match self {
            Self::Gathering => GATHERING_UNIT,
            Self::Vector => VECTOR_UNIT,
            Self::ArrayMac => ARRAY_MAC,
            Self::Splat => SPLAT_UNIT,
        }
    }

    /// Its netlist, without the gate that keeps ready low in reset.
    pub(super) fn module(self, config: &Config) -> Result<Arc<Module>, IrErrors> {
        let module = match self {
            Self::Gathering => gathering_unit(config)?,
            Self::Vector => vector_unit(config)?,
            Self::ArrayMac => array_mac()?,
            Self::Splat => splat_unit(config, &config.su.clone().unwrap_or_default())?,
        };
        Ok(Arc::new(module.without_reset_gates()))
    }
}

impl fmt::Display for UnitKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.top())
    }
}
