//! What is to be estimated, and how much of it is simulated.

use potamoi_formats::config::Config;

use super::activity::{GatherWindow, VectorWindow};
use crate::{Library, Tools, UnitKind, UnitReport};

/// How much of a unit is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Two slices of few banks or lanes, of which the unit is composed; the whole unit
    /// where it has no more, or cannot be sliced.
    Slices,
    /// All of it.
    Whole,
}

/// What is to be estimated.
pub struct Order<'a> {
    /// The configuration.
    pub config: &'a Config,
    /// Its unit.
    pub unit: UnitKind,
    /// Its cells.
    pub library: &'a Library,
    /// What maps slices.
    pub tools: &'a Tools,
    /// What was made of the unit, and its netlist.
    pub made: (&'a UnitReport, &'a str),
    /// The scene whose work it is.
    pub scene: &'a str,
    /// Work for the gathering unit, and for the vector unit.
    pub windows: (Option<&'a GatherWindow>, Option<&'a VectorWindow>),
    /// How much is simulated.
    pub extent: Extent,
    /// Called after each step that was taken: a slice mapped, a netlist run without delays
    /// or with them.
    pub step: &'a dyn Fn(),
}
