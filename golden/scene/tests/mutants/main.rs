//! Mutants of every file that this crate reads. Their kinds, and the contract of readers, are
//! described in `frame`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod cameras;
mod descriptions;
mod fields;
mod frame;
mod pictures;
mod splat_containers;
mod splats;
mod toys;

use frame::Format;

const BINARY: &str = "-p potamoi-scene --test mutants";

fn formats() -> Vec<Format> {
    [
        splats::formats(),
        splat_containers::formats(),
        fields::formats(),
        cameras::formats(),
        descriptions::formats(),
    ]
    .concat()
}

frame::tests! {
    ply, packed_ply, splat, spz, spz_4, compact, sog, sog_folder, ksplat, glb, gltf, sog_levels, dvgo, tensorf, ingp, msgpack,
    tum, euroc, replica, kitti, cameras_json, transforms_json, transforms_of_angles, colmap, images,
    scene_toml, configuration, trace, obj, mesh_ply
}
