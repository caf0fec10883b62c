//! The identity of a scene: hashes of everything that determines its pictures and their cost, part
//! by part.

use serde::Serialize;

use super::{Model, Scene};
use crate::compact_3dgs::Compact;
use potamoi_base::content_hash::hash_of;
use potamoi_fields::AnyField;
use potamoi_gaussians::Cloud;

impl Scene {
    /// Hashes of everything that determines what is rendered and how, with the names of the parts.
    /// Scenes with equal hashes are rendered alike.
    #[must_use]
    pub fn identity(&self) -> Vec<(&'static str, blake3::Hash)> {
        // A new field has to be put on one of the two lists.
        let Self {
            name,
            model,
            camera,
            path,
            motion,
            up,
            background,
            profile,
            order,
            group_tiles,
            group_side,
            halo,
            cells,
            step,
            from_file,
            truth,
            choices,
            precision,
            // Words about the files: nothing is rendered otherwise for them.
            file_facts: _,
            notes: _,
            // The model is turned already, and it and the camera are from the origin on.
            axes: _,
            origin: _,
            // What follows from the model.
            found,
        } = self;
        vec![
            ("name", hash_of(name)),
            ("model", found.content(|| model.key())),
            ("camera", hash_of(camera)),
            ("path", hash_of(path)),
            ("motion", hash_of(motion)),
            ("up", hash_of(up)),
            ("background", hash_of(background)),
            ("profile", hash_of(profile)),
            ("order", hash_of(order)),
            ("group_tiles", hash_of(group_tiles)),
            ("group_side", hash_of(group_side)),
            ("halo", hash_of(halo)),
            ("cells", hash_of(cells)),
            ("step", hash_of(step)),
            ("from_file", hash_of(from_file)),
            ("truth", hash_of(truth)),
            ("choices", hash_of(choices)),
            ("precision", hash_of(precision)),
        ]
    }
}

/// A model as kept work names it.
#[derive(Serialize)]
enum Kept<'a> {
    Splats(&'a Cloud),
    Compact(&'a Compact),
    Field(&'a AnyField),
}

impl Model {
    /// The hash of its numbers, which identifies it in kept work.
    #[must_use]
    pub fn key(&self) -> blake3::Hash {
        match self {
            Self::Splats(cloud) => hash_of(&Kept::Splats(cloud)),
            Self::Compact(model) => hash_of(&Kept::Compact(model)),
            Self::Field(field) => match field.stored() {
                Some(stored) => stored.key(),
                None => hash_of(&Kept::Field(field)),
            },
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use crate::model_facts::Cache;
    use potamoi_base::camera::Camera;
    use potamoi_base::effects::{Choices, Effect};
    use potamoi_base::precision::Precision;
    use potamoi_march::tiling::Halo;
    use potamoi_splats::{Cells, Order, Profile};

    /// Changes every field of a scene alone.
    #[test]
    fn every_field_changes_its_part_and_no_other() {
        let scene = crate::tests::opened("lantern");
        let other = crate::tests::opened("garden");
        let with = |change: &dyn Fn(&mut Scene)| {
            let mut changed = scene.clone();
            changed.found = Cache::default();
            change(&mut changed);
            changed
        };
        let precision = Precision {
            stop_below: Some(0.25),
            ..Precision::default()
        };
        let motion = || crate::trajectory::Motion::of_a_circle(&scene.camera);
        let changed: Vec<(&str, Scene)> = vec![
            ("name", with(&|s| s.name.push('x'))),
            ("model", with(&|s| s.model = Arc::clone(&other.model))),
            ("camera", with(&|s| s.camera.focal.x += 1e-9)),
            ("path", with(&|s| s.path = vec![scene.camera; 2])),
            ("motion", with(&|s| s.motion = Some(motion()))),
            ("up", with(&|s| s.up = DVec3::new(1.0, 0.0, -0.0))),
            ("background", with(&|s| s.background[2] += 1e-6)),
            ("profile", with(&|s| s.profile = Profile::Brush)),
            ("order", with(&|s| s.order = Order::Approximate)),
            ("group_tiles", with(&|s| s.group_tiles = Some([1, 2]))),
            ("group_side", with(&|s| s.group_side = Some(4))),
            ("halo", with(&|s| s.halo = Halo::Split)),
            (
                "cells",
                with(&|s| {
                    s.cells = Cells {
                        halvings: 3,
                        merge: s.cells.merge,
                    }
                }),
            ),
            ("step", with(&|s| s.step *= 1.0 + 1e-12)),
            ("from_file", with(&|s| s.from_file = !s.from_file)),
            (
                "truth",
                with(&|s| s.truth = Some(potamoi_analytic::Analytic::Vase)),
            ),
            (
                "choices",
                with(&|s| {
                    s.choices = Choices::default().force(Effect::Warping);
                }),
            ),
            ("precision", with(&|s| s.precision = precision)),
        ];
        let own = scene.identity();
        let names: Vec<&str> = own.iter().map(|(name, _)| *name).collect();
        let tried: Vec<&str> = changed.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, tried, "every part is tried");
        for (name, scene) in &changed {
            let differ: Vec<&str> = own
                .iter()
                .zip(scene.identity())
                .filter(|(a, b)| **a != *b)
                .map(|(a, _)| a.0)
                .collect();
            assert_eq!(differ, [*name]);
        }
        assert_eq!(scene.clone().identity(), own);
    }

    /// Paths of equal length and equal beginning that differ in one number of one camera.
    #[test]
    fn one_number_of_any_frame_changes_a_path() {
        let mut scene = crate::tests::opened("lantern");
        scene.path = scene.path(30.0, 4).unwrap();
        let part = |scene: &Scene| {
            let all = scene.identity();
            all.into_iter().find(|(name, _)| *name == "path").unwrap().1
        };
        let mut known = vec![part(&scene)];
        let changes: [fn(&mut Camera); 7] = [
            |c| c.width += 1,
            |c| c.height += 1,
            |c| c.focal.x *= 1.0 + 1e-12,
            |c| c.focal.y *= 1.0 + 1e-12,
            |c| c.centre.y += 1e-9,
            |c| c.world_to_camera.translation.z += 1e-12,
            |c| c.world_to_camera.matrix3.y_axis.x += 1e-12,
        ];
        for frame in 0..scene.path.len() {
            for change in changes {
                let mut other = scene.clone();
                change(&mut other.path[frame]);
                known.push(part(&other));
            }
        }
        let mut shorter = scene.clone();
        shorter.path.pop();
        known.push(part(&shorter));
        let all = known.len();
        known.sort_by_key(|hash| *hash.as_bytes());
        known.dedup();
        assert_eq!(known.len(), all);
    }

    /// Models that differ only in one number, not in name, size or shape.
    #[test]
    fn one_number_of_a_model_changes_it() {
        let content = Model::key;
        for name in [
            "garden",
            "lantern",
            "cairn:dvgo",
            "cairn:tensorf",
            "cairn:ngp",
        ] {
            let scene = crate::tests::opened(name);
            let again = Scene::open(name).unwrap();
            assert_eq!(content(&scene.model), content(&again.model), "{name}");
        }
        let of = |value: f32| {
            let mut features = vec![0.5_f32; 8 * 13];
            features[100] = value;
            let layout = potamoi_fields::voxels::Layout::Linear;
            let grid =
                potamoi_fields::voxels::Grid::new([2; 3], DVec3::ZERO, 1.0, layout, features);
            content(&Model::Field(grid.unwrap().into()))
        };
        assert_ne!(of(0.5), of(0.500_000_1));
    }
}
