//! Ports of the top module used by its parts.

use potamoi_netlist::Signal;

/// Ports of the top module.
pub(crate) struct Ports {
    pub(crate) vertices: Signal,
    pub(crate) segments: Signal,
    pub(crate) clear: Signal,
    pub(crate) ready: Signal,
}
