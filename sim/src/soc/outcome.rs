//! What a path takes on a variant of the system.

use std::collections::BTreeMap;

use serde::Serialize;
use thiserror::Error;

use super::compose::{Composer, Spent};
use super::costs::{CostError, Costs};
use super::engine::{self, EngineError, Job, JobId, Resource, Times};
use super::memory::Memory;
use super::system::System;
use super::variant::{Frames, Gathering, Scenario, Variant};
use super::work::{FrameWork, PathWork, Quality};

/// A path that could not be modelled.
#[derive(Debug, Error)]
pub enum ModelError {
    /// Energy that is not known.
    #[error(transparent)]
    Cost(#[from] CostError),
    /// Jobs that cannot be run.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

/// Nanoseconds of a stage, a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct StageTime {
    /// At work.
    pub own_ns: f64,
    /// Its own work done, waiting for its bytes.
    pub memory_ns: f64,
    /// Ready, waiting for its resource.
    pub waiting_ns: f64,
}

/// Millijoules a frame, of the device.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct EnergyByPart {
    /// The GPU, at work and idle.
    pub gpu_mj: f64,
    /// The gathering unit with its memories.
    pub gathering_unit_mj: f64,
    /// The vector unit.
    pub vector_unit_mj: f64,
    /// The MAC array.
    pub array_mj: f64,
    /// Feature and weight buffers.
    pub buffers_mj: f64,
    /// Memory: accesses.
    pub memory_mj: f64,
    /// Memory: standing by and refreshing.
    pub standby_mj: f64,
    /// Memories on chip and logic at rest.
    pub leakage_mj: f64,
    /// The link.
    pub link_mj: f64,
}

impl EnergyByPart {
    /// By name.
    #[must_use]
    pub const fn named(&self) -> [(&'static str, f64); 9] {
        [
            ("GPU", self.gpu_mj),
            ("gathering unit", self.gathering_unit_mj),
            ("vector unit", self.vector_unit_mj),
            ("MAC array", self.array_mj),
            ("buffers", self.buffers_mj),
            ("memory accesses", self.memory_mj),
            ("memory standing by", self.standby_mj),
            ("leakage", self.leakage_mj),
            ("link", self.link_mj),
        ]
    }

    /// All of it.
    #[must_use]
    pub fn total_mj(&self) -> f64 {
        self.named().iter().map(|(_, mj)| mj).sum()
    }
}

/// What a path takes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// The variant.
    pub variant: Variant,
    /// Where full frames are rendered.
    pub scenario: Scenario,
    /// Frames of the path.
    pub frames: usize,
    /// Nanoseconds until the last is shown.
    pub span_ns: f64,
    /// Frames a second.
    pub frames_per_second: f64,
    /// By stage, a frame.
    pub stages: BTreeMap<&'static str, StageTime>,
    /// Share of the span in which each resource works.
    pub utilisation: BTreeMap<Resource, f64>,
    /// Of the device, a frame.
    pub energy: EnergyByPart,
    /// What was moved and spent, of the whole path.
    pub spent: Spent,
    /// How like its frames are to others.
    pub quality: Quality,
}

/// What every variant runs on.
pub struct Model<'a> {
    /// The system.
    pub system: &'a System,
    /// Its memory.
    pub memory: &'a Memory,
    /// Energy of units.
    pub costs: &'a Costs,
    /// Cycles a nanosecond of the accelerator.
    pub clock_ghz: f64,
}

/// Jobs with their times.
pub type Timeline = Vec<(Job, Times)>;

impl Model<'_> {
    /// A path on a variant, and the jobs that it was.
    ///
    /// # Errors
    /// Energy that is not known.
    pub fn run(
        &self,
        path: &PathWork,
        variant: Variant,
        scenario: Scenario,
    ) -> Result<(Outcome, Timeline), ModelError> {
        let mut composer = Composer::new(self.system, self.memory, self.costs, self.clock_ghz);
        let frames = path.targets.len();
        match variant.frames {
            Frames::Full | Frames::Half => self.single(path, variant, scenario, &mut composer)?,
            Frames::Warped => self.warped(path, variant, scenario, &mut composer)?,
            Frames::Chained => self.chained(path, variant, scenario, &mut composer)?,
        }
        let quality = match variant.frames {
            Frames::Full => path.full_quality,
            Frames::Half => path.half_quality,
            Frames::Warped => path.warped_quality,
            Frames::Chained => path.chained_quality,
        };
        self.done(composer, variant, scenario, frames, quality)
    }

    /// One frame by itself.
    ///
    /// # Errors
    /// Energy that is not known.
    pub fn frame(&self, work: &FrameWork, gathering: Gathering) -> Result<Outcome, ModelError> {
        let mut composer = Composer::new(self.system, self.memory, self.costs, self.clock_ghz);
        composer.frame(work, gathering, &[], 0)?;
        let variant = Variant {
            name: "frame",
            frames: Frames::Full,
            gathering,
        };
        let done = self.done(composer, variant, Scenario::Local, 1, Quality::default());
        Ok(done?.0)
    }

    fn done(
        &self,
        composer: Composer<'_>,
        variant: Variant,
        scenario: Scenario,
        frames: usize,
        quality: Quality,
    ) -> Result<(Outcome, Timeline), ModelError> {
        let Composer { jobs, spent, .. } = composer;
        let times = engine::run(&jobs)?;
        let span_ns = times.iter().map(|t| t.end_ns).fold(0.0, f64::max);
        let mut stages: BTreeMap<&'static str, StageTime> = BTreeMap::new();
        let mut busy: BTreeMap<Resource, f64> = BTreeMap::new();
        for (job, at) in jobs.iter().zip(&times) {
            let stage = stages.entry(job.stage).or_default();
            stage.own_ns += (at.own_done_ns - at.begin_ns) / frames as f64;
            stage.memory_ns += (at.end_ns - at.own_done_ns) / frames as f64;
            stage.waiting_ns += (at.begin_ns - at.ready_ns) / frames as f64;
            *busy.entry(job.resource).or_default() += at.end_ns - at.begin_ns;
        }
        let energy = self.energy(&spent, &busy, span_ns, frames);
        let outcome = Outcome {
            variant,
            scenario,
            frames,
            span_ns,
            frames_per_second: frames as f64 / span_ns * 1e9,
            stages,
            utilisation: busy.iter().map(|(of, ns)| (*of, ns / span_ns)).collect(),
            energy,
            spent,
            quality,
        };
        Ok((outcome, jobs.into_iter().zip(times).collect()))
    }

    /// Each frame by itself, one after the other.
    fn single(
        &self,
        path: &PathWork,
        variant: Variant,
        scenario: Scenario,
        composer: &mut Composer<'_>,
    ) -> Result<(), ModelError> {
        let mut shown: Vec<JobId> = vec![];
        for number in 0..path.targets.len() {
            let (half, rank) = (variant.frames == Frames::Half, number as u64);
            let work = if half { &path.half } else { path.full(number) };
            let last = match scenario {
                Scenario::Local => composer.frame(work, variant.gathering, &shown, rank)?,
                Scenario::Remote => {
                    composer.remote(work, self.system.link_colour_bytes, &shown, rank)
                }
            };
            shown = vec![last];
            if half {
                let pixels = u64::from(path.size[0]) * u64::from(path.size[1]);
                shown = vec![composer.scale(pixels, &shown, rank)];
            }
        }
        Ok(())
    }

    /// References beside the targets of those before; a target begins when the one before it is
    /// shown, and a reference when its pose is known and one of two buffers is free.
    fn warped(
        &self,
        path: &PathWork,
        variant: Variant,
        scenario: Scenario,
        composer: &mut Composer<'_>,
    ) -> Result<(), ModelError> {
        let window = path.options.window.max(1) as usize;
        let sent = self.system.link_colour_bytes + self.system.link_depth_bytes;
        let mut shown: Vec<JobId> = vec![];
        let mut references: Vec<JobId> = vec![];
        for (number, target) in path.targets.iter().enumerate() {
            // A reference stands before the first target at which it may begin.
            while let Some((_, known)) = path.reference_frames.get(references.len())
                && *known <= number
            {
                let r = references.len();
                let mut after: Vec<JobId> = known
                    .checked_sub(1)
                    .map(|at| shown[at])
                    .into_iter()
                    .collect();
                // Its buffer is free when the last target of the one before the last is shown.
                if let Some(free) = r.checked_sub(2).map(|r| (r + 1) * window - 1)
                    && let Some(last) = shown.get(free)
                {
                    after.push(*last);
                }
                let rank = (r * window) as u64;
                let work = &path.references[r];
                let made = match scenario {
                    Scenario::Local => composer.frame(work, variant.gathering, &after, rank)?,
                    Scenario::Remote => composer.remote(work, sent, &after, rank),
                };
                references.push(made);
            }
            let own = references[(number / window).min(references.len() - 1)];
            let mut after: Vec<JobId> = shown.last().copied().into_iter().collect();
            after.push(own);
            let rank = number as u64;
            let last = match target.reference {
                None => own,
                Some(_) => {
                    let pixels = target.classes.pixels();
                    let warp = composer.warp(pixels, &after, rank);
                    match &target.work {
                        Some(work) => composer.frame(work, variant.gathering, &[warp], rank)?,
                        None => warp,
                    }
                }
            };
            shown.push(last);
        }
        Ok(())
    }

    /// Each frame from the one before.
    fn chained(
        &self,
        path: &PathWork,
        variant: Variant,
        scenario: Scenario,
        composer: &mut Composer<'_>,
    ) -> Result<(), ModelError> {
        let sent = self.system.link_colour_bytes + self.system.link_depth_bytes;
        let mut shown: Vec<JobId> = vec![];
        for (number, frame) in path.chained.iter().enumerate() {
            let rank = number as u64;
            let last = match (frame.reference, scenario) {
                (None, Scenario::Local) => {
                    composer.frame(path.full(number), variant.gathering, &shown, rank)?
                }
                (None, Scenario::Remote) => composer.remote(path.full(number), sent, &shown, rank),
                (Some(_), _) => {
                    let warp = composer.warp(frame.classes.pixels(), &shown, rank);
                    match &frame.work {
                        Some(work) => composer.frame(work, variant.gathering, &[warp], rank)?,
                        None => warp,
                    }
                }
            };
            shown = vec![last];
        }
        Ok(())
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
            standby_mj: mj(self.memory.standby_mw(open) * span_ns),
            leakage_mj: mj(self.costs.leakage_mw * span_ns),
            link_mj: mj(spent.link_bytes * self.system.link_nj_per_byte * 1e3),
        }
    }
}
