//! The float renderer: the reference for fixed-point pictures.

mod exponential;
mod frame;
mod group;
mod lists;
mod order;
mod prepared;
mod spans;
mod splats;
#[cfg(test)]
mod tests;
mod tile;

use fearless_simd::Level;

use super::decisions::Decisions;
use super::error::RenderError;
use super::profile::{Extent, Profile};
use super::project::Projection;
use super::view::{Raster, Sorting, View, Work, fits};
use frame::Canvas;
use lists::Lists;
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_base::vectors::Vectors;
use potamoi_gaussians::Cloud;
use prepared::Prepared;
use splats::Splats;
use tile::Limits;

/// Options of the float renderer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FloatOptions {
    /// Background, linear RGB.
    pub background: [f32; 3],
    /// Whether to keep [`FloatFrame::stats`] and [`FloatFrame::decisions`].
    pub log_decisions: bool,
    /// Whether to compute [`FloatFrame::depth`].
    pub depth: bool,
    /// Optional parts of the work.
    pub work: Work,
    /// Vector instructions; those of the processor that are widest unless given. The bits are the
    /// same.
    pub vectors: Option<Vectors>,
}

/// Work of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FloatStats {
    /// Gaussians that the near plane culled.
    pub culled: u64,
    /// Gaussians that touch a tile.
    pub visible: u64,
    /// (tile, Gaussian) pairs.
    pub entries: u64,
    /// (pixel, entry) pairs whose pixel had not stopped: the exponentials that the hardware
    /// computes.
    pub exponentials: u64,
    /// Exponentials that a pixel's group called for. Pixels beyond the ellipse of the alpha threshold
    /// are skipped, except for the rest of a group of four.
    pub evaluated: u64,
    /// (pixel, entry) pairs that contributed to a pixel.
    pub drawn: u64,
    /// Pixels that terminated early.
    pub stopped: u64,
}

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FloatFrame {
    /// The picture, including the background.
    pub picture: Picture,
    /// Final transmittance per pixel, 1 where nothing was drawn.
    pub transmittance: Vec<f64>,
    /// Depth per pixel along the camera's axis, if requested: the weighted mean over the centres
    /// of its Gaussians; infinite where nothing was drawn.
    pub depth: Option<Vec<f64>>,
    /// Work, if requested.
    pub stats: Option<FloatStats>,
    /// Each skip and stop, if requested.
    pub decisions: Option<Decisions>,
}

/// Renders in 64-bit floats, tile by tile. The result depends on neither the number of threads, nor
/// the processor's vectors, nor the order of the Gaussians in the cloud.
///
/// # Errors
/// Those of [`View::new`], or the processor does not have the vectors that are asked for.
pub fn render_float(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    options: &FloatOptions,
) -> Result<FloatFrame, RenderError> {
    render(cloud, camera, profile, options, None)
}

/// As [`render_float`], but renders only the pixels of a mask; the others are background. Only
/// tiles with such pixels have entries.
///
/// # Errors
/// Those of [`render_float`], or the mask does not have the camera's size.
pub fn render_masked(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    options: &FloatOptions,
    only: &Mask,
) -> Result<FloatFrame, RenderError> {
    render(cloud, camera, profile, options, Some(only))
}

fn render(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    options: &FloatOptions,
    only: Option<&Mask>,
) -> Result<FloatFrame, RenderError> {
    let rules = options.work.rules(profile);
    let raster = Raster::of(camera)?;
    if let Some(mask) = only {
        mask_fits(raster.size, mask)?;
    }
    // A log counts entries of the profile's rule, and the rule of the ellipse tests each tile.
    if options.log_decisions || rules.extent == Extent::Ellipse {
        let view = View::by(cloud, camera, profile, &options.work)?;
        return of_view(&view, options, only);
    }
    let level = level(options)?;
    let projection = Projection::new(cloud, camera, &rules, options.work.degree);
    let prepared = Prepared::new(cloud, &projection, raster.grid());
    fits(prepared.pairs)?;
    let order = match options.work.sorting {
        Sorting::Never => order::as_stored(&prepared.depths),
        // What is in order stays so.
        Sorting::IfNeeded | Sorting::Always => {
            let index = |slot| prepared.splats.at(slot).index as usize;
            order::front_to_back(cloud, &prepared.depths, index)
        }
    };
    let parts = rayon::current_num_threads();
    let canvas = Canvas {
        raster,
        limits: Limits::new(&rules),
        pixel_centre: rules.pixel_centre,
        lists: Lists::new(&order, &prepared, raster.grid(), parts),
        splats: prepared.splats,
        depths: options.depth.then_some(prepared.depths),
        background: options.background.map(f64::from),
        only,
    };
    drop(order);
    Ok(canvas.render(level))
}

/// Checks that a mask has the size of a picture.
pub(super) fn mask_fits(size: [u32; 2], mask: &Mask) -> Result<(), RenderError> {
    if mask.size() == size {
        return Ok(());
    }
    Err(RenderError::Option {
        field: "mask",
        value: format!("{:?} pixels", mask.size()),
        expected: "a mask of the camera's size",
    })
}

/// The instructions to use.
fn level(options: &FloatOptions) -> Result<Level, RenderError> {
    let Some(vectors) = options.vectors else {
        return Ok(Level::new());
    };
    vectors.level().ok_or_else(|| RenderError::Option {
        field: "vectors",
        value: vectors.to_string(),
        expected: "vector instructions that this processor has",
    })
}

/// Renders a view in 64-bit floating point.
///
/// # Errors
/// The processor does not have the vectors that are asked for.
pub fn render_view(view: &View, options: &FloatOptions) -> Result<FloatFrame, RenderError> {
    of_view(view, options, None)
}

fn of_view(
    view: &View,
    options: &FloatOptions,
    only: Option<&Mask>,
) -> Result<FloatFrame, RenderError> {
    let level = level(options)?;
    let (first, ranks) = view.by_tile();
    let canvas = Canvas {
        raster: view.raster(),
        limits: Limits::new(view.rules()),
        pixel_centre: view.rules().pixel_centre,
        lists: vec![Lists::of_view(view, &first, &ranks)],
        splats: Splats::of_view(view),
        depths: options.depth.then(|| splats::depths_of_view(view)),
        background: options.background.map(f64::from),
        only,
    };
    if !options.log_decisions {
        return Ok(canvas.render(level));
    }
    Ok(canvas.logged(level, view, first))
}
