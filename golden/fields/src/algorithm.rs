//! What is said of an algorithm, whatever a model's numbers are.

use crate::file::FieldFile;

/// An algorithm of fields, as reports tell it.
#[derive(Debug)]
pub struct Algorithm {
    /// Its usual name.
    pub name: &'static str,
    /// What of a frame is computed outside the units, and by what: no check of the units covers
    /// it. The order is that of the report.
    pub outside: &'static [&'static str],
    /// How large its authors make its tables, where that is one number.
    pub full_size: Option<Size>,
    /// The preset whose units have what it takes.
    pub preset: &'static str,
    /// Its models' files; none of algorithms whose models are made in memory.
    pub file: Option<FieldFile>,
}

/// Tables of another size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// Vertices along each axis that has more than one; channels stay. Samples
    /// are as far apart as before, in voxels.
    Points(usize),
    /// Entries of hashed tables, and of dense ones no more. Vertices and samples
    /// stay.
    Entries(usize),
    /// Coarse cells along each axis of a tree. Samples are as far apart as before,
    /// in cells.
    Cells(usize),
}
