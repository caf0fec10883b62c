//! Ports of the top that its parts need.

use crate::ir::Signal;

/// Ports of the top.
pub(super) struct Ports {
    pub(super) vertices: Signal,
    pub(super) segments: Signal,
    pub(super) clear: Signal,
    pub(super) ready: Signal,
}
