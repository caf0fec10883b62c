//! The algorithms, each with a folder and a line in [`FIELDS`].

pub mod dvgo;
pub mod efficient;
pub mod ngp;
pub mod tensorf;
pub mod voxels;

use crate::{Algorithm, FieldFile};

/// Every algorithm, in the order in which lists and tables name them.
pub static FIELDS: [&Algorithm; 6] = [
    &voxels::ALGORITHM,
    &dvgo::ALGORITHM,
    &tensorf::ALGORITHM,
    &ngp::ALGORITHM,
    &ngp::BY_MVOXEL,
    &efficient::ALGORITHM,
];

/// The file formats of all fields.
pub fn files() -> impl Iterator<Item = &'static FieldFile> {
    FIELDS.iter().filter_map(|field| field.file.as_ref())
}

/// The file format with this extension.
#[must_use]
pub fn file_of_ending(ending: &str) -> Option<&'static FieldFile> {
    files().find(|file| file.endings.contains(&ending))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names, kinds and extensions are unique.
    #[test]
    fn no_two_fields_are_called_alike() {
        let names = FIELDS.iter().map(|field| field.name);
        let kinds = files().map(|file| file.kind);
        let endings = files().flat_map(|file| file.endings.iter().copied());
        for mut all in [
            names.collect::<Vec<_>>(),
            kinds.collect(),
            endings.collect(),
        ] {
            let count = all.len();
            assert!(
                count > 2 && all.iter().all(|own| !own.is_empty()),
                "{all:?}"
            );
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), count, "{all:?}");
        }
    }

    #[test]
    fn every_description_of_a_file_has_a_path() {
        for file in files() {
            assert!(file.keys.contains(&"path"), "{}", file.kind);
            for ending in file.endings {
                assert_eq!(*ending, ending.to_lowercase(), "{}", file.kind);
                assert_eq!(file_of_ending(ending).map(|own| own.kind), Some(file.kind));
            }
        }
    }
}
