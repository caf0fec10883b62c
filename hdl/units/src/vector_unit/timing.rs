//! Latency and capacity of the unit.

use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;

use super::operation_kinds::OperationKinds;

/// Clocks and capacity of the unit.
pub(super) struct Timing {
    /// Clocks of an exponential in the iterative form, or stages of the pipelined one.
    pub(super) interval: u32,
    /// Clocks of the longest operation.
    pub(super) longest: u32,
    pub(super) pipelined: bool,
    /// Clocks by which register stages of a registered unit delay every result.
    pub(super) lag: u32,
    /// Largest number of vectors in flight: those in the FIFO, and those in the stages.
    pub(super) depth: u32,
}

impl Timing {
    pub(super) fn of(config: &Config, kinds: OperationKinds) -> Self {
        let exp = &config.vu.exp;
        let interval = if kinds.exp { exp.interval() } else { 1 };
        let longest = match (kinds.sigmoid, kinds.softplus) {
            (true, _) => config.vu.passes(OpCode::Sigmoid).cycles(),
            (_, true) => config.vu.passes(OpCode::Softplus).cycles(),
            _ => interval,
        };
        let pipelined = kinds.exp && exp.pipelined;
        let lag = config.vu.lag();
        Self {
            interval,
            longest,
            pipelined,
            lag,
            depth: config.vu.fifo_depth + lag + if pipelined { interval + 1 } else { 0 },
        }
    }
}

/// Largest number of vectors in flight.
pub(crate) fn depth(config: &Config) -> u32 {
    Timing::of(config, OperationKinds::of(config)).depth
}
