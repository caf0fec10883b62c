//! The one path of every ray-marched field through the units: ray group after ray group, batch
//! after batch, gathered, composited, written to pixels.
//!
//! Fields differ in the order in which samples are gathered ([`GatherOrder`]).

use glam::DVec3;
use potamoi_reference::Units;

use crate::compositor::Compositor;
use crate::counts::FixedStats;
use crate::error::MarchError;
use crate::frame::{FixedFrame, place};
use crate::groups::{default_group_side, groups};
use crate::setup::Setup;
use crate::shading::Head;
use crate::span::Span;
use crate::work::Work;

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
pub trait RayGroup {
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
    ) -> Result<Next, MarchError>;

    /// Called after a batch is composited, or after gathering completed no sample.
    fn after(&mut self, _done: &Compositor<'_>, _stats: &mut FixedStats) {}
}

/// The order in which the samples of a ray group are gathered.
pub trait GatherOrder {
    /// Starts the rays of the given pixels.
    fn start(&self, pixels: &[[u32; 2]]) -> Box<dyn RayGroup + '_>;
}

/// Renders a frame through the units. `head` computes opacity and colour from features. The
/// picture depends on neither ray groups, nor batches, nor the order.
///
/// # Errors
/// Those of the ray groups, or a unit fails in shading or compositing.
pub fn render(
    setup: &Setup<'_>,
    head: &dyn Head,
    order: &dyn GatherOrder,
    units: &mut dyn Units,
) -> Result<FixedFrame, MarchError> {
    let mut frame = FixedFrame::clear(setup.size);
    let mut work = Work::default();
    let mut batch = Batch::default();
    let side = setup.side.unwrap_or_else(default_group_side);
    for pixels in groups(setup.size, side, setup.only) {
        let mut group = order.start(&pixels);
        frame.stats.groups += 1;
        frame.stats.rays += pixels.len() as u64;
        frame.stats.samples += group.samples();
        let mut done = Compositor::new(head, setup, &group.directions());
        loop {
            match group.next(&done, units, &mut frame.stats, &mut batch)? {
                Next::End => break,
                Next::Waiting => {}
                Next::Batch => {
                    let features = std::mem::take(&mut batch.features);
                    done.run(features, &batch.spans, units, &mut work)?;
                }
            }
            group.after(&done, &mut frame.stats);
        }
        place(&mut frame, &pixels, &done, setup.background);
    }
    frame.stats.take(work);
    frame.leave_out(setup.only, setup.background);
    Ok(frame)
}
