//! The golden crates under one name, until callers name the crate that they mean.

pub use potamoi_analysis as analysis;
pub use potamoi_analytic as analytic;
pub use potamoi_base::{
    bands, camera, content, effects, files, mask, memory, picture, precision, record, sh, ssim,
};
pub use potamoi_containers::{ply, torch};
pub use potamoi_fields as fields;
pub use potamoi_fields::voxels;
pub use potamoi_march::{streams, tiling};
pub use potamoi_reference as units;
pub use potamoi_scene as scene;
pub use potamoi_scene::{characterise, compact, trace};
pub use potamoi_splats as splats;
pub use potamoi_warp as warp;
pub use potamoi_warp::mesh;
