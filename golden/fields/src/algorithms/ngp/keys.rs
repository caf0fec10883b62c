//! Keys of Instant-NGP snapshots, after the code that writes them (`Testbed::save_snapshot`, the
//! configurations of its networks, and `Trainer::serialize` of tiny-cuda-nn).

use potamoi_base::file_keys::Fate::{Honoured, Listed, Refused};
use potamoi_base::file_keys::{Format, key};

const ACTIVATIONS: &str =
    "densities are exponentials and colours logistic functions, as training sets them";

/// Keys by path.
pub static NGP: Format = Format {
    name: "Instant-NGP",
    files: "`[model] kind = \"ngp\"`, `.ingp` and `.msgpack`, snapshots of version 1. Parameters and occupancy have to be finite.",
    keys: &[
        key(
            "encoding.otype",
            Honoured,
            "HashGrid, or Grid with type Hash",
        ),
        key("encoding.type", Honoured, "Hash"),
        key(
            "encoding.hash",
            Honoured,
            "CoherentPrime, as where it is not said",
        ),
        key("encoding.interpolation", Honoured, "Linear"),
        key("encoding.stochastic_interpolation", Honoured, "false"),
        key("encoding.n_levels", Honoured, "1 to 32"),
        key("encoding.n_features", Honoured, "of all levels together"),
        key("encoding.n_features_per_level", Honoured, "1, 2, 4 or 8"),
        key("encoding.log2_hashmap_size", Honoured, "3 to 24"),
        key("encoding.base_resolution", Honoured, "1 to 16384"),
        key("encoding.per_level_scale", Honoured, "1 to 64"),
        key(
            "encoding.hash_unit",
            Honoured,
            "of tools/fit: vertex or mvoxel",
        ),
        key("network.otype", Honoured, "FullyFusedMLP"),
        key("network.activation", Honoured, "ReLU"),
        key("network.output_activation", Honoured, "None"),
        key("network.n_neurons", Honoured, "16, 32, 64 or 128"),
        key("network.n_hidden_layers", Honoured, "1 to 8"),
        key("network.n_output_dims", Honoured, "1 to 16"),
        key("rgb_network.otype", Honoured, "FullyFusedMLP"),
        key("rgb_network.activation", Honoured, "ReLU"),
        key("rgb_network.output_activation", Honoured, "None"),
        key("rgb_network.n_neurons", Honoured, "16, 32, 64 or 128"),
        key("rgb_network.n_hidden_layers", Honoured, "1 to 8"),
        key("rgb_network.n_output_dims", Honoured, "1 to 3"),
        key(
            "dir_encoding.otype",
            Honoured,
            "SphericalHarmonics, or Composite that begins with them",
        ),
        key("dir_encoding.degree", Honoured, "4"),
        key(
            "dir_encoding.n_dims_to_encode",
            Honoured,
            "of a composite's first part: 3",
        ),
        key("dir_encoding.nested", Honoured, "parts of a composite"),
        key(
            "dir_encoding.nested.*",
            Listed,
            "no dimension is left for parts behind the first",
        ),
        key("snapshot.version", Honoured, "1"),
        key(
            "snapshot.mode",
            Honoured,
            "nerf; sdf, image and volume are refused",
        ),
        key("snapshot.n_params", Honoured, "as many as there are"),
        key("snapshot.params_type", Honoured, "__half or float"),
        key(
            "snapshot.params_binary",
            Honoured,
            "the numbers, all finite",
        ),
        key("snapshot.density_grid_size", Honoured, "128"),
        key(
            "snapshot.density_grid_binary",
            Honoured,
            "the occupancy, all finite",
        ),
        key("snapshot.aabb", Honoured, "as aabb_scale says"),
        key(
            "snapshot.render_aabb",
            Honoured,
            "the part of it that is shown",
        ),
        key("snapshot.render_aabb_to_local", Honoured, "the identity"),
        key(
            "snapshot.nerf.aabb_scale",
            Honoured,
            "a power of two up to 128",
        ),
        key(
            "snapshot.nerf.dataset.scale",
            Honoured,
            "from the world to the unit cube",
        ),
        key("snapshot.nerf.dataset.offset", Honoured, "the same"),
        key("snapshot.nerf.dataset.from_mitsuba", Honoured, "false"),
        key("snapshot.nerf.dataset.is_hdr", Honoured, "false"),
        key(
            "snapshot.nerf.dataset.n_extra_learnable_dims",
            Honoured,
            "0",
        ),
        key(
            "snapshot.nerf.*linear_colors*",
            Refused,
            "colours are those of training pictures, in sRGB; false is accepted",
        ),
        key(
            "snapshot.*linear_colors*",
            Refused,
            "colours are those of training pictures, in sRGB; false is accepted",
        ),
        key("snapshot.nerf.*activation*", Refused, ACTIVATIONS),
        key(
            "snapshot.*envmap*",
            Refused,
            "the background is one colour, given by a description",
        ),
        key(
            "snapshot.exposure",
            Listed,
            "of the viewer: colours are shown as they are trained",
        ),
        key(
            "snapshot.background_color",
            Listed,
            "of the viewer: a description's `background` counts",
        ),
        key("snapshot.camera", Listed, "of the viewer"),
        key("snapshot.up_dir", Listed, "of the viewer"),
        key("snapshot.sun_dir", Listed, "of the viewer"),
        key("snapshot.bounding_radius", Listed, "of the viewer"),
        key("snapshot.training_step", Listed, "of training"),
        key("snapshot.loss", Listed, "of training"),
        key("snapshot.optimizer", Listed, "of training"),
        key(
            "snapshot.distortion_map*",
            Listed,
            "of the cameras of training",
        ),
        key("snapshot.nerf.rgb", Listed, "of training"),
        key(
            "snapshot.nerf.cam_pos_offset",
            Listed,
            "of the cameras of training",
        ),
        key(
            "snapshot.nerf.cam_rot_offset",
            Listed,
            "of the cameras of training",
        ),
        key(
            "snapshot.nerf.extra_dims_opt",
            Listed,
            "of training, which learned none",
        ),
        key(
            "snapshot.nerf.dataset.*",
            Listed,
            "the pictures, cameras and lenses of training",
        ),
        key("envmap", Listed, "how one would be trained"),
        key("distortion_map", Listed, "how one would be trained"),
        key("loss", Listed, "of training"),
        key("optimizer", Listed, "of training"),
        key("parent", Listed, "of training"),
    ],
    others: Listed,
};
