//! Keys of DirectVoxGO checkpoints, after the code that writes them (`DirectVoxGO.get_kwargs` and
//! its `state_dict`). The keys of `DirectMPIGO` and `DirectContractedVoxGO` are included and
//! refused.

use potamoi_base::file_keys::Fate::{Honoured, Listed, Refused, Whole};
use potamoi_base::file_keys::{Format, key};

const UNBOUNDED: &str = "models of unbounded scenes contract space, which is not rendered: train with \
                         DirectVoxGO's bounded model";
const IMAGES: &str = "multiplane images of forward-facing scenes are not rendered: train with \
                      DirectVoxGO's bounded model";
const IMPLICIT: &str = "colours come from the grid and the perceptron, not from places alone; False is \
                        accepted";

/// Keys with the name of their dictionary.
pub static DVGO: Format = Format {
    name: "DirectVoxGO",
    files: "`[model] kind = \"dvgo\"`, `.tar`: `fine_last.tar` of its authors' code, read as data. Numbers of tensors have to be \
            finite.",
    keys: &[
        key("global_step", Listed, "of training"),
        key("optimizer_state_dict*", Listed, "of training"),
        key(
            "model_kwargs",
            Honoured,
            "settings that the model was made with",
        ),
        key("model_state_dict", Honoured, "its numbers"),
        key("model_kwargs/scene_center", Refused, UNBOUNDED),
        key("model_kwargs/scene_radius", Refused, UNBOUNDED),
        key("model_kwargs/bg_len", Refused, UNBOUNDED),
        key("model_kwargs/contracted_norm", Refused, UNBOUNDED),
        key("model_kwargs/world_len", Refused, UNBOUNDED),
        key("model_state_dict/scene_center", Refused, UNBOUNDED),
        key("model_state_dict/scene_radius", Refused, UNBOUNDED),
        key("model_kwargs/mpi_depth", Refused, IMAGES),
        key("model_state_dict/act_shift.grid", Refused, IMAGES),
        key("model_kwargs/rgbnet_full_implicit", Refused, IMPLICIT),
        key("model_kwargs/density_type", Honoured, "DenseGrid"),
        key("model_kwargs/k0_type", Honoured, "DenseGrid"),
        key("model_kwargs/num_voxels", Honoured, "how long a step is"),
        key(
            "model_kwargs/voxel_size_ratio",
            Honoured,
            "how long a step counts",
        ),
        key(
            "model_kwargs/fast_color_thres",
            Honoured,
            "opacities below count for nothing; 0.0001 unless given",
        ),
        key("model_kwargs/rgbnet_direct", Honoured, "True"),
        key("model_kwargs/rgbnet_dim", Listed, "given by the tensors"),
        key("model_kwargs/rgbnet_depth", Listed, "given by the tensors"),
        key("model_kwargs/rgbnet_width", Listed, "given by the tensors"),
        key("model_kwargs/viewbase_pe", Listed, "given by the tensors"),
        key("model_kwargs/xyz_min", Listed, "given by the tensors"),
        key("model_kwargs/xyz_max", Listed, "given by the tensors"),
        key(
            "model_kwargs/density_config",
            Listed,
            "dense grids have none",
        ),
        key("model_kwargs/k0_config", Listed, "dense grids have none"),
        key("model_kwargs/num_voxels_base", Listed, "of training"),
        key(
            "model_kwargs/alpha_init",
            Listed,
            "of training: act_shift is what follows from it",
        ),
        key(
            "model_kwargs/mask_cache_*",
            Listed,
            "of training: the mask is a tensor",
        ),
        key(
            "model_state_dict/density.grid",
            Honoured,
            "densities, [1, 1, X, Y, Z]",
        ),
        key(
            "model_state_dict/k0.grid",
            Honoured,
            "features, [1, C, X, Y, Z]",
        ),
        key(
            "model_state_dict/xyz_min",
            Honoured,
            "the box, above 1e-6 along each axis",
        ),
        key("model_state_dict/xyz_max", Honoured, "the box"),
        key("model_state_dict/act_shift", Honoured, "added to densities"),
        key(
            "model_state_dict/viewfreq",
            Honoured,
            "factors of directions, 16 at most",
        ),
        key(
            "model_state_dict/rgbnet.*",
            Whole,
            "layers of the perceptron, weight and bias",
        ),
        key(
            "model_state_dict/mask_cache.mask",
            Honoured,
            "where something may be",
        ),
        key(
            "model_state_dict/mask_cache.xyz2ijk_*",
            Honoured,
            "where the mask is",
        ),
        key(
            "model_state_dict/mask_cache.*",
            Listed,
            "older masks are not used: more is computed, nothing else shown",
        ),
        key(
            "model_state_dict/*.xyz_min",
            Listed,
            "the model's own counts",
        ),
        key(
            "model_state_dict/*.xyz_max",
            Listed,
            "the model's own counts",
        ),
    ],
    others: Listed,
};
