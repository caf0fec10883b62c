//! Registers of the exponential engine: their widths and what they hold.

use potamoi_formats::config::{Engine, ExpConfig};
use potamoi_netlist::{Signal, Ty};

use super::kinds::Kinds;

/// Widths of the engine's registers.
#[derive(Debug, Clone)]
pub(super) struct Widths {
    pub(super) exp: ExpConfig,
    pub(super) engine: Engine,
    pub(super) remain: Ty,
    pub(super) accum: Ty,
    pub(super) digits: Ty,
    pub(super) shift: Ty,
    /// What is built.
    pub(super) kinds: Kinds,
}

/// The state that a step takes and gives.
#[derive(Clone, Copy)]
pub(super) struct State {
    pub(super) remain: Signal,
    pub(super) accum: Signal,
    pub(super) digits: Signal,
}

/// One place of the shift registers, as signals.
#[derive(Clone)]
pub(super) struct Place {
    /// One constant, or of radix 4 those of the digits 1, 2 and 3.
    pub(super) constants: Vec<Signal>,
    pub(super) shift: Signal,
    pub(super) digit: Signal,
}

/// What the engine holds for the result stage.
pub(super) struct Powers {
    pub(super) state: State,
    pub(super) large: Signal,
    /// Of sigmoid and softplus, where they are built: the power, scaled, and
    /// the sum that softplus rounds.
    pub(super) logistic: Option<(Signal, Signal)>,
    /// The exponent, where it is known already.
    pub(super) exponent: Option<Signal>,
    /// With an early out: there are steps to take after the next clock.
    pub(super) more: Option<Signal>,
}
