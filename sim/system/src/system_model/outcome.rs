//! Results of a path on a variant of the system.

use std::collections::BTreeMap;

use serde::Serialize;

use super::buffers;
use super::compose::{Composer, Spent};
use super::costs::Costs;
use super::error::ModelError;
use super::frame_jobs::FrameJobs;
use super::job_scheduler::{self, Job, Resource, Shared, Times};
use super::memory::Memory;
use super::system::System;
use super::variant::{Frames, Gathering, Scenario, Variant};
use super::work::{FrameWork, PathReplay, PathWork, Quality};

/// Nanoseconds of a stage, averaged over frames.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct StageTime {
    /// At work.
    pub own_ns: f64,
    /// Own work done, transfers still under way on any shared channel.
    pub memory_ns: f64,
    /// The same, by the channel of the last transfer.
    pub last_through: LastThrough,
    /// Part of the stage was ready and waited for its resource.
    pub waiting_ns: f64,
}

/// Nanoseconds that jobs waited for transfers, by the channel of the last transfer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct LastThrough {
    /// Memory.
    pub memory_ns: f64,
    /// Interconnect of memory, GPU and accelerator.
    pub interconnect_ns: f64,
    /// Ports of the global feature buffer.
    pub feature_buffer_ns: f64,
    /// Port of the weight buffer.
    pub weight_buffer_ns: f64,
}

impl LastThrough {
    fn wait(&mut self, of: Shared, ns: f64) {
        *match of {
            Shared::Memory => &mut self.memory_ns,
            Shared::Interconnect => &mut self.interconnect_ns,
            Shared::Features(_) => &mut self.feature_buffer_ns,
            Shared::Weights => &mut self.weight_buffer_ns,
        } += ns;
    }

    /// Name of the channel with the longest wait.
    #[must_use]
    pub fn most(&self) -> &'static str {
        let all = [
            ("memory", self.memory_ns),
            ("interconnect", self.interconnect_ns),
            ("feature buffer", self.feature_buffer_ns),
            ("weight buffer", self.weight_buffer_ns),
        ];
        let most = |best: (_, f64), own: (_, f64)| if own.1 > best.1 { own } else { best };
        all.into_iter().fold(all[0], most).0
    }
}

/// Energy of the device by part, in millijoules a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct EnergyByPart {
    /// The GPU, at work and idle.
    pub gpu_mj: f64,
    /// The gathering unit with its memories.
    pub gathering_unit_mj: f64,
    /// Vector unit.
    pub vector_unit_mj: f64,
    /// MAC array.
    pub array_mj: f64,
    /// Feature and weight buffers.
    pub buffers_mj: f64,
    /// Memory accesses, without those of DMA descriptors.
    pub memory_mj: f64,
    /// DMA descriptors, read from memory.
    pub dma_mj: f64,
    /// The interconnect.
    pub interconnect_mj: f64,
    /// Standby and refresh of memory.
    pub standby_mj: f64,
    /// Leakage of on-chip memories, logic and the array.
    pub leakage_mj: f64,
    /// The link.
    pub link_mj: f64,
}

impl EnergyByPart {
    /// Parts by name.
    #[must_use]
    pub const fn named(&self) -> [(&'static str, f64); 11] {
        [
            ("GPU", self.gpu_mj),
            ("gathering unit", self.gathering_unit_mj),
            ("vector unit", self.vector_unit_mj),
            ("MAC array", self.array_mj),
            ("buffers", self.buffers_mj),
            ("memory accesses", self.memory_mj),
            ("DMA descriptors", self.dma_mj),
            ("interconnect", self.interconnect_mj),
            ("memory standing by", self.standby_mj),
            ("leakage", self.leakage_mj),
            ("link", self.link_mj),
        ]
    }

    /// Total energy in millijoules a frame.
    #[must_use]
    pub fn total_mj(&self) -> f64 {
        self.named().iter().map(|(_, mj)| mj).sum()
    }
}

/// Time and energy of jobs, for one frame or a path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Run {
    /// Frames.
    pub frames: usize,
    /// Nanoseconds until the last frame is shown.
    pub span_ns: f64,
    /// Frames a second.
    pub frames_per_second: f64,
    /// Time by stage, averaged over frames.
    pub stages: BTreeMap<&'static str, StageTime>,
    /// Utilisation of each resource, from 0 to 1.
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
    /// Energy of the remote GPU in millijoules a frame, at work and idle; not part of the device's.
    /// `None` where all frames are rendered locally.
    pub remote_mj: Option<f64>,
    /// Refreshes of all memory channels, over all frames.
    pub refreshes: u64,
    /// Bytes and energy of all frames.
    pub spent: Spent,
}

/// Result of a path on a variant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// The variant.
    pub variant: Variant,
    /// Where full frames are rendered.
    pub scenario: Scenario,
    /// Time and energy.
    #[serde(flatten)]
    pub run: Run,
    /// Quality of its frames.
    pub quality: Quality,
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
    /// Models a path on a variant. Returns its result and its jobs.
    ///
    /// # Errors
    /// An energy that is not known.
    pub fn run(
        &self,
        path: &PathWork,
        variant: Variant,
        scenario: Scenario,
    ) -> Result<(Outcome, Timeline), ModelError> {
        let composer = FrameJobs::new(self.composer(), path, variant, scenario).jobs()?;
        let quality = match variant.frames {
            Frames::Full => path.full_quality,
            Frames::Half => path.half_quality,
            Frames::Warped => path.warped_quality,
            Frames::Chained => path.chained_quality,
        };
        let (run, timeline) = self.done(composer, path.targets.len())?;
        let outcome = Outcome {
            variant,
            scenario,
            run,
            quality,
        };
        Ok((outcome, timeline))
    }

    /// Models a single frame.
    ///
    /// # Errors
    /// An energy that is not known.
    pub fn frame(&self, work: &FrameWork, gathering: Gathering) -> Result<Run, ModelError> {
        let mut composer = self.composer();
        composer.frame(work, gathering, &[], 0)?;
        Ok(self.done(composer, 1)?.0)
    }

    fn composer(&self) -> Composer<'_> {
        Composer::new(
            self.system,
            self.memory,
            self.costs,
            self.clock_ghz,
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
        }
        for (stage, waits) in waits {
            stages.entry(stage).or_default().waiting_ns = covered(waits) / frames as f64;
        }
        let shared_ns = |of| jobs.iter().map(|job| job.alone_ns(of)).sum::<f64>();
        let [features, weights] = buffers::bytes_a_ns(self.system, self.clock_ghz);
        let energy = self.energy(&spent, &busy, span_ns, frames);
        let remote_mj = busy.get(&Resource::Remote).map(|at_work| {
            let gpu = &self.system.remote;
            let microjoules = 1e-3 * (gpu.watts * at_work + gpu.idle_watts * (span_ns - at_work));
            microjoules * 1e-3 / frames as f64
        });
        let run = Run {
            frames,
            span_ns,
            frames_per_second: frames as f64 / span_ns * 1e9,
            stages,
            utilisation: busy.iter().map(|(of, ns)| (*of, ns / span_ns)).collect(),
            memory_utilisation: shared_ns(Shared::Memory) / span_ns,
            interconnect_utilisation: shared_ns(Shared::Interconnect) / span_ns,
            feature_buffer_utilisation: spent.feature_buffer_bytes / features / span_ns,
            weight_buffer_utilisation: spent.weight_buffer_bytes / weights / span_ns,
            energy,
            remote_mj,
            refreshes: self.memory.refreshes(span_ns),
            spent,
        };
        Ok((run, jobs.into_iter().zip(times).collect()))
    }

    fn energy(
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
            gpu_mj: mj((gpu.watts * at_work + gpu.idle_watts * (span_ns - at_work)) * 1e3),
            gathering_unit_mj: mj(on_chip.gathering_pj + on_chip.gathering_memories_pj),
            vector_unit_mj: mj(on_chip.vector_pj),
            array_mj: mj(on_chip.array_pj),
            buffers_mj: mj(on_chip.buffers_pj),
            memory_mj: mj(spent.memory_pj),
            dma_mj: mj(spent.descriptor_pj),
            interconnect_mj: mj(spent.interconnect_bytes * self.system.interconnect_pj_per_byte),
            standby_mj: mj(self.memory.standby_mw(open) * span_ns),
            leakage_mj: {
                let array_mw = self.costs.mac.leakage_mw * self.system.array().units() as f64;
                mj((self.costs.leakage_mw + array_mw) * span_ns)
            },
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
