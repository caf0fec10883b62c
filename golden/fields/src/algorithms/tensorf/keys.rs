//! Keys of TensoRF checkpoints, after the code that writes them (`TensorBase.get_kwargs`, `save`
//! and the `state_dict` of each model).

use potamoi_base::file_keys::Fate::{Honoured, Listed, Refused, Whole};
use potamoi_base::file_keys::{Format, key};

const OTHER: &str = "TensorVMSplit alone is read: train with model_name = TensorVMSplit";

/// Keys with the name of their dictionary.
pub static TENSORF: Format = Format {
    name: "TensoRF",
    files: "`[model] kind = \"tensorf\"`, `.th` of its authors' code, read as data. Numbers of tensors have to be finite.",
    keys: &[
        key("kwargs", Honoured, "settings that the model was made with"),
        key("state_dict", Honoured, "its numbers"),
        key("state_dict/plane_coef", Refused, OTHER),
        key("state_dict/line_coef", Refused, OTHER),
        key(
            "kwargs/contract*",
            Refused,
            "space is not contracted; False is accepted",
        ),
        key(
            "kwargs/ndc*",
            Refused,
            "scenes in normalised device coordinates are not rendered; 0 is accepted",
        ),
        key("alphaMask.shape", Honoured, "vertices of the mask"),
        key("alphaMask.mask", Honoured, "where something may be"),
        key("alphaMask.aabb", Honoured, "the mask's box"),
        key("kwargs/aabb", Honoured, "the box"),
        key("kwargs/gridSize", Honoured, "vertices along the axes"),
        key("kwargs/density_n_comp", Honoured, "components of density"),
        key(
            "kwargs/appearance_n_comp",
            Honoured,
            "components of appearance",
        ),
        key("kwargs/app_dim", Honoured, "features of appearance"),
        key("kwargs/density_shift", Honoured, "added to densities"),
        key("kwargs/distance_scale", Honoured, "what distances count"),
        key(
            "kwargs/rayMarch_weight_thres",
            Honoured,
            "weights below count for nothing",
        ),
        key("kwargs/fea2denseAct", Honoured, "softplus or relu"),
        key(
            "kwargs/near_far",
            Honoured,
            "where samples begin; they end at the box",
        ),
        key("kwargs/step_ratio", Honoured, "edges from sample to sample"),
        key("kwargs/shadingMode", Honoured, "MLP_Fea"),
        key(
            "kwargs/view_pe",
            Honoured,
            "rounds of sines and cosines of the direction",
        ),
        key("kwargs/fea_pe", Honoured, "the same of features"),
        key("kwargs/featureC", Honoured, "neurons of a layer"),
        key("kwargs/pos_pe", Listed, "of other shading modes"),
        key(
            "kwargs/alphaMask_thres",
            Listed,
            "of training: the mask is what follows from it",
        ),
        key("state_dict/density_plane.*", Whole, "planes of density"),
        key("state_dict/density_line.*", Whole, "lines of density"),
        key("state_dict/app_plane.*", Whole, "planes of appearance"),
        key("state_dict/app_line.*", Whole, "lines of appearance"),
        key(
            "state_dict/basis_mat.*",
            Whole,
            "the matrix from products to features, its weight alone",
        ),
        key(
            "state_dict/renderModule.mlp.*",
            Whole,
            "layers of the perceptron, weight and bias",
        ),
    ],
    others: Listed,
};
