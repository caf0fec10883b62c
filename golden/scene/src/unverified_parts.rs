//! Parts of a picture that no unit with verified RTL computes, and open questions of a model's
//! file. They are printed with every run, so that "no mismatch" is not overrated.

use super::{Kind, Model, Orbit, Scene};
use potamoi_base::camera::Camera;
use potamoi_fields::unverified_work::{COMPOSITING, HARMONICS, HASHES, PARTS, PERCEPTRONS, RIT};
use potamoi_formats::config::Config;
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
const USUAL_CAMERA: &str = "the camera: none is given, so that one on an orbit that frames the model \
                            is assumed";

impl Scene {
    /// Parts that no check of the configuration's units covers: those computed outside them, and for a
    /// model from a file its unused parts and assumptions.
    #[must_use]
    pub fn not_checked(&self, config: &Config) -> Vec<String> {
        self.not_checked_along(config, &[self.camera])
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
    pub fn not_checked_along(&self, config: &Config, cameras: &[Camera]) -> Vec<String> {
        let mut all = self.unverified_stages(config);
        all.extend(self.left_open_along(cameras));
        all
    }

    /// Parts computed outside the units. Of frames of splats, a splat unit gives the sums of colours and
    /// decides where pixels stop.
    fn unverified_stages(&self, config: &Config) -> Vec<String> {
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
        let on_unit = self.cloud().is_some() && self.splat_unit(config).is_some();
        let outside = outside
            .iter()
            .filter(|&&what| !on_unit || what != COMPOSITING);
        let mut all: Vec<String> = outside.map(|&what| what.to_owned()).collect();
        if self.halo == Halo::Split && all.iter().all(|what| what != PARTS) {
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
        if self.is_seen_as_usual() {
            all.push(USUAL_CAMERA.to_owned());
        }
        if let Kind::Field(field) = self.model().kind() {
            all.extend(field.assumed());
        }
        all
    }

    /// Whether the camera is the one of a model without a camera.
    fn is_seen_as_usual(&self) -> bool {
        let Camera { width, height, .. } = self.camera;
        let pose = |orbit: Orbit| orbit.camera(self.up, width, height).world_to_camera;
        let own = self.camera.world_to_camera;
        // The middle of a large model takes long to find, and is not needed for another direction.
        let is_turned_so = own.matrix3.abs_diff_eq(pose(Orbit::USUAL).matrix3, 1e-6);
        is_turned_so && own == pose(self.default_orbit())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use potamoi_fields::unverified_work::*;

    fn said(scene: &str) -> String {
        crate::tests::opened(scene)
            .not_checked(&Config::paper())
            .join("; ")
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

    /// With a splat unit the sums of splats are compared, and those of fields are not.
    #[test]
    fn sums_are_not_checked_unless_a_splat_unit_gives_them() {
        let with = Config::preset("lean-splats").unwrap();
        for (scene, on_unit) in [
            ("garden", true),
            ("cairn:splats", true),
            ("cairn:compact", true),
            ("cairn:voxels", false),
            ("cairn:ngp", false),
        ] {
            let scene = crate::tests::opened(scene);
            let says = |config: &Config| {
                scene
                    .not_checked(config)
                    .iter()
                    .any(|own| own == COMPOSITING)
            };
            assert!(says(&Config::paper()), "{}", scene.name());
            assert_eq!(says(&with), !on_unit, "{}", scene.name());
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
            scene.not_checked(&Config::paper()).join("; ")
        };
        assert!(open("split").contains(PARTS) && !open("shared").contains(PARTS));
        assert!(!open("shared").contains(NO_REFERENCE));
    }
}
