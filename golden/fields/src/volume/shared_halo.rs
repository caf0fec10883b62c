//! Ray groups in MVoxels with a shared halo, where each MVoxel has all vertices of its cells.

use glam::DVec3;
use potamoi_march::{Batch, Compositor, FixedStats, MarchError, Next, RayGroup, Span, gather};
use potamoi_reference::{GatherTask, Units};

use super::schedule::{Group, Schedule};

/// The rays of a group in MVoxels with a shared halo, which are visited one distance at a time.
pub(super) struct SharedGroup<'a> {
    schedule: &'a Schedule<'a>,
    group: Group,
    /// Number of entries after which no more MVoxels join a batch.
    most: usize,
    /// Number of visited crossings.
    next: usize,
    tasks: Vec<GatherTask>,
}

impl<'a> SharedGroup<'a> {
    pub(super) fn new(schedule: &'a Schedule<'a>, pixels: &[[u32; 2]], most: usize) -> Self {
        Self {
            schedule,
            group: schedule.group(pixels),
            most,
            next: 0,
            tasks: vec![],
        }
    }
}

impl SharedGroup<'_> {
    /// Visits MVoxels for the rays that have not stopped: one at least, and further ones at its
    /// distance until there are enough entries.
    fn visit_next(&mut self, done: &Compositor<'_>, stats: &mut FixedStats, batch: &mut Batch) {
        let (schedule, group) = (self.schedule, &self.group);
        self.tasks.clear();
        batch.spans.clear();
        let rest = &group.crossings[self.next..];
        let distance = rest.first().map_or(0, |first| first.distance);
        let (mut entries, spans) = (0, &mut batch.spans);
        for same in rest.chunk_by(|a, b| a.mvoxel == b.mvoxel) {
            if same[0].distance != distance || entries as usize >= self.most {
                break;
            }
            self.next += same.len();
            let alive = same.iter().filter(|c| done.is_alive(c.ray));
            // A ray meets no two MVoxels at one distance.
            let each = |ray, _, _: &_, _| {
                match spans.last_mut() {
                    Some(span) if span.ray == ray => span.len += 1,
                    _ => spans.push(Span {
                        ray,
                        start: entries,
                        len: 1,
                    }),
                }
                entries += 1;
            };
            let visited = schedule.visit(group, same[0].mvoxel as usize, alive, each);
            if let Some((visit, task)) = visited {
                stats.count([&visit], schedule.mvoxels.unit_streams());
                self.tasks.extend(task);
            }
        }
    }
}

impl RayGroup for SharedGroup<'_> {
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
        if self.next >= self.group.crossings() {
            return Ok(Next::End);
        }
        self.visit_next(done, stats, batch);
        gather(units, &self.tasks, &mut batch.features)?;
        Ok(Next::Batch)
    }
}
