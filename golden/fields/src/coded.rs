//! A field in the hardware's formats, before its codes are cut into MVoxels of tables.

use potamoi_march::Head;

use crate::voxels::{MVoxels, Placement};

/// What a field has in the hardware's formats.
pub struct Coded<'a> {
    /// How its features are stored and gathered.
    pub storage: Storage,
    /// What makes opacity and colour of the features of all tables, one after
    /// another.
    pub head: Box<dyn Head + 'a>,
}

impl<'a> Coded<'a> {
    /// A field in tables whose codes have so many fraction bits, channel by channel.
    #[must_use]
    pub fn in_tables(frac_bits: Vec<Vec<u32>>, head: Box<dyn Head + 'a>) -> Self {
        Self {
            storage: Storage::Tables(frac_bits),
            head,
        }
    }
}

/// How features are stored and gathered.
#[derive(Debug, Clone)]
pub enum Storage {
    /// In the field's tables, which are gathered one after another for a batch of samples;
    /// fraction bits of the codes of each, channel by channel.
    Tables(Vec<Vec<u32>>),
    /// In one volume of vertices, through which rays are followed from MVoxel to MVoxel.
    Volume(Box<CodedVolume>),
}

/// A volume of vertices in codes.
#[derive(Debug, Clone)]
pub struct CodedVolume {
    /// Its MVoxels, with a shared halo.
    pub mvoxels: MVoxels,
    /// Where they lie.
    pub placement: Placement,
    /// Voxel edges from sample to sample.
    pub step: f64,
}
