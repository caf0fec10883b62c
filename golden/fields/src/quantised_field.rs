//! A field in the formats of the hardware, before its tables are cut into MVoxels.

use potamoi_march::Head;

use crate::volume::CodedVolume;

/// The fixed-point form of a field.
pub struct QuantisedField<'a> {
    /// Storage of its features.
    pub storage: Storage,
    /// Computes opacity and colour from the features of all tables, one after another.
    pub head: Box<dyn Head + 'a>,
}

impl<'a> QuantisedField<'a> {
    /// A field in tables whose codes have these fraction bits, channel by channel.
    #[must_use]
    pub fn in_tables(frac_bits: Vec<Vec<u32>>, head: Box<dyn Head + 'a>) -> Self {
        Self {
            storage: Storage::Tables(frac_bits),
            head,
        }
    }
}

/// Storage of features, which decides how they are gathered.
#[derive(Debug, Clone)]
pub enum Storage {
    /// The field's tables, gathered one after another for a batch of samples; with the fraction
    /// bits of the codes of each, channel by channel.
    Tables(Vec<Vec<u32>>),
    /// One volume of vertices, in which rays are followed from MVoxel to MVoxel.
    Volume(Box<CodedVolume>),
}
