//! Order of a power estimate, and its extent.

use potamoi_formats::config::Config;

use super::activity::{GatherWindow, SplatWindow, VectorWindow};
use crate::{Library, SynthesisedUnit, Tools, UnitKind};

/// Simulated part of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Two slices of few banks or lanes, from which the unit is composed; the whole unit where it
    /// is no larger or cannot be sliced.
    Slices,
    /// The whole unit.
    Whole,
}

/// Work of the units that the scene has.
#[derive(Debug, Clone, Copy, Default)]
pub struct Windows<'a> {
    /// Of the gathering unit.
    pub gather: Option<&'a GatherWindow>,
    /// Of the vector unit.
    pub vector: Option<&'a VectorWindow>,
    /// Of the splat unit.
    pub splat: Option<&'a SplatWindow>,
}

/// Order of a power estimate.
#[derive(Clone, Copy)]
pub struct Order<'a> {
    /// The configuration.
    pub config: &'a Config,
    /// Its unit.
    pub unit: UnitKind,
    /// Cell library.
    pub library: &'a Library,
    /// Tools that map slices.
    pub tools: &'a Tools,
    /// The synthesised unit.
    pub made: &'a SynthesisedUnit,
    /// Name of the scene.
    pub scene: &'a str,
    /// Work of the units.
    pub windows: Windows<'a>,
    /// Simulated part.
    pub extent: Extent,
    /// Called after each step: a slice mapped, or a netlist simulated without or with delays.
    pub step: &'a dyn Fn(),
}
