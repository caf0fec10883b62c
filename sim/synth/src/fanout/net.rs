//! A net of a module, and the limits of what it may drive.

/// Pins that a cell may drive; the limit that ABC is given within a module.
pub(crate) const FAN_OUT: usize = 16;
/// A driver carries at most this part of its `max_capacitance`: a delay of about
/// three of an unloaded buffer, where a level more would cost as much.
pub(crate) const LOAD: f64 = 0.125;

/// A pin that a net goes to.
#[derive(Debug, Clone)]
pub(super) struct Sink {
    /// None of an output of the module.
    pub(super) cell: Option<String>,
    pub(super) pin: String,
    pub(super) at: usize,
    pub(super) load: f64,
}

/// What is on a net of a module.
#[derive(Debug, Default)]
pub(super) struct Net {
    pub(super) sinks: Vec<Sink>,
    /// How much the driver may carry; none of an input port.
    pub(super) strength: Option<f64>,
    pub(super) is_clock: bool,
    /// Whether ABC could not see all of it.
    pub(super) crosses: bool,
}
