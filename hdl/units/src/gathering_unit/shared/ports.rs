//! Ports of the top that its parts need.

use potamoi_netlist::Signal;

/// Ports of the top.
pub(crate) struct Ports {
    pub(crate) vertices: Signal,
    pub(crate) segments: Signal,
    pub(crate) clear: Signal,
    pub(crate) ready: Signal,
}
