//! The fixed-point renderer of voxel grids: every gather and every vector operation goes through
//! the units.

use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_march::streams::Visit;
use potamoi_march::tiling::Halo;
use potamoi_march::{
    self as march, Batch, Compositor, FixedFrame, FixedStats, Head, MarchError, Next, OpacityAlone,
    RayGroup, Setup, TRANSMITTANCE, check_background,
};
use potamoi_reference::{GatherTask, Units};

use super::field::STOP_BELOW;
use super::formats::Formats;
use super::grid::Grid;
use super::mvoxels::MVoxels;
use super::ray::{Placement, Rays};
use super::schedule::{Group, Schedule, Skip};
use super::shading::Stored;
use super::split_halo::SplitGroup;

/// Options of the fixed-point renderer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedOptions {
    /// Step in voxel edges.
    pub step: f64,
    /// Whether rays terminate early.
    pub terminate: bool,
    /// Early-termination threshold (transmittance) of stored voxels.
    pub stop_below: f64,
    /// Fraction bits of the transmittance of stored voxels.
    pub transmittance_bits: u32,
    /// Background, linear RGB, rounded to 12 fraction bits.
    pub background: [f32; 3],
    /// Side of a ray group in pixels; by default the largest with at most
    /// [`potamoi_march::GROUP_RAYS`] rays.
    pub group_side: Option<u32>,
    /// Samples of opacity 0 to skip.
    pub skip: Skip,
    /// Number of entries after which no more MVoxels join a batch.
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

/// Renders a grid in the hardware's formats. `mvoxels` must be those of the grid. Sample positions
/// are computed in floating point, as on the GPU, and rounded to 12 fraction bits. Everything else
/// goes through `units`, except sums of products (MAC array) and additions to a pixel. The picture
/// depends on none of ray groups, batches, [`Skip`] and [`Halo`].
///
/// # Errors
/// The camera or an option is out of range, the MVoxels are of another grid, or a unit fails or
/// returns a wrong number of features.
pub fn render_fixed(
    grid: &Grid,
    mvoxels: &MVoxels,
    camera: &Camera,
    options: &FixedOptions,
    units: &mut dyn Units,
) -> Result<FixedFrame, MarchError> {
    let volume = Volume {
        mvoxels,
        placement: Placement::of(grid),
        head: &stored(grid, mvoxels, options)?,
    };
    render_volume(&volume, camera, options, units)
}

/// The feature computation of a grid for the given options.
pub fn stored(
    grid: &Grid,
    mvoxels: &MVoxels,
    options: &FixedOptions,
) -> Result<Stored, MarchError> {
    Ok(Stored {
        layout: grid.layout(),
        formats: fits(grid, mvoxels)?,
        step: Formats::step_code(options.step),
        directions: true,
        transmittance_bits: options.transmittance_bits,
    })
}

/// [`FixedFrame::stops`] of a frame. No colour is computed.
///
/// # Errors
/// Those of [`render_fixed`].
pub fn stops(
    volume: &Volume<'_>,
    camera: &Camera,
    options: &FixedOptions,
    units: &mut dyn Units,
) -> Result<Vec<u32>, MarchError> {
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
    /// Their position in the world.
    pub placement: Placement,
    /// Computes opacity and colour from their features.
    pub head: &'a dyn Head,
}

/// Renders a field in one volume in the hardware's formats, as [`render_fixed`] does.
///
/// # Errors
/// Those of [`render_fixed`].
pub fn render_volume(
    volume: &Volume<'_>,
    camera: &Camera,
    options: &FixedOptions,
    units: &mut dyn Units,
) -> Result<FixedFrame, MarchError> {
    render_volume_masked(volume, camera, options, None, units)
}

/// As [`render_volume`], but renders only the pixels of a mask, bit for bit as in the whole frame;
/// the others are background.
///
/// # Errors
/// Those of [`render_fixed`], or the mask does not have the camera's size.
pub fn render_volume_masked(
    volume: &Volume<'_>,
    camera: &Camera,
    options: &FixedOptions,
    only: Option<&Mask>,
    units: &mut dyn Units,
) -> Result<FixedFrame, MarchError> {
    let Volume {
        mvoxels,
        placement,
        head,
    } = volume;
    let rays = check(placement, mvoxels, camera, options)?;
    if let Some(mask) = only
        && mask.size() != rays.size()
    {
        return Err(MarchError::Option {
            field: "mask",
            value: format!("{:?} pixels", mask.size()),
            expected: "a mask of the camera's size",
        });
    }
    let setup = Setup {
        size: rays.size(),
        side: options.group_side,
        only,
        stop: options.terminate.then_some(options.stop_below),
        background: options.background,
    };
    let schedule = Schedule::new(mvoxels, rays, options.group_side, options.skip)?;
    let most = options.batch_entries;
    march::render(
        &setup,
        *head,
        |pixels| match mvoxels.halo() {
            Halo::Split => {
                Box::new(SplitGroup::new(&schedule, pixels, most)) as Box<dyn RayGroup<_>>
            }
            Halo::Shared => Box::new(SharedGroup::new(&schedule, pixels, most)),
        },
        units,
    )
}

/// The rays of a group in MVoxels with a shared halo, which are visited one distance at a time.
struct SharedGroup<'a> {
    schedule: &'a Schedule<'a>,
    group: Group,
    /// Number of entries after which no more MVoxels join a batch.
    most: usize,
    /// Number of visited crossings.
    next: usize,
    tasks: Vec<GatherTask>,
}

impl<'a> SharedGroup<'a> {
    fn new(schedule: &'a Schedule<'a>, pixels: &[[u32; 2]], most: usize) -> Self {
        Self {
            schedule,
            group: schedule.group(pixels),
            most,
            next: 0,
            tasks: vec![],
        }
    }
}

impl RayGroup<MarchError> for SharedGroup<'_> {
    fn directions(&self) -> Vec<DVec3> {
        self.group.directions()
    }

    fn samples(&self) -> u64 {
        self.group.samples()
    }

    fn next(
        &mut self,
        done: &Compositor<'_>,
        units: &mut dyn Units,
        stats: &mut FixedStats,
        batch: &mut Batch,
    ) -> Result<Next, MarchError> {
        let Self {
            schedule, group, ..
        } = self;
        if self.next >= group.crossings() {
            return Ok(Next::End);
        }
        let alive = |ray| done.is_alive(ray);
        let (tasks, spans) = (&mut self.tasks, &mut batch.spans);
        self.next = schedule.batch(group, self.next, self.most, alive, tasks, spans);
        march::gather(units, tasks, &mut batch.features)?;
        let visits: Vec<Visit> = tasks.iter().map(Visit::of).collect();
        stats.count(&visits, schedule.mvoxels.unit_streams());
        Ok(Next::Batch)
    }
}

/// The gathering tasks of a frame in visiting order, without early termination, up to `most`
/// entries (the last task may exceed it).
///
/// # Errors
/// Those of [`render_fixed`], or the MVoxels have a split halo.
pub fn tasks(
    grid: &Grid,
    mvoxels: &MVoxels,
    camera: &Camera,
    options: &FixedOptions,
    most: usize,
) -> Result<Vec<GatherTask>, MarchError> {
    fits(grid, mvoxels)?;
    if mvoxels.halo() == Halo::Split {
        return Err(MarchError::Option {
            field: "halo",
            value: "split".to_owned(),
            expected: "shared: not all of its entries are the gathering unit's",
        });
    }
    let rays = check(&Placement::of(grid), mvoxels, camera, options)?;
    let schedule = Schedule::new(mvoxels, rays, options.group_side, options.skip)?;
    let mut all = Vec::new();
    let mut entries = 0;
    for pixels in schedule.groups() {
        let group = schedule.group(&pixels);
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

/// The formats of the MVoxels; an error if they are not those of the grid.
fn fits(grid: &Grid, mvoxels: &MVoxels) -> Result<Formats, MarchError> {
    let same = mvoxels.points() == grid.points() && mvoxels.channels() == grid.layout().channels();
    mvoxels
        .formats()
        .copied()
        .filter(|_| same)
        .ok_or_else(|| MarchError::Option {
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
) -> Result<Rays, MarchError> {
    let option = |field, value: String, expected| {
        Err(MarchError::Option {
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
