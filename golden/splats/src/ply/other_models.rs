//! Properties of models that are no 3D Gaussians: without them such files would be rendered as if
//! they were.

use potamoi_base::record::{Fate, Key};

/// Why Gaussians that change with time are refused.
const MOVES: &str = "Gaussians that move or change with time are not rendered; export one moment";
/// Why what has more than three dimensions or colours is refused.
const DIMENSIONS: &str =
    "3D Gaussians have three sizes, three colours and four numbers of a rotation; export those";
/// Why other kernels are refused.
const KERNEL: &str = "kernels that are no Gaussians are not rendered";
/// Why a filter of another name is refused.
const FILTER: &str = "the filter of Mip-Splatting is called filter_3D; rename it";

const fn refused(name: &'static str, about: &'static str) -> Key {
    Key {
        name,
        fate: Fate::Refused,
        about,
    }
}

/// Their number.
const COUNT: usize = 21;
/// Their rows.
const OTHER_MODELS: [Key; COUNT] = [
    refused("t", MOVES),
    refused("time", MOVES),
    refused("lifetime", MOVES),
    refused("trbf_*", MOVES),
    refused("motion_*", MOVES),
    refused("omega_*", MOVES),
    refused("velocity_*", MOVES),
    refused("scale_t", MOVES),
    refused("t_scale*", MOVES),
    refused("temporal_*", MOVES),
    refused("deformation_*", MOVES),
    refused("rot_r_*", MOVES),
    refused("scale_3", DIMENSIONS),
    refused("rot_4", DIMENSIONS),
    refused("f_dc_3", DIMENSIONS),
    refused("beta", KERNEL),
    refused("sb_params_*", KERNEL),
    refused("shape", KERNEL),
    refused("nu_degree", KERNEL),
    refused("kernel_size", KERNEL),
    refused("filter_3d", FILTER),
];

/// The rows of a format of 3D Gaussians with those of other models behind them.
pub(crate) const fn with_other_models<const OWN: usize, const ALL: usize>(
    own: [Key; OWN],
) -> [Key; ALL] {
    assert!(OWN + COUNT == ALL, "the number of rows is another");
    let mut all = [OTHER_MODELS[0]; ALL];
    let mut at = 0;
    while at < ALL {
        all[at] = if at < OWN {
            own[at]
        } else {
            OTHER_MODELS[at - OWN]
        };
        at += 1;
    }
    all
}
