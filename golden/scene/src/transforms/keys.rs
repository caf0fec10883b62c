//! Keys of `transforms.json`, for all frames and for one.

use crate::lens_keys::with_strange_lenses;
use potamoi_base::file_keys::Fate::{Honoured, Listed};
use potamoi_base::file_keys::{Format, key};

const SHUTTER: &str = "a frame is seen at one moment; 0 is accepted";
/// Keys of a lens, which a document has for all frames or a frame for itself, before the other
/// keys.
macro_rules! with_lens {
    ($($own:expr),* $(,)?) => {
        with_strange_lenses![
            $($own,)*
            key("w", Honoured, "pixels a row; without it twice `cx`, else `h`, else 800"),
            key("h", Honoured, "rows; without it twice `cy`, else `w`"),
            key("fl_x", Honoured, "focal length in pixels"),
            key("fl_y", Honoured, "the same of columns; `fl_x` unless given"),
            key("x_fov", Honoured, "horizontal field of view in degrees; counts before `fl_x`"),
            key("y_fov", Honoured, "vertical field of view in degrees"),
            key("camera_angle_x", Honoured, "horizontal field of view in radians; `fl_x` counts before it"),
            key("camera_angle_y", Honoured, "vertical field of view in radians"),
            key("cx", Honoured, "principal point in pixels; the middle unless given"),
            key("cy", Honoured, "the same of columns"),
            key("camera_model", Honoured, "a pinhole, or a lens whose distortion is 0; others are refused"),
            key("rolling_shutter*", Refused, SHUTTER),
            key("exposure_time", Refused, SHUTTER),
            key("*motion*blur*", Refused, SHUTTER),
            key("transform_matrix_*", Refused, SHUTTER),
            key("from_mitsuba", Refused, "its axes are others; false is accepted"),
            key("near", Listed, "all that is in view is rendered"),
            key("far", Listed, "all that is in view is rendered"),
            key("mask_path", Listed, "of training"),
            key("depth_path", Listed, "of training"),
            key("depth_file_path", Listed, "of training"),
        ]
    };
}

/// Keys of the document.
pub(crate) static PATH: Format = Format {
    name: "transforms.json",
    files: "`[camera] kind = \"transforms\"`, and the folder of `[model] kind = \"images\"`: the camera \
            paths of NeRF's synthetic scenes, Instant-NGP and Nerfstudio",
    keys: with_lens![
        key("frames", Honoured, "the frames, in this order"),
        key("aabb_scale", Listed, "of training: a snapshot has its own"),
        key("aabb", Listed, "of training: a snapshot has its own"),
        key(
            "render_aabb",
            Listed,
            "of the viewer: a snapshot has its own"
        ),
        key("scale", Listed, "of training: a snapshot has its own"),
        key("offset", Listed, "of training: a snapshot has its own"),
        key("up", Listed, "of the viewer"),
        key(
            "n_extra_learnable_dims",
            Listed,
            "of training: a snapshot has its own"
        ),
        key("is_hdr", Listed, "of training: a snapshot has its own"),
        key("white_transparent", Listed, "of training"),
        key("black_transparent", Listed, "of training"),
        key("mask_color", Listed, "of training"),
        key("fix_premult", Listed, "of training"),
        key("sharpen", Listed, "of training"),
        key("sharpness_discard_threshold", Listed, "of training"),
        key("enable_ray_loading", Listed, "of training"),
        key("enable_depth_loading", Listed, "of training"),
        key("integer_depth_scale", Listed, "of training"),
        key("depth_unit_scale_factor", Listed, "of training"),
        key("ply_file_path", Listed, "points that training starts from"),
        key("applied_transform", Listed, "poses have it already"),
        key("applied_scale", Listed, "poses have it already"),
        key(
            "orientation_override",
            Listed,
            "of training: poses are taken as they stand"
        ),
        key(
            "auto_scale_poses_override",
            Listed,
            "of training: poses are taken as they stand"
        ),
        key("train_filenames", Listed, "of training"),
        key("val_filenames", Listed, "of training"),
        key("test_filenames", Listed, "of training"),
    ],
    others: Listed,
};

/// Keys of a frame.
pub(crate) static FRAME: Format = Format {
    name: "transforms.json, frames[]",
    files: "A frame's own keys take precedence over those of the document.",
    keys: with_lens![
        key(
            "file_path",
            Honoured,
            "the picture, of image sequences; the frame's name"
        ),
        key(
            "transform_matrix",
            Honoured,
            "camera to world, by rows: a rotation and a translation"
        ),
        key(
            "rotation",
            Listed,
            "the way was made with it; no camera is turned by it"
        ),
        key("sharpness", Listed, "of training"),
        key("colmap_im_id", Listed, "where the frame is from"),
        key("time", Listed, "models stand still"),
        key("timestamp", Listed, "models stand still"),
    ],
    others: Listed,
};
