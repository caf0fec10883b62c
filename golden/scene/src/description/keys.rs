//! The keys of scene descriptions.

use potamoi_base::file_keys::Fate::Honoured;
use potamoi_base::file_keys::{Fate, Format, Key};
use potamoi_base::precision::NUMBERS;

/// Keys of the format.
pub(crate) static DESCRIPTION: Format = Format {
    name: "Scene descriptions",
    files: "`.toml`. Every list has as many values as stand here, at every depth.",
    keys: &KEYS,
    others: Fate::Refused,
};

/// The keys that are read here.
const OWN: [Key; 38] = [
    key(
        "model.kind",
        "builtin, splats, compact-3dgs, images, or that of a field: its table of keys names it",
    ),
    key("model.name", "of a built-in scene"),
    key("model.representation", "what a built-in scene is made into"),
    key(
        "model.path",
        "the file or folder, from the description's folder",
    ),
    key(
        "model.axes",
        "of splats and Compact-3DGS: where x, y and z of the file point, such as right-up-back",
    ),
    key(
        "model.level",
        "of streamed SOG: the level of detail, from 0; 0, the finest, unless given",
    ),
    key(
        "model.hash_unit",
        "of Instant-NGP: vertex or mvoxel, as the file was fitted",
    ),
    key("model.depth", "of images: the folder of depths"),
    key(
        "model.depth_scale",
        "of images: units of the poses a unit of the depths, above 0",
    ),
    key(
        "model.void_above",
        "of images: depths above are void, above 0",
    ),
    key(
        "camera.kind",
        "orbit, opencv-json, transforms, colmap or trajectory; not of images",
    ),
    key(
        "camera.path",
        "the file or folder, from the description's folder",
    ),
    key(
        "camera.index",
        "which camera of the file, from 0; of a trajectory, of the file `at`",
    ),
    key("camera.name", "of COLMAP: which image"),
    key(
        "camera.format",
        "of a trajectory: tum, euroc, kitti, replica or poses; recognised from the file unless given",
    ),
    key(
        "camera.rate_hz",
        "of a trajectory: frames a second, 0.001 to 1000; those of the command (`--fps`) unless given",
    ),
    key(
        "camera.start_s",
        "of a trajectory: seconds after the first pose; 0 unless given",
    ),
    key(
        "camera.duration_s",
        "of a trajectory: seconds; up to the last pose unless given",
    ),
    key(
        "camera.scale",
        "of a trajectory: scene units a unit of the file, above 0 to 1e9; unless given, the camera \
         moves away from its first place by half the scene's radius at most",
    ),
    key(
        "camera.at",
        "of a trajectory: first-view, or a camera file of either kind, at whose camera it begins",
    ),
    key(
        "camera.times",
        "of a trajectory of KITTI: the file of its times",
    ),
    key(
        "camera.file_hz",
        "of a trajectory without times: its poses a second, 0.001 to 1000",
    ),
    key(
        "camera.t_bs",
        "of a trajectory: the camera's pose in the body, 16 numbers by rows; the identity unless given",
    ),
    key("camera.width", "pixels a row, 1 to 16384"),
    key("camera.height", "rows, 1 to 16384"),
    key("camera.azimuth", "degrees"),
    key("camera.elevation", "degrees, between -89.9 and 89.9"),
    key("camera.distance", "1e-9 to 1e9"),
    key("camera.fov", "vertical field of view, 0.1 to 179 degrees"),
    key("camera.target", "three numbers from -1e9 to 1e9"),
    key("render.profile", "of splats: a renderer's rules"),
    key(
        "render.background",
        "linear RGB, three numbers; of images, too",
    ),
    key("render.order", "of splats: exact or approximate"),
    key(
        "render.group_tiles",
        "of splats: columns and rows of tiles, two whole numbers above 0",
    ),
    key(
        "render.group_side",
        "of voxels and fields: pixels a side of a ray group, above 0",
    ),
    key("render.halo", "of voxels and fields: shared or split"),
    key(
        "render.step",
        "of voxels: edges from sample to sample, 1/64 to 8",
    ),
    key(
        "render.antialiased",
        "of splats: as trained with antialiasing; as in the file unless given",
    ),
];

/// All keys, with the numbers of [`Precision`](potamoi_base::precision::Precision).
static KEYS: [Key; OWN.len() + NUMBERS.len()] = {
    let mut keys = [OWN[0]; OWN.len() + NUMBERS.len()];
    let mut at = 0;
    while at < keys.len() {
        keys[at] = match at < OWN.len() {
            true => OWN[at],
            false => NUMBERS[at - OWN.len()].key,
        };
        at += 1;
    }
    keys
};

const fn key(name: &'static str, about: &'static str) -> Key {
    let fate = Honoured;
    Key { name, fate, about }
}
