//! Nets of a module, and their limits of fan-out and load.

/// Largest fan-out of a cell, the same limit that ABC has within a module.
pub(crate) const FAN_OUT: usize = 16;
/// Largest load of a driver, as a share of its `max_capacitance`: about three delays of an unloaded
/// buffer, where another level would cost as much.
pub(crate) const LOAD: f64 = 0.125;

/// A pin that reads a net.
#[derive(Debug, Clone)]
pub(super) struct Sink {
    /// The cell; `None` for an output of the module.
    pub(super) cell: Option<String>,
    pub(super) pin: String,
    pub(super) at: usize,
    pub(super) load: f64,
}

/// Pins of a net of a module.
#[derive(Debug, Default)]
pub(super) struct Net {
    pub(super) sinks: Vec<Sink>,
    /// Drive strength; `None` for an input port.
    pub(super) strength: Option<f64>,
    pub(super) is_clock: bool,
    /// Whether part of it is invisible to ABC.
    pub(super) crosses: bool,
}
