//! All jobs of a path with what each comes after, where nothing is lost or refused.

use super::{FrameScheduler, Job, Outcome};

/// Lists the jobs of a path for an executor of dependencies. `list` is given a job, the jobs that
/// it comes after as `list` named them, and its rank: of what is ready at once, the smallest begins
/// first. A frame's pose is known when the frame before it is shown.
///
/// Moments are ends of jobs, so a job is listed as soon as all that it waits for is, references
/// before targets.
///
/// Gives the first frame that is never rendered and its reference, if there is such a frame: its
/// reference's pose is not known before it is shown.
///
/// # Errors
/// As `list`.
pub(crate) fn unroll<E>(
    mut frames: FrameScheduler<Option<usize>>,
    mut list: impl FnMut(Job, &[usize], u64) -> Result<usize, E>,
) -> Result<Option<(usize, usize)>, E> {
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
            let end = list(job, &after, rank)?;
            frames.end(job, Some(end), Outcome::Right);
        }
        let next = frames.next_shown();
        if frames.show(None).is_none() {
            let left = (!frames.is_over()).then(|| (next, frames.reference_of(next)));
            return Ok(left);
        }
        if !frames.is_over() {
            let end = frames.frame(next).finished.and_then(|(end, _)| end);
            frames.pose(next + 1, end);
        }
    }
}
