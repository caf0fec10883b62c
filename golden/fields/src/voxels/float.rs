//! The floating-point renderer of voxel grids, with rays in vertex units.

use super::field::{InVertices, STOP_BELOW};
use super::grid::Grid;
use super::ray::Rays;
use crate::float::{CoordinateFrame, View, follow};
use crate::{Field as _, FieldFrame};
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_march::MarchError;

/// Options of the floating-point renderer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FloatOptions {
    /// Step in voxel edges.
    pub step: f64,
    /// Whether rays terminate early.
    pub terminate: bool,
    /// Early-termination threshold (transmittance).
    pub stop_below: f64,
    /// Background, linear RGB.
    pub background: [f32; 3],
    /// Whether linear colours depend on the viewing direction.
    pub directions: bool,
}

impl Default for FloatOptions {
    fn default() -> Self {
        Self {
            step: 0.5,
            terminate: true,
            stop_below: STOP_BELOW,
            background: [0.0; 3],
            directions: true,
        }
    }
}

/// Renders a grid front to back from the entry of each ray into the volume: `alpha = 1 -
/// exp(-density step)`, with the interpolated density after its ReLU.
///
/// # Errors
/// The camera or the step is out of range.
pub fn render_float(
    grid: &Grid,
    camera: &Camera,
    options: &FloatOptions,
) -> Result<FieldFrame, MarchError> {
    render_masked(grid, camera, options, None)
}

/// As [`render_float`], but renders only the pixels of a mask; the others are background.
///
/// # Errors
/// Those of [`render_float`], or the mask does not have the camera's size.
pub fn render_masked(
    grid: &Grid,
    camera: &Camera,
    options: &FloatOptions,
    only: Option<&Mask>,
) -> Result<FieldFrame, MarchError> {
    let rays = Rays::new(grid, camera, options.step)?;
    if let Some(mask) = only.filter(|mask| mask.size() != rays.size()) {
        return Err(MarchError::Option {
            field: "mask",
            value: format!("{:?} pixels", mask.size()),
            expected: "a mask of the camera's size",
        });
    }
    let stop = if options.terminate {
        options.stop_below
    } else {
        0.0
    };
    let field = InVertices {
        grid,
        step: options.step,
        stop,
        directions: options.directions,
    };
    let view = View {
        camera,
        sampling: field.sampling(),
        frame: CoordinateFrame {
            corner: grid.corner(),
            edge: grid.voxel(),
        },
    };
    Ok(follow(&field, &view, options.background, only))
}
