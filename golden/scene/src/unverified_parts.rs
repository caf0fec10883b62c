//! Parts of a picture that no unit with verified RTL computes, and open questions of a model's
//! file. They are printed with every run, so that "no mismatch" is not overrated.

use super::{Kind, Model, Scene};
use potamoi_base::camera::Camera;
use potamoi_fields::unverified_work::{COMPOSITING, HARMONICS, HASHES, PARTS, PERCEPTRONS, RIT};
use potamoi_march::tiling::Halo;

/// For splats.
const PROJECTION: &str = "projection, harmonics, tiles and depth order of Gaussians: floating \
                          point, as on the GPU, rounded into records once";
const HOLDING: &str = "records held back until their turn: Rust, no RTL";
const CODES: &str =
    "sums of the codes of scales and rotations: floating point, when the file is read";
/// For a model's file.
const NO_REFERENCE: &str = "nearness to the truth: no picture that the model was trained on is at \
                            hand, only its own rendering in floating point";

impl Scene {
    /// Parts that no check of the units covers: those computed outside them, and for a model from
    /// a file its unused parts and assumptions.
    #[must_use]
    pub fn not_checked(&self) -> Vec<String> {
        self.not_checked_along(&[self.camera])
    }

    /// [`Scene::left_open`] for frames seen through `cameras`.
    #[must_use]
    pub fn left_open_along(&self, cameras: &[Camera]) -> Vec<String> {
        let mut all = self.left_open_of_files();
        all.extend(self.unseen(cameras));
        all
    }

    /// [`Scene::not_checked`] for frames seen through `cameras`.
    #[must_use]
    pub fn not_checked_along(&self, cameras: &[Camera]) -> Vec<String> {
        let mut all = self.unverified_stages();
        all.extend(self.left_open_along(cameras));
        all
    }

    /// Parts computed outside the units.
    fn unverified_stages(&self) -> Vec<String> {
        let outside: &[&str] = match (self.model(), self.model().kind()) {
            (Model::Compact(_), _) => &[
                CODES,
                HASHES,
                HARMONICS,
                PERCEPTRONS,
                PROJECTION,
                RIT,
                HOLDING,
                COMPOSITING,
            ],
            (_, Kind::Splats(_)) => &[PROJECTION, RIT, HOLDING, COMPOSITING],
            (_, Kind::Field(field)) => field.algorithm().outside,
        };
        let mut all: Vec<String> = outside.iter().map(|&what| what.to_owned()).collect();
        if self.halo == Halo::Split && !outside.contains(&PARTS) {
            all.push(PARTS.to_owned());
        }
        all
    }

    /// The part of [`Scene::not_checked`] that also applies to floating point: effects that are
    /// left out, unused parts of a model's file and assumptions, and cameras that see nothing.
    #[must_use]
    pub fn left_open(&self) -> Vec<String> {
        self.left_open_along(&[self.camera])
    }

    /// As [`Scene::left_open`], without the check of the camera.
    #[must_use]
    pub fn left_open_of_files(&self) -> Vec<String> {
        let left_out: Vec<String> = (self.choices().left_out().iter())
            .map(ToString::to_string)
            .collect();
        let mut all = vec![];
        if !left_out.is_empty() {
            all.push(format!(
                "the change by leaving out {}: potamoi effects --without shows it",
                left_out.join(", ")
            ));
        }
        all.extend(self.notes.sentences());
        if !self.from_file {
            return all;
        }
        all.push(NO_REFERENCE.to_owned());
        if let Kind::Field(field) = self.model().kind() {
            all.extend(field.assumed());
        }
        all
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use potamoi_fields::unverified_work::*;

    fn said(scene: &str) -> String {
        crate::tests::opened(scene).not_checked().join("; ")
    }

    fn fixture(name: &str) -> String {
        format!("{}/../tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"))
    }

    /// Each representation states its own unchecked parts, and no others.
    #[test]
    fn every_representation_says_what_its_units_do_not_compute() {
        let all = [
            PROJECTION,
            HOLDING,
            CODES,
            INDEXING,
            MASK,
            NODES,
            OCCUPANCY,
            HASHES,
            WAVES,
            FEATURE_WAVES,
            HARMONICS,
            MATRIX,
            PERCEPTRONS,
            COEFFICIENTS,
        ];
        for (representation, own) in [
            ("splats", &[PROJECTION, HOLDING][..]),
            (
                "compact",
                &[PROJECTION, HOLDING, CODES, HASHES, HARMONICS, PERCEPTRONS],
            ),
            ("voxels", &[INDEXING]),
            ("dvgo", &[INDEXING, MASK, WAVES, PERCEPTRONS]),
            (
                "tensorf",
                &[INDEXING, MASK, WAVES, FEATURE_WAVES, MATRIX, PERCEPTRONS],
            ),
            (
                "ngp",
                &[INDEXING, HASHES, OCCUPANCY, HARMONICS, PERCEPTRONS],
            ),
            ("efficientnerf", &[INDEXING, NODES, HARMONICS, COEFFICIENTS]),
        ] {
            let said = said(&format!("cairn:{representation}"));
            for what in all {
                let expected = own.contains(&what);
                assert_eq!(said.contains(what), expected, "{representation}: {what}");
            }
            assert!(said.contains(RIT) && said.contains(COMPOSITING));
            // Its truth is at hand.
            assert!(!said.contains(NO_REFERENCE), "{representation}");
        }
    }

    /// A hash grid of MVoxels says what one of vertices does, and that its
    /// MVoxels share no vertices.
    #[test]
    fn a_hash_grid_of_mvoxels_adds_sums_outside_the_reducers() {
        let [vertices, blocks] = ["cairn:ngp", "cairn:ngp-mvoxel"].map(said);
        assert!(!vertices.contains(PARTS));
        assert_eq!(blocks, format!("{vertices}; {PARTS}"));
    }

    /// Files state their open questions, their unused parts, and that their training pictures are
    /// missing.
    #[test]
    fn files_say_what_they_leave_open() {
        for (file, words) in [
            ("splats/cloud.sog", PROJECTION),
            ("compact/tiny.npz", CODES),
            ("ngp/cube.ingp", OCCUPANCY),
            ("tensorf/tiny.th", FEATURE_WAVES),
        ] {
            let said = said(&fixture(file));
            assert!(
                said.contains(NO_REFERENCE) && said.contains(words),
                "{file}: {said}"
            );
        }
        let said = said(&fixture("tensorf/tiny.th"));
        let names = "kwargs/alphaMask_thres, kwargs/pos_pe, the far end of kwargs/near_far";
        let ignored = format!("not used of the file: {names}");
        assert!(
            said.split("; ").any(|sentence| sentence == ignored),
            "{said}"
        );
    }

    #[test]
    fn a_split_halo_adds_sums_outside_the_reducers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        let open = |halo: &str| {
            let text = format!(
                "[model]\nkind = \"builtin\"\nname = \"lantern\"\n[render]\nhalo = \"{halo}\"\n"
            );
            std::fs::write(&path, text).unwrap();
            let scene = Scene::open(path.to_str().unwrap()).unwrap();
            scene.not_checked().join("; ")
        };
        assert!(open("split").contains(PARTS) && !open("shared").contains(PARTS));
        assert!(!open("shared").contains(NO_REFERENCE));
    }
}
