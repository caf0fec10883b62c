//! The road that every ray-marched field takes through the units: ray group after ray group,
//! batch after batch, gathered, composited, placed.
//!
//! What differs from field to field is which samples a batch has and how they are gathered
//! ([`RayGroup`]).

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

/// A frame that is to be rendered.
#[derive(Debug, Clone, Copy)]
pub struct Setup<'a> {
    /// Pixels a row, and rows.
    pub size: [u32; 2],
    /// Pixels a side of a ray group, 1 or more; by default the largest whose rays are at most
    /// [`crate::GROUP_RAYS`].
    pub side: Option<u32>,
    /// The pixels that are rendered, the others being background; by default all.
    pub only: Option<&'a Mask>,
    /// Transmittance below which a ray stops; none stops by default.
    pub stop: Option<f64>,
    /// Linear RGB behind everything.
    pub background: [f32; 3],
}

/// Samples that are composited together, ray after ray.
#[derive(Debug, Default)]
pub struct Batch {
    /// Feature codes, [`Head::channels`] a sample.
    pub features: Vec<i16>,
    /// The samples of each ray, one span a ray at most.
    pub spans: Vec<Span>,
}

/// What a ray group did when asked for its next batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// The batch is to be composited.
    Batch,
    /// Something was gathered, and no sample is complete yet.
    Waiting,
    /// Nothing is left.
    End,
}

/// The rays of a group on their way through a field.
pub trait RayGroup<E> {
    /// Unit directions of the rays, in the world.
    fn directions(&self) -> Vec<DVec3>;

    /// Samples along all rays, gathered or not.
    fn samples(&self) -> u64;

    /// Gathers the next samples of the rays that go on, and counts what that moves. Each ray's
    /// samples come front to back.
    ///
    /// # Errors
    /// A unit that fails, or returns another number of features than was asked for.
    fn next(
        &mut self,
        done: &Compositor<'_>,
        units: &mut dyn Units,
        stats: &mut FixedStats,
        batch: &mut Batch,
    ) -> Result<Next, E>;

    /// Called once a batch is composited, or nothing was complete.
    fn after(&mut self, _done: &Compositor<'_>, _stats: &mut FixedStats) {}
}

/// Renders a frame through the units. `start` makes the ray group of some pixels; `head` makes
/// opacity and colour of its features. The picture depends neither on ray groups nor on batches.
///
/// # Errors
/// Those of the ray groups, and a unit that fails in shading or compositing.
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
