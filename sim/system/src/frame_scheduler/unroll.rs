//! Unrolls a path without losses or fallbacks to jobs and their dependencies.

use super::{FrameScheduler, Job, Outcome};

/// Lists the jobs of a path for an executor of dependencies. `list` gets a job, the jobs it depends
/// on as `list` named them, and its rank: of several ready jobs, the smallest rank begins first. A
/// frame's pose is known when the frame before it is shown.
///
/// Moments are ends of jobs, so a job is listed once all its dependencies are, references before
/// targets.
///
/// Returns the first frame that is never rendered with its reference, if there is one: the pose of
/// that reference is not known before the frame is shown.
pub(crate) fn unroll(
    mut frames: FrameScheduler<Option<usize>>,
    mut list: impl FnMut(Job, &[usize], u64) -> usize,
) -> Option<(usize, usize)> {
    // The first pose and the empty slots are there before all jobs.
    if !frames.is_over() {
        frames.pose(0, None);
    }
    loop {
        while let Some(job) = frames.ready().next() {
            frames.begin(job, None);
            let awaited = frames.awaited(job);
            let after: Vec<usize> = awaited.iter().filter_map(|(_, end)| *end).collect();
            let rank = frames.urgency(job).0 as u64;
            let end = list(job, &after, rank);
            frames.end(job, Some(end), Outcome::Right);
        }
        let next = frames.next_shown();
        if frames.show(None).is_none() {
            return (!frames.is_over()).then(|| (next, frames.reference_of(next)));
        }
        if !frames.is_over() {
            let end = frames.frame(next).finished.and_then(|(end, _)| end);
            frames.pose(next + 1, end);
        }
    }
}
