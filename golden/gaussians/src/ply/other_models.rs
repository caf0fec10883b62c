//! Properties of other models than 3D Gaussians. Files that have them are refused, since they
//! would render incorrectly.

use potamoi_base::file_keys::{Fate, Key};

/// Reason for refusing Gaussians that change with time.
const MOVES: &str = "Gaussians that move or change with time are not rendered; export one moment";
/// Reason for refusing more than three dimensions or colours.
const DIMENSIONS: &str =
    "3D Gaussians have three sizes, three colours and four numbers of a rotation; export those";
/// Reason for refusing other kernels.
const KERNEL: &str = "kernels that are no Gaussians are not rendered";
/// Reason for refusing a filter of another name.
const FILTER: &str = "the filter of Mip-Splatting is called filter_3D; rename it";

const fn refused(name: &'static str, about: &'static str) -> Key {
    Key {
        name,
        fate: Fate::Refused,
        about,
    }
}

/// Number of such properties.
const COUNT: usize = 21;
/// Keys of such properties.
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

/// The keys of a format of 3D Gaussians, followed by those of other models.
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
