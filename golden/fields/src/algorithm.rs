//! Description of an algorithm, independent of a model's numbers.

use crate::file::FieldFile;

/// An algorithm of radiance fields, as named in reports.
#[derive(Debug)]
pub struct Algorithm {
    /// Its usual name.
    pub name: &'static str,
    /// Parts of a frame that are computed outside the units, and by what: no check of the units
    /// covers them. Reports keep this order.
    pub outside: &'static [&'static str],
    /// Table size in the authors' configuration, if one number states it.
    pub full_size: Option<Size>,
    /// The preset whose units support it.
    pub preset: &'static str,
    /// The files of its models; `None` for models that exist only in memory.
    pub file: Option<FieldFile>,
}

/// A size of tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// Vertices along each axis that has more than one. Channels and the step in voxels do not
    /// change.
    Points(usize),
    /// Entries of hashed tables, and the upper limit for dense ones. Vertices and samples do not
    /// change.
    Entries(usize),
    /// Coarse cells of a tree along each axis, with `fine` cells in each of them along each axis.
    /// The step in cells does not change.
    Cells {
        /// Coarse cells along each axis.
        coarse: usize,
        /// Fine cells of a coarse one along each axis.
        fine: usize,
    },
}
