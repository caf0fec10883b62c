//! A grid in 64-bit floating point: its rays are followed in its own vertices.

use super::field::{InVertices, STOP_BELOW};
use super::grid::Grid;
use super::ray::Rays;
use crate::march::{Frame, View, follow};
use crate::{Field as _, FieldFrame};
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_march::MarchError;

/// How to render in floating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FloatOptions {
    /// Voxel edges from sample to sample.
    pub step: f64,
    /// Whether rays stop.
    pub terminate: bool,
    /// Where.
    pub stop_below: f64,
    /// Linear RGB behind everything.
    pub background: [f32; 3],
    /// Whether colours that are linear in the direction are seen from it.
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

/// Renders a grid: `alpha = 1 - exp(-density step)` of the interpolated density
/// after its ReLU, front to back from where a ray enters the volume.
///
/// # Errors
/// A camera or a step that is not sensible.
pub fn render_float(
    grid: &Grid,
    camera: &Camera,
    options: &FloatOptions,
) -> Result<FieldFrame, MarchError> {
    render_masked(grid, camera, options, None)
}

/// As [`render_float`], but of a mask its pixels alone; the others are
/// background.
///
/// # Errors
/// As [`render_float`], and for a mask of another size than the camera's.
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
        frame: Frame {
            corner: grid.corner(),
            edge: grid.voxel(),
        },
    };
    Ok(follow(&field, &view, options.background, only))
}
