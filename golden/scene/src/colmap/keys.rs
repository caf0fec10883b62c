//! Keys of a reconstruction's files, and their treatment.

use potamoi_base::file_keys::Fate::{Honoured, Listed, Refused};
use potamoi_base::file_keys::{Format, key};

const UNDISTORT: &str = "only pinholes are rendered; colmap image_undistorter makes such pictures";

/// Keys of the folder: its files.
pub(in super::super) static FOLDER: Format = Format {
    name: "COLMAP's folder",
    files: "`[camera] kind = \"colmap\"`: a reconstruction as text. Of other files of the folder \
            nothing is said.",
    keys: &[
        key(
            "cameras.txt",
            Honoured,
            "intrinsics; a mark before the text does no harm",
        ),
        key(
            "images.txt",
            Honoured,
            "poses and names, one image a line, and behind it a line of points, which may be empty; \
             or images alone, if no line of the file could be one of points",
        ),
        key("cameras.bin", Listed, "the text is read"),
        key("images.bin", Listed, "the text is read"),
        key("points3D.*", Listed, "no camera"),
        key("rigs.*", Listed, "images have poses of their own"),
        key("frames.*", Listed, "images have poses of their own"),
    ],
    others: Listed,
};

/// Keys of `cameras.txt`: models and their parameters.
pub(in super::super) static INTRINSICS: Format = Format {
    name: "COLMAP's cameras.txt",
    files: "Models, and the parameters of theirs.",
    keys: &[
        key("SIMPLE_PINHOLE", Honoured, "f, cx, cy"),
        key("PINHOLE", Honoured, "fx, fy, cx, cy"),
        key("SIMPLE_RADIAL", Honoured, "if k is 0"),
        key("RADIAL", Honoured, "if k1 and k2 are 0"),
        key("OPENCV", Honoured, "if k1, k2, p1 and p2 are 0"),
        key("FULL_OPENCV", Refused, UNDISTORT),
        key("*FISHEYE", Refused, UNDISTORT),
        key("FOV", Refused, UNDISTORT),
        key("DIVISION", Refused, UNDISTORT),
    ],
    others: Refused,
};

/// Keys of `images.txt`.
pub(in super::super) static POSES: Format = Format {
    name: "COLMAP's images.txt",
    files: "Fields of an image.",
    keys: &[
        key("IMAGE_ID", Honoured, "each once"),
        key(
            "QW, QX, QY, QZ",
            Honoured,
            "the rotation from world to camera; of length 1",
        ),
        key("TX, TY, TZ", Honoured, "the translation"),
        key("CAMERA_ID", Honoured, "a camera of cameras.txt"),
        key("NAME", Honoured, "the picture; images are sorted by it"),
        key("POINTS2D[]", Listed, "no camera"),
    ],
    others: Refused,
};
