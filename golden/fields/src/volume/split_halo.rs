//! Ray groups in MVoxels with a split halo, where no vertex is stored twice.
//!
//! A sample whose vertices lie in several MVoxels has an entry in each
//! ([`Part`](crate::gather_plan::Part)), and waits until its sums are complete.
//!
//! MVoxels are visited by distance, as with a shared halo. A sample is complete after the farthest
//! of its MVoxels, but this order is not the order along a ray: near the camera a later sample can
//! be complete first. So a sample is composited once it and all samples before it on its ray are
//! complete. This is known before gathering, and a ray stops at exactly the same sample as on its
//! own.

use glam::DVec3;

use super::schedule::{Group, Schedule};
use potamoi_march::FixedStats;
use potamoi_march::MarchError;
use potamoi_march::{Batch, Compositor, Next, RayGroup, Span, gather};
use potamoi_reference::{GatherTask, Units};

/// A waiting sample: its number on the ray and the index of its sums.
#[derive(Debug, Clone, Copy)]
struct Waiting {
    k: u32,
    at: u32,
    /// Whether the sums are a finished feature.
    whole: bool,
}

/// The sample up to which a ray can be composited after all MVoxels up to a distance have been
/// visited.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ready {
    pub(super) distance: u32,
    end: u32,
    /// Number of gathered samples before `end`.
    pub(super) samples: u32,
}

/// Waiting samples of one ray group.
struct Pool {
    channels: usize,
    /// Sums of each waiting sample, `channels` side by side.
    sums: Vec<i64>,
    free: Vec<u32>,
    /// Waiting samples by ray, each list ordered by sample.
    waiting: Vec<Vec<Waiting>>,
}

impl Pool {
    /// The sums of a sample, 0 if it is new.
    fn sums(&mut self, ray: u32, k: u32, whole: bool) -> &mut [i64] {
        let list = &mut self.waiting[ray as usize];
        let at = match list.binary_search_by_key(&k, |w| w.k) {
            Ok(found) => list[found].at as usize,
            Err(place) => {
                let at = self.free.pop().unwrap_or_else(|| {
                    let at = self.sums.len() / self.channels;
                    self.sums.resize(self.sums.len() + self.channels, 0);
                    at as u32
                });
                list.insert(place, Waiting { k, at, whole });
                let at = at as usize * self.channels;
                self.sums[at..at + self.channels].fill(0);
                at / self.channels
            }
        };
        &mut self.sums[at * self.channels..][..self.channels]
    }

    /// Removes the first samples of a ray, those below `end`.
    fn take(&mut self, ray: u32, end: u32, mut each: impl FnMut(bool, &[i64])) -> u32 {
        let list = &mut self.waiting[ray as usize];
        let count = list.partition_point(|w| w.k < end);
        for w in list.drain(..count) {
            let at = w.at as usize * self.channels;
            each(w.whole, &self.sums[at..at + self.channels]);
            self.free.push(w.at);
        }
        count as u32
    }

    fn held(&self) -> u64 {
        (self.sums.len() / self.channels - self.free.len()) as u64
    }
}

/// The rays of a group in MVoxels with a split halo, which are visited one distance at a time.
pub(super) struct SplitGroup<'a> {
    schedule: &'a Schedule<'a>,
    group: Group,
    /// Number of entries after which a batch is gathered.
    most: usize,
    /// Number of visited crossings.
    next: usize,
    /// For each ray, in the order of distance.
    ready: Vec<Vec<Ready>>,
    pool: Pool,
    tasks: Vec<GatherTask>,
    /// Ray and sample of each entry.
    targets: Vec<(u32, u32)>,
    /// Rays of the MVoxels visited last.
    rays: Vec<u32>,
}

impl<'a> SplitGroup<'a> {
    pub(super) fn new(schedule: &'a Schedule<'a>, pixels: &[[u32; 2]], most: usize) -> Self {
        let group = schedule.group(pixels);
        Self {
            ready: ready(schedule, &group),
            pool: Pool {
                channels: schedule.mvoxels.channels(),
                sums: vec![],
                free: vec![],
                waiting: vec![vec![]; group.rays.len()],
            },
            schedule,
            group,
            most,
            next: 0,
            tasks: vec![],
            targets: vec![],
            rays: vec![],
        }
    }

    /// Gathers in the MVoxels of the next distance, for the rays that have not stopped.
    fn visit_next(
        &mut self,
        done: &Compositor<'_>,
        units: &mut dyn Units,
        stats: &mut FixedStats,
    ) -> Result<u32, MarchError> {
        let (schedule, group) = (self.schedule, &self.group);
        let shape = schedule.mvoxels.shape();
        let exact = shape.exact_sums;
        let rest = &group.crossings[self.next..];
        let distance = rest.first().map_or(0, |first| first.distance);
        let same = &rest[..rest.partition_point(|c| c.distance == distance)];
        let (tasks, targets, pool) = (&mut self.tasks, &mut self.targets, &mut self.pool);
        for mvoxel in same.chunk_by(|a, b| a.mvoxel == b.mvoxel) {
            let alive = mvoxel.iter().filter(|c| done.is_alive(c.ray));
            let number = mvoxel[0].mvoxel as usize;
            let rows = schedule.mvoxels.rows(number);
            let visited = schedule.visit(group, number, alive, |ray, k, part, is_gathered| {
                if is_gathered {
                    targets.push((ray, k));
                } else {
                    part.add_to(pool.sums(ray, k, false), rows, shape);
                }
            });
            if let Some((visit, task)) = visited {
                stats.count([&visit], schedule.mvoxels.unit_streams());
                tasks.extend(task);
            }
            if targets.len() >= self.most {
                settle(units, tasks, targets, pool, exact)?;
            }
        }
        settle(units, tasks, targets, pool, exact)?;
        self.next += same.len();
        self.rays.clear();
        self.rays.extend(same.iter().map(|c| c.ray));
        self.rays.sort_unstable();
        self.rays.dedup();
        Ok(distance)
    }
}

impl RayGroup for SplitGroup<'_> {
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
        let distance = self.visit_next(done, units, stats)?;
        let reducer = &self.schedule.mvoxels.shape().reducer;
        let Batch { features, spans } = batch;
        features.clear();
        spans.clear();
        let mut start = 0;
        for ray in self.rays.iter().copied().filter(|ray| done.is_alive(*ray)) {
            let list = &self.ready[ray as usize];
            let past = list.partition_point(|r| r.distance <= distance);
            let Some(last) = past.checked_sub(1).and_then(|i| list.get(i)) else {
                continue;
            };
            let len = self.pool.take(ray, last.end, |whole, sums| {
                features.extend(sums.iter().map(|s| match whole {
                    // A feature code.
                    true => *s as i16,
                    false => reducer.round(*s),
                }));
            });
            if len > 0 {
                spans.push(Span { ray, start, len });
                start += len;
            }
        }
        Ok(match spans.is_empty() {
            true => Next::Waiting,
            false => Next::Batch,
        })
    }

    fn after(&mut self, done: &Compositor<'_>, stats: &mut FixedStats) {
        let ended = self.rays.iter().filter(|ray| !done.is_alive(**ray));
        for ray in ended {
            self.pool.take(*ray, u32::MAX, |_, _| ());
        }
        stats.waiting = stats.waiting.max(self.pool.held());
    }
}

/// For each ray, in the order of distance.
pub(super) fn ready(schedule: &Schedule<'_>, group: &Group) -> Vec<Vec<Ready>> {
    use rayon::prelude::*;
    let of = |ray: &super::ray::Ray| {
        let mut list: Vec<Ready> = vec![];
        let mut samples = 0;
        for k in 0..ray.samples {
            let Some(place) = schedule.place(ray, k) else {
                continue;
            };
            let holders = schedule.mvoxels.tiling().holders(&place);
            let own = holders.map(|h| schedule.distances[h.mvoxel]).max();
            let own = own.unwrap_or_default();
            samples += 1;
            match list.last_mut() {
                Some(last) if own <= last.distance => {
                    (last.end, last.samples) = (k + 1, samples);
                }
                _ => list.push(Ready {
                    distance: own,
                    end: k + 1,
                    samples,
                }),
            }
        }
        list
    };
    group.rays.par_iter().map(of).collect()
}

/// Gathers, and stores the features with their waiting samples.
fn settle(
    units: &mut dyn Units,
    tasks: &mut Vec<GatherTask>,
    targets: &mut Vec<(u32, u32)>,
    pool: &mut Pool,
    exact: bool,
) -> Result<(), MarchError> {
    if exact {
        let mut sums = vec![];
        units.sums(tasks, &mut sums).map_err(MarchError::Unit)?;
        for ((ray, k), own) in targets.iter().zip(sums.chunks_exact(pool.channels)) {
            let sums = pool.sums(*ray, *k, false);
            for (sum, part) in sums.iter_mut().zip(own) {
                *sum += i64::from(*part);
            }
        }
        tasks.clear();
        targets.clear();
        return Ok(());
    }
    let mut features = vec![];
    gather(units, tasks, &mut features)?;
    for ((ray, k), own) in targets.iter().zip(features.chunks_exact(pool.channels)) {
        let sums = pool.sums(*ray, *k, true);
        for (sum, code) in sums.iter_mut().zip(own) {
            *sum = i64::from(*code);
        }
    }
    tasks.clear();
    targets.clear();
    Ok(())
}
