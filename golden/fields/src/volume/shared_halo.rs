//! Ray groups in MVoxels with a shared halo, where each MVoxel has all vertices of its cells.

use glam::DVec3;
use potamoi_march::streams::Visit;
use potamoi_march::{Batch, Compositor, FixedStats, MarchError, Next, RayGroup, gather};
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
        let Self {
            schedule, group, ..
        } = self;
        if self.next >= group.crossings() {
            return Ok(Next::End);
        }
        let alive = |ray| done.is_alive(ray);
        let (tasks, spans) = (&mut self.tasks, &mut batch.spans);
        self.next = schedule.batch(group, self.next, self.most, alive, tasks, spans);
        gather(units, tasks, &mut batch.features)?;
        let visits: Vec<Visit> = tasks.iter().map(Visit::of).collect();
        stats.count(&visits, schedule.mvoxels.unit_streams());
        Ok(Next::Batch)
    }
}
