//! Faults that a verification must find.

use std::sync::Arc;

use potamoi_formats::config::{Config, Modes, Organisation};
use potamoi_formats::units::GATHERING_UNIT;
use potamoi_netlist::{Change, Fault, FaultError, Module};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A fault of a unit's netlist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Injection {
    /// The reducers' accumulators get one bit inverted: the result's lowest bit.
    Bit,
    /// After reset the feature FIFO has one free place only: values stay right, and cycles are lost
    /// to back-pressure.
    Bubble,
    /// The lowest bit of port 0's weights is inverted, so that the weights of an entry no longer
    /// sum to 1.
    Weight,
    /// Lanes of the feature-major organisation get inverted whether they wait for a bank; with
    /// split banks, port 0 whether it had its turn.
    Grant,
    /// The crossbar of the feature-major organisation returns the neighbouring bank's word; with
    /// split banks, port 1 gets the other read's word.
    Crossbar,
    /// One bit of a constant of the exponential engines is inverted: ln(1 + 2^-1), or in the
    /// pipelined form a constant of the first stage, or an entry of the piece table.
    Exp,
    /// The lowest bit of the splat unit's alphas is inverted.
    Alpha,
}

impl Injection {
    /// The fault for the unit of a configuration.
    #[must_use]
    pub fn fault(self, config: &Config) -> Fault {
        let (gu, exp) = (&config.gu, &config.vu.exp);
        // High enough to be seen after rounding.
        let high = exp.engine().constant_bits.saturating_sub(3);
        let first_factor = format!("sr_sub[{}]", exp.engine().digits);
        let (module, register, change) = match self {
            Self::Alpha => ("splat_tiles", "alpha_3", Change::Invert(0)),
            Self::Bit if gu.modes == Modes::Unstructured => {
                ("feature_register", "held0", Change::Invert(0))
            }
            Self::Bit if config.is_parity() => {
                ("cell_reducer", "acc", Change::Invert(gu.weight_bits))
            }
            Self::Bit => ("reducer", "acc", Change::Invert(gu.weight_bits)),
            Self::Weight if gu.organisation == Organisation::FeatureMajor => {
                ("gather_lane", "x_weight", Change::Invert(0))
            }
            Self::Grant if config.table_parts() > 1 => ("mft", "served", Change::Invert(0)),
            Self::Crossbar if config.table_parts() > 1 => ("mft", "source1", Change::Invert(0)),
            Self::Grant => ("gather_lane", "pending", Change::Invert(0)),
            Self::Crossbar => ("gather_lane", "d_bank", Change::Invert(0)),
            // There is none, which the netlist says.
            Self::Weight if gu.modes == Modes::Unstructured => {
                (GATHERING_UNIT, "s1_weight", Change::Invert(0))
            }
            Self::Weight if config.is_parity() => ("rit_buffer", "p_weight0_0", Change::Invert(0)),
            Self::Weight => ("rit_buffer", "p_weight0", Change::Invert(0)),
            Self::Bubble => {
                let taken = config.feature_fifo_depth().saturating_sub(1);
                (GATHERING_UNIT, "in_flight", Change::Reset(taken.into()))
            }
            // Without steps there is the mantissa alone.
            Self::Exp if exp.power_pipeline().turn() == 0 => {
                let high = exp.engine().accumulator_bits.saturating_sub(3);
                ("vector_lane", "s_accum", Change::Invert(high))
            }
            Self::Exp if exp.pipelined => ("vector_lane", "s_remain_0", Change::Invert(high)),
            Self::Exp => (
                "exp_constants",
                first_factor.as_str(),
                Change::ResetBit(high),
            ),
        };
        Fault {
            module: module.to_owned(),
            register: register.to_owned(),
            change,
        }
    }

    /// Whether the fault is in the splat unit.
    #[must_use]
    pub const fn is_of_splat_unit(self) -> bool {
        matches!(self, Self::Alpha)
    }

    /// Whether the fault is in the gathering unit.
    #[must_use]
    pub const fn is_of_gathering_unit(self) -> bool {
        !self.is_of_vector_unit() && !self.is_of_splat_unit()
    }

    /// Whether the fault is in the vector unit.
    #[must_use]
    pub const fn is_of_vector_unit(self) -> bool {
        matches!(self, Self::Exp)
    }

    /// The unit with the fault.
    ///
    /// # Errors
    /// A unit without the part that the fault needs.
    pub fn apply(self, config: &Config, unit: &Arc<Module>) -> Result<Arc<Module>, FaultError> {
        self.fault(config).inject(unit)
    }
}

impl std::fmt::Display for Injection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Bit => "bit",
            Self::Bubble => "bubble",
            Self::Weight => "weight",
            Self::Grant => "grant",
            Self::Crossbar => "crossbar",
            Self::Exp => "exp",
            Self::Alpha => "alpha",
        })
    }
}
