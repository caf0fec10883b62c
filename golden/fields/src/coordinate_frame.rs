//! A field in units of its own.

use super::Field;
use glam::DVec3;

/// The frame of reference in which rays are followed. Positions, lengths and bounds of a field and
/// of its sampling are in its units.
#[derive(Debug, Clone, Copy)]
pub struct CoordinateFrame {
    /// Origin in world coordinates.
    pub corner: DVec3,
    /// Unit of length, in world units.
    pub edge: f64,
}

impl CoordinateFrame {
    pub(crate) const WORLD: Self = Self {
        corner: DVec3::ZERO,
        edge: 1.0,
    };
}

/// A field in a frame of reference.
pub struct Local<'a> {
    /// The field, whose positions are in the units of the frame.
    pub field: Box<dyn Field + 'a>,
    /// The frame.
    pub frame: CoordinateFrame,
}
