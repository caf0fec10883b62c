//! The renderer in the hardware's formats: every gather and every vector
//! operation goes through the units.

use potamoi_formats::fixed::{Format, Rounding};

use super::composite::{Compositor, Work};
use super::counts::FixedStats;
use super::error::VoxelError;
use super::float::STOP_BELOW;
use super::formats::{Formats, TRANSMITTANCE};
use super::grid::Grid;
use super::head::{Head, OpacityAlone, Stored};
use super::mvoxels::MVoxels;
use super::ray::{Placement, Rays};
use super::schedule::{Schedule, Skip};
use super::split;
use crate::streams::Visit;
use crate::tiling::Halo;
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_reference::{GatherTask, Units};

/// Format of the background.
pub const BACKGROUND: Format = Format::signed(3, 12);
/// Fraction bits of a finished pixel.
const PIXEL_BITS: u32 = 32;

/// How to render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedOptions {
    /// Voxel edges from sample to sample.
    pub step: f64,
    /// Whether rays stop.
    pub terminate: bool,
    /// Where, of stored voxels.
    pub stop_below: f64,
    /// Fraction bits of transmittances that are carried, of stored voxels.
    pub transmittance_bits: u32,
    /// Linear RGB behind everything, rounded to 12 fraction bits.
    pub background: [f32; 3],
    /// Pixels a side of a ray group; by default the largest whose rays are at
    /// most [`super::GROUP_RAYS`].
    pub group_side: Option<u32>,
    /// Which samples of opacity 0 are left out.
    pub skip: Skip,
    /// Entries after which no more MVoxels join a batch.
    pub batch_entries: usize,
}

impl Default for FixedOptions {
    fn default() -> Self {
        Self {
            step: 0.5,
            terminate: true,
            stop_below: STOP_BELOW,
            transmittance_bits: TRANSMITTANCE.frac_bits(),
            background: [0.0; 3],
            group_side: None,
            skip: Skip::Cells,
            batch_entries: 1 << 18,
        }
    }
}

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedFrame {
    /// The picture, background included.
    pub picture: Picture,
    /// Transmittance left at each pixel, U1.20 codes.
    pub transmittance: Vec<u32>,
    /// Of each pixel, the samples that are gathered up to where its ray stops;
    /// `u32::MAX` where it does not. They depend neither on ray groups, nor on
    /// batches, nor on [`Halo`].
    pub stops: Vec<u32>,
    /// Counts.
    pub stats: FixedStats,
}

impl FixedFrame {
    /// Of so many pixels, nothing.
    pub fn clear([width, height]: [u32; 2]) -> Self {
        let pixels = width as usize * height as usize;
        Self {
            picture: Picture::filled(width, height, [0.0; 3]),
            transmittance: vec![0; pixels],
            stops: vec![u32::MAX; pixels],
            stats: FixedStats::default(),
        }
    }

    /// Shows nothing but background where a mask has no pixel.
    pub fn leave_out(&mut self, only: Option<&Mask>, background: [f32; 3]) {
        let Some(mask) = only else { return };
        let unit = 2f64.powi(-(BACKGROUND.frac_bits() as i32));
        let behind = background_codes(background).map(|code| (code as f64 * unit) as f32);
        for (i, colour) in self.picture.rgb.iter_mut().enumerate() {
            if !mask.has(i) {
                *colour = behind;
                self.transmittance[i] = 1 << TRANSMITTANCE.frac_bits();
            }
        }
    }
}

/// Renders a grid in the hardware's formats. `mvoxels` are the grid's. Sample
/// positions are found in floating point, as the GPU does, and rounded to 12
/// fraction bits; everything from there on goes through `units`, but for sums
/// of products (MAC array) and additions to a pixel. The picture depends neither
/// on ray groups, nor on batches, nor on [`Skip`], nor on [`Halo`].
///
/// # Errors
/// A camera or an option that is not sensible, MVoxels of another grid, a unit
/// that fails or returns another number of features than was asked for.
pub fn render_fixed(
    grid: &Grid,
    mvoxels: &MVoxels,
    camera: &Camera,
    options: &FixedOptions,
    units: &mut dyn Units,
) -> Result<FixedFrame, VoxelError> {
    let volume = Volume {
        mvoxels,
        placement: Placement::of(grid),
        head: &stored(grid, mvoxels, options)?,
    };
    render_volume(&volume, camera, options, units)
}

/// What makes opacity and colour of a grid that is sampled as options say.
pub fn stored(
    grid: &Grid,
    mvoxels: &MVoxels,
    options: &FixedOptions,
) -> Result<Stored, VoxelError> {
    Ok(Stored {
        layout: grid.layout(),
        formats: fits(grid, mvoxels)?,
        step: Formats::step_code(options.step),
        directions: true,
        transmittance_bits: options.transmittance_bits,
    })
}

/// [`FixedFrame::stops`] of a frame, for which no colour is computed.
///
/// # Errors
/// As [`render_fixed`].
pub fn stops(
    volume: &Volume<'_>,
    camera: &Camera,
    options: &FixedOptions,
    units: &mut dyn Units,
) -> Result<Vec<u32>, VoxelError> {
    let volume = Volume {
        head: &OpacityAlone(volume.head),
        ..*volume
    };
    Ok(render_volume(&volume, camera, options, units)?.stops)
}

/// A field in one volume of vertices.
pub struct Volume<'a> {
    /// Its MVoxels.
    pub mvoxels: &'a MVoxels,
    /// Where they lie.
    pub placement: Placement,
    /// What makes opacity and colour of their features.
    pub head: &'a dyn Head,
}

/// Renders a field in one volume in the hardware's formats, as [`render_fixed`]
/// does.
///
/// # Errors
/// As [`render_fixed`].
pub fn render_volume(
    volume: &Volume<'_>,
    camera: &Camera,
    options: &FixedOptions,
    units: &mut dyn Units,
) -> Result<FixedFrame, VoxelError> {
    render_volume_masked(volume, camera, options, None, units)
}

/// The same of some pixels, the others being background; their bits are those of the whole
/// frame.
///
/// # Errors
/// As [`render_fixed`], and for a mask of another size than the camera's.
pub fn render_volume_masked(
    volume: &Volume<'_>,
    camera: &Camera,
    options: &FixedOptions,
    only: Option<&Mask>,
    units: &mut dyn Units,
) -> Result<FixedFrame, VoxelError> {
    let Volume {
        mvoxels,
        placement,
        head,
    } = volume;
    let rays = check(placement, mvoxels, camera, options)?;
    if let Some(mask) = only
        && mask.size() != rays.size()
    {
        return Err(VoxelError::Option {
            field: "mask",
            value: format!("{:?} pixels", mask.size()),
            expected: "a mask of the camera's size",
        });
    }
    let mut frame = FixedFrame::clear(rays.size());
    let schedule = Schedule::new(mvoxels, rays, options.group_side, options.skip)?.of(only);
    let mut work = Work::default();
    for number in 0..schedule.groups() {
        let group = schedule.group(number);
        frame.stats.groups += 1;
        frame.stats.rays += group.rays.len() as u64;
        frame.stats.samples += Schedule::samples(&group);
        let mut done = Compositor::new(
            *head,
            options.terminate.then_some(options.stop_below),
            group.rays.iter().map(|ray| ray.towards),
        );
        let most = options.batch_entries;
        if mvoxels.halo() == Halo::Split {
            let stats = &mut frame.stats;
            split::run(&schedule, &group, most, &mut done, units, stats, &mut work)?;
            place(&mut frame, &group.pixels, &done, options.background);
            continue;
        }
        let (mut tasks, mut spans, mut features) = (Vec::new(), Vec::new(), Vec::new());
        let mut next = 0;
        while next < group.crossings() {
            let alive = |ray| done.is_alive(ray);
            next = schedule.batch(&group, next, most, alive, &mut tasks, &mut spans);
            gather(units, &tasks, &mut features)?;
            let visits: Vec<Visit> = tasks.iter().map(Visit::of).collect();
            frame.stats.count(&visits, mvoxels.unit_streams());
            done.run(&features, &spans, units, &mut work)?;
        }
        place(&mut frame, &group.pixels, &done, options.background);
    }
    frame.stats.take(work);
    frame.leave_out(only, options.background);
    Ok(frame)
}

/// The gathering tasks of a frame in the order in which they are visited, as if
/// no ray stopped early, up to `most` entries (the last task may exceed it).
///
/// # Errors
/// As [`render_fixed`], and for MVoxels whose halo is split.
pub fn tasks(
    grid: &Grid,
    mvoxels: &MVoxels,
    camera: &Camera,
    options: &FixedOptions,
    most: usize,
) -> Result<Vec<GatherTask>, VoxelError> {
    fits(grid, mvoxels)?;
    if mvoxels.halo() == Halo::Split {
        return Err(VoxelError::Option {
            field: "halo",
            value: "split".to_owned(),
            expected: "shared: not all of its entries are the gathering unit's",
        });
    }
    let rays = check(&Placement::of(grid), mvoxels, camera, options)?;
    let schedule = Schedule::new(mvoxels, rays, options.group_side, options.skip)?;
    let mut all = Vec::new();
    let mut entries = 0;
    for number in 0..schedule.groups() {
        let group = schedule.group(number);
        let (mut batch, mut spans) = (Vec::new(), Vec::new());
        let mut next = 0;
        while next < group.crossings() && entries < most {
            let left = most - entries;
            next = schedule.batch(&group, next, left, |_| true, &mut batch, &mut spans);
            entries += batch.iter().map(|t| t.entries.len()).sum::<usize>();
            all.append(&mut batch);
        }
    }
    Ok(all)
}

/// The formats of a grid's MVoxels, if they are that grid's.
fn fits(grid: &Grid, mvoxels: &MVoxels) -> Result<Formats, VoxelError> {
    let same = mvoxels.points() == grid.points() && mvoxels.channels() == grid.layout().channels();
    mvoxels
        .formats()
        .copied()
        .filter(|_| same)
        .ok_or_else(|| VoxelError::Option {
            field: "mvoxels",
            value: format!("{:?} x {}", mvoxels.points(), mvoxels.channels()),
            expected: "the MVoxels of the grid that is rendered",
        })
}

pub(super) fn check(
    placement: &Placement,
    mvoxels: &MVoxels,
    camera: &Camera,
    options: &FixedOptions,
) -> Result<Rays, VoxelError> {
    let option = |field, value: String, expected| {
        Err(VoxelError::Option {
            field,
            value,
            expected,
        })
    };
    if mvoxels.points() != placement.points {
        let value = format!("{:?}", mvoxels.points());
        return option(
            "mvoxels",
            value,
            "the MVoxels of the volume that is rendered",
        );
    }
    if options.batch_entries == 0 {
        return option("batch_entries", "0".to_owned(), "1 or more");
    }
    check_background(options.background)?;
    Rays::placed(placement, camera, options.step)
}

/// Whether the sums of pixels hold a background.
pub fn check_background(background: [f32; 3]) -> Result<(), VoxelError> {
    let fits = |v: &f32| v.is_finite() && v.abs() < 8.0;
    if background.iter().all(fits) {
        return Ok(());
    }
    Err(VoxelError::Option {
        field: "background",
        value: format!("{background:?}"),
        expected: "finite numbers below 8",
    })
}

/// Features of all entries of some tasks, as many as there must be, in their
/// order.
pub fn gather(
    units: &mut dyn Units,
    tasks: &[GatherTask],
    features: &mut Vec<i16>,
) -> Result<(), VoxelError> {
    features.clear();
    if tasks.is_empty() {
        return Ok(());
    }
    units.gather(tasks, features).map_err(VoxelError::Unit)?;
    let expected: usize = tasks.iter().map(|t| t.entries.len() * t.channels).sum();
    if features.len() != expected {
        return Err(VoxelError::Features {
            found: features.len(),
            expected,
        });
    }
    Ok(())
}

fn background_codes(background: [f32; 3]) -> [i64; 3] {
    background.map(|v| {
        let code = BACKGROUND.quantise(f64::from(v), Rounding::HalfEven);
        code.unwrap_or_default() as i64
    })
}

/// Puts what was composited at the pixels of its rays, over a background.
pub fn place(
    frame: &mut FixedFrame,
    pixels: &[[u32; 2]],
    done: &Compositor<'_>,
    background: [f32; 3],
) {
    let background = background_codes(background);
    let up = PIXEL_BITS - done.pixel_bits();
    let behind_up = PIXEL_BITS - BACKGROUND.frac_bits() - TRANSMITTANCE.frac_bits();
    for (slot, [x, y]) in pixels.iter().enumerate() {
        let to = (y * frame.picture.width + x) as usize;
        let left = done.transmittance[slot];
        // Never negative, at most 1.
        frame.transmittance[to] = left as u32;
        frame.stops[to] = done.stops[slot];
        for c in 0..3 {
            let behind = (i64::from(left) * background[c]) << behind_up;
            let sum = (done.sums[slot][c] << up) + behind;
            frame.picture.rgb[to][c] = (sum as f64 * 2f64.powi(-(PIXEL_BITS as i32))) as f32;
        }
    }
}
