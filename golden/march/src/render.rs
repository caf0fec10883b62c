//! The one path of every ray-marched field through the units: ray group after ray group, batch
//! after batch, gathered, composited, written to pixels.
//!
//! Fields differ in the samples of a batch and in how these are gathered ([`RayGroup`]).

use glam::DVec3;
use potamoi_base::mask::Mask;
use potamoi_reference::Units;

use crate::compositor::Compositor;
use crate::counts::FixedStats;
use crate::error::MarchError;
use crate::frame::{FixedFrame, place};
use crate::groups::{default_group_side, groups};
use crate::shading::Head;
use crate::span::Span;
use crate::work::Work;

/// Parameters of a frame.
#[derive(Debug, Clone, Copy)]
pub struct Setup<'a> {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Side of a ray group in pixels, at least 1; by default the largest with at most
    /// [`crate::GROUP_RAYS`] rays.
    pub side: Option<u32>,
    /// Pixels to render, the others being background; by default all.
    pub only: Option<&'a Mask>,
    /// Early-termination threshold (transmittance); by default no ray stops early.
    pub stop: Option<f64>,
    /// Background, linear RGB.
    pub background: [f32; 3],
}

/// Samples composited together, ray after ray.
#[derive(Debug, Default)]
pub struct Batch {
    /// Feature codes, [`Head::channels`] of them a sample.
    pub features: Vec<i16>,
    /// The samples of each ray, at most one span a ray.
    pub spans: Vec<Span>,
}

/// The outcome of [`RayGroup::next`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// The batch is ready for compositing.
    Batch,
    /// Samples were gathered, but none is complete yet.
    Waiting,
    /// No samples remain.
    End,
}

/// The rays of a group as they traverse a field.
pub trait RayGroup<E> {
    /// Unit directions of the rays in world coordinates.
    fn directions(&self) -> Vec<DVec3>;

    /// Samples along all rays, whether gathered or not.
    fn samples(&self) -> u64;

    /// Gathers the next samples of the rays that have not stopped, and counts the traffic. The
    /// samples of each ray come front to back.
    ///
    /// # Errors
    /// A unit fails, or returns a wrong number of features.
    fn next(
        &mut self,
        done: &Compositor<'_>,
        units: &mut dyn Units,
        stats: &mut FixedStats,
        batch: &mut Batch,
    ) -> Result<Next, E>;

    /// Called after a batch is composited, or after gathering completed no sample.
    fn after(&mut self, _done: &Compositor<'_>, _stats: &mut FixedStats) {}
}

/// Renders a frame through the units. `start` makes the ray group of the given pixels; `head`
/// computes opacity and colour from features. The picture depends on neither ray groups nor
/// batches.
///
/// # Errors
/// Those of the ray groups, or a unit fails in shading or compositing.
pub fn render<'g, E: From<MarchError>>(
    setup: &Setup<'_>,
    head: &dyn Head,
    mut start: impl FnMut(&[[u32; 2]]) -> Box<dyn RayGroup<E> + 'g>,
    units: &mut dyn Units,
) -> Result<FixedFrame, E> {
    let mut frame = FixedFrame::clear(setup.size);
    let mut work = Work::default();
    let mut batch = Batch::default();
    let side = setup.side.unwrap_or_else(default_group_side);
    for pixels in groups(setup.size, side, setup.only) {
        let mut group = start(&pixels);
        frame.stats.groups += 1;
        frame.stats.rays += pixels.len() as u64;
        frame.stats.samples += group.samples();
        let mut done = Compositor::new(head, setup.stop, group.directions().into_iter());
        loop {
            match group.next(&done, units, &mut frame.stats, &mut batch)? {
                Next::End => break,
                Next::Waiting => {}
                Next::Batch => done.run(&batch.features, &batch.spans, units, &mut work)?,
            }
            group.after(&done, &mut frame.stats);
        }
        place(&mut frame, &pixels, &done, setup.background);
    }
    frame.stats.take(work);
    frame.leave_out(setup.only, setup.background);
    Ok(frame)
}
