//! Results of a path on a variant of the system.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use potamoi_gpu::Overlap;

use super::at_bounds::AtBounds;
use super::buffers;
use super::compose::Composer;
use super::costs::Costs;
use super::error::ModelError;
use super::frame_jobs::{self, FrameJobs};
use super::job_scheduler::{self, Job, Resource, Shared, Times};
use super::memory::Memory;
use super::parts::{EnergyByPart, StageTime};
use super::spent::Spent;
use super::system::System;
use super::variant::{Frames, Gathering, Scenario, Variant};
use super::work::{FrameWork, PathParts, PathReplay, PathWork, Quality};

/// Time and energy of jobs, for one frame or a path.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Run {
    /// Frames.
    pub frames: usize,
    /// Nanoseconds until the last frame is shown.
    pub span_ns: f64,
    /// Frames a second.
    pub frames_per_second: f64,
    /// Time by stage, averaged over frames.
    pub stages: BTreeMap<&'static str, StageTime>,
    /// Nanoseconds if the units of the accelerator took no time at all. No change of them gives
    /// more than this (Amdahl's law): what is left is the GPU's, the memory's and the link's.
    pub free_units_ns: f64,
    /// Share of the span that the own work of each resource needs, from 0 to 1; waits for transfers
    /// are none of it.
    pub demand: BTreeMap<Resource, f64>,
    /// Utilisation of each resource, waits for transfers included, from 0 to 1.
    pub utilisation: BTreeMap<Resource, f64>,
    /// Utilisation of memory: share of the span that its bytes need.
    pub memory_utilisation: f64,
    /// Utilisation of the interconnect: share of the span that its bytes need.
    pub interconnect_utilisation: f64,
    /// Utilisation of the feature buffer's ports: share of the span that its bytes need with all
    /// banks at work.
    pub feature_buffer_utilisation: f64,
    /// Utilisation of the weight buffer's port: share of the span that its bytes need.
    pub weight_buffer_utilisation: f64,
    /// Energy of the device, averaged over frames.
    pub energy: EnergyByPart,
    /// The part of memory's data lines in that of memory accesses and DMA descriptors, in
    /// millijoules a frame.
    pub memory_io_mj: f64,
    /// Energy of the remote GPU in millijoules a frame, at work and idle; not part of the device's.
    /// `None` where all frames are rendered locally.
    pub remote_mj: Option<f64>,
    /// Refreshes of all memory channels, over all frames.
    pub refreshes: u64,
    /// Bytes and energy of all frames.
    pub spent: Spent,
}

impl Run {
    /// The bottleneck: the resource or channel whose own work needs the largest share of the span,
    /// and that share.
    #[must_use]
    pub fn bottleneck(&self) -> (&'static str, f64) {
        let channels = [
            ("memory", self.memory_utilisation),
            ("interconnect", self.interconnect_utilisation),
            ("feature buffer", self.feature_buffer_utilisation),
            ("weight buffer", self.weight_buffer_utilisation),
        ];
        let own = self.demand.iter().map(|(of, share)| (of.name(), *share));
        let all = channels.into_iter().chain(own);
        all.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
    }
}

impl AtBounds<Run> {
    /// Nanoseconds until the last frame is shown.
    #[must_use]
    pub fn span_ns(&self) -> AtBounds<f64> {
        self.map(|run| run.span_ns)
    }

    /// Frames a second.
    #[must_use]
    pub fn frames_per_second(&self) -> AtBounds<f64> {
        self.map(|run| run.frames_per_second)
    }

    /// Energy of the device in millijoules a frame; `None` where a part is not known.
    #[must_use]
    pub fn total_mj(&self) -> Option<AtBounds<f64>> {
        let [max, sum] = [&self.max, &self.sum].map(|run| run.energy.total_mj());
        Some(AtBounds {
            max: max?,
            sum: sum?,
        })
    }
}

/// Result of a path on a variant.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Outcome {
    /// The variant.
    pub variant: Variant,
    /// Where full frames are rendered.
    pub scenario: Scenario,
    /// Time and energy at both bounds of the GPU's kernels.
    pub run: AtBounds<Run>,
    /// Quality of its frames, rendered in floating point.
    pub float_quality: Quality,
}

/// Model of the system that all variants share.
pub struct Model<'a> {
    /// The system.
    pub system: &'a System,
    /// Its memory.
    pub memory: &'a Memory,
    /// Energy of the units.
    pub costs: &'a Costs,
    /// Clock of the accelerator in gigahertz.
    pub clock_ghz: f64,
    /// Bytes of the weights of the scene's perceptrons.
    pub weight_bytes: u64,
    /// Memory rates of the frames' own access sequences; `None`: rates of sequential and random
    /// accesses.
    pub replay: Option<&'a PathReplay>,
}

/// Jobs with their timestamps.
pub type Timeline = Vec<(Job, Times)>;

impl Model<'_> {
    /// Models a path on a variant at both bounds. Returns its result, and its jobs where the
    /// demands of a GPU kernel overlap wholly.
    ///
    /// # Errors
    /// [`ModelError`]: a reference whose pose is known too late.
    pub fn run(
        &self,
        path: &PathWork,
        variant: Variant,
        scenario: Scenario,
    ) -> Result<(Outcome, Timeline), ModelError> {
        if path.options.parts == PathParts::FullFrames && variant.frames != Frames::Full {
            let variant = variant.name;
            return Err(ModelError::NotCounted { variant });
        }
        let at = |overlap| -> Result<(Run, Timeline), ModelError> {
            let composer = self.composer(overlap);
            let composer = FrameJobs::new(composer, path, variant, scenario).jobs()?;
            self.done(composer, path.targets.len())
        };
        let float_quality = match variant.frames {
            Frames::Full => path.full_quality,
            Frames::Half => path.half_quality,
            Frames::Warped => path.warped_quality,
            Frames::Chained => path.chained_quality,
        };
        let (max, timeline) = at(Overlap::Whole)?;
        let (sum, _) = at(Overlap::None)?;
        let outcome = Outcome {
            variant,
            scenario,
            run: AtBounds { max, sum },
            float_quality,
        };
        Ok((outcome, timeline))
    }

    /// Models a single frame at both bounds.
    ///
    /// # Errors
    /// As [`Model::run`].
    pub fn frame(
        &self,
        work: &FrameWork,
        gathering: Gathering,
    ) -> Result<AtBounds<Run>, ModelError> {
        let at = |overlap| -> Result<Run, ModelError> {
            let mut composer = self.composer(overlap);
            composer.frame(work, gathering, &[], 0);
            Ok(self.done(composer, 1)?.0)
        };
        Ok(AtBounds {
            max: at(Overlap::Whole)?,
            sum: at(Overlap::None)?,
        })
    }

    /// Models a frame that is rendered again and again, `frames` times, at both bounds: a path in which the
    /// camera stands still.
    ///
    /// # Errors
    /// As [`Model::run`].
    pub fn repeated(
        &self,
        work: &FrameWork,
        gathering: Gathering,
        frames: usize,
    ) -> Result<AtBounds<Run>, ModelError> {
        let at = |overlap| -> Result<Run, ModelError> {
            let composer = self.composer(overlap);
            let composer = frame_jobs::repeated(composer, (work, gathering), frames);
            Ok(self.done(composer, frames)?.0)
        };
        Ok(AtBounds {
            max: at(Overlap::Whole)?,
            sum: at(Overlap::None)?,
        })
    }

    pub(super) fn composer(&self, overlap: Overlap) -> Composer<'_> {
        Composer::new(
            self.system,
            self.memory,
            self.costs,
            (self.clock_ghz, overlap),
            self.weight_bytes,
            self.replay,
        )
    }

    fn done(&self, composer: Composer<'_>, frames: usize) -> Result<(Run, Timeline), ModelError> {
        let Composer { jobs, spent, .. } = composer;
        let times = job_scheduler::run(&jobs)?;
        let span_ns = times.iter().map(|t| t.end_ns).fold(0.0, f64::max);
        let mut stages: BTreeMap<&'static str, StageTime> = BTreeMap::new();
        let mut busy: BTreeMap<Resource, f64> = BTreeMap::new();
        let mut demand: BTreeMap<Resource, f64> = BTreeMap::new();
        let mut waits: BTreeMap<&'static str, Vec<(f64, f64)>> = BTreeMap::new();
        for (job, at) in jobs.iter().zip(&times) {
            let stage = stages.entry(job.stage).or_default();
            stage.own_ns += (at.own_done_ns - at.begin_ns) / frames as f64;
            let waited_ns = (at.end_ns - at.own_done_ns) / frames as f64;
            stage.memory_ns += waited_ns;
            let shares = job.shares.iter().zip(&at.through_ns);
            if let Some((last, _)) = shares.max_by(|a, b| a.1.total_cmp(b.1)) {
                stage.last_through.wait(last.of, waited_ns);
            }
            waits
                .entry(job.stage)
                .or_default()
                .push((at.ready_ns, at.begin_ns));
            *busy.entry(job.resource).or_default() += at.end_ns - at.begin_ns;
            *demand.entry(job.resource).or_default() += job.own_ns / span_ns;
        }
        for (stage, waits) in waits {
            stages.entry(stage).or_default().waiting_ns = covered(waits) / frames as f64;
        }
        let shared_ns = |of| jobs.iter().map(|job| job.alone_ns(of)).sum::<f64>();
        let [features, weights] = buffers::bytes_a_ns(self.system, self.clock_ghz);
        let energy = self.energy(&spent, &busy, span_ns, frames);
        let remote_mj = busy.get(&Resource::Remote).map(|at_work| {
            let gpu = &self.system.remote;
            let microjoules = 1e-3 * (gpu.watts() * at_work + gpu.idle_watts * (span_ns - at_work));
            microjoules * 1e-3 / frames as f64
        });
        let free: Vec<Job> = jobs.iter().map(Job::with_free_units).collect();
        let free = job_scheduler::run(&free)?;
        let free_units_ns = free.iter().map(|t| t.end_ns).fold(0.0, f64::max);
        let run = Run {
            frames,
            span_ns,
            frames_per_second: frames as f64 / span_ns * 1e9,
            stages,
            // Work that begins sooner may share memory worse.
            free_units_ns: free_units_ns.min(span_ns),
            demand,
            utilisation: busy.iter().map(|(of, ns)| (*of, ns / span_ns)).collect(),
            memory_utilisation: shared_ns(Shared::Memory) / span_ns,
            interconnect_utilisation: shared_ns(Shared::Interconnect) / span_ns,
            feature_buffer_utilisation: spent.feature_buffer_bytes / features / span_ns,
            weight_buffer_utilisation: spent.weight_buffer_bytes / weights / span_ns,
            energy,
            memory_io_mj: spent.memory_io_pj * 1e-9 / frames as f64,
            remote_mj,
            refreshes: self.memory.refreshes(span_ns),
            spent,
        };
        Ok((run, jobs.into_iter().zip(times).collect()))
    }

    /// Leakage of memories, units and array, in milliwatts.
    fn leakage_mw(&self) -> Option<f64> {
        let array_mw = self.costs.mac?.leakage_mw * self.system.array().units() as f64;
        Some(self.costs.leakage_mw? + array_mw)
    }

    /// Energy of frames by part; `busy` has the nanoseconds that resources are at work.
    pub(super) fn energy(
        &self,
        spent: &Spent,
        busy: &BTreeMap<Resource, f64>,
        span_ns: f64,
        frames: usize,
    ) -> EnergyByPart {
        let gpu = &self.system.gpu;
        let at_work = busy.get(&Resource::Gpu).copied().unwrap_or(0.0);
        // Rows are open while bytes are moved.
        let moved = spent.streamed_bytes + spent.written_bytes + spent.random_bytes;
        let open = (moved * self.memory.streamed().ns / span_ns).min(1.0);
        let on_chip = &spent.on_chip;
        // Watts times nanoseconds are nanojoules, milliwatts picojoules.
        let mj = |pj: f64| pj * 1e-9 / frames as f64;
        EnergyByPart {
            gpu_mj: mj((gpu.watts() * at_work + gpu.idle_watts * (span_ns - at_work)) * 1e3),
            gathering_unit_mj: on_chip
                .gathering_pj
                .zip(on_chip.gathering_memories_pj)
                .map(|(logic, memories)| mj(logic + memories)),
            vector_unit_mj: on_chip.vector_pj.map(mj),
            splat_units_mj: (self.costs.has_splat_units()).then(|| on_chip.splat_pj.map(mj)),
            array_mj: on_chip.array_pj.map(mj),
            buffers_mj: on_chip.buffers_pj.map(mj),
            memory_mj: mj(spent.memory_pj),
            dma_mj: mj(spent.descriptor_pj),
            interconnect_mj: mj(spent.interconnect_bytes * self.system.interconnect_pj_per_byte),
            standby_mj: mj(self.memory.standby_mw(open) * span_ns),
            leakage_mj: self.leakage_mw().map(|mw| mj(mw * span_ns)),
            link_mj: mj(spent.link_bytes * self.system.link_nj_per_byte * 1e3),
        }
    }
}

/// Nanoseconds covered by one span or more.
fn covered(mut spans: Vec<(f64, f64)>) -> f64 {
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut sum, mut until) = (0.0, f64::NEG_INFINITY);
    for (begin, end) in spans {
        sum += (end - begin.max(until)).max(0.0);
        until = until.max(end);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::covered;

    #[test]
    fn spans_that_overlap_count_once() {
        assert_eq!(covered(vec![]), 0.0);
        let spans = vec![(4.0, 6.0), (0.0, 2.0), (1.0, 3.0), (5.0, 5.5), (7.0, 7.0)];
        assert_eq!(covered(spans), 5.0);
    }
}
