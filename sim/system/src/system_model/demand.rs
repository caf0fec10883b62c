//! A frame by its demands alone, without a schedule: the fastest estimate, and a bound on all
//! schedules.

use std::collections::BTreeMap;

use potamoi_gpu::Overlap;
use schemars::JsonSchema;
use serde::Serialize;

use super::at_bounds::AtBounds;
use super::job_scheduler::{Job, Resource, Shared};
use super::outcome::Model;
use super::parts::EnergyByPart;
use super::variant::Gathering;
use super::work::FrameWork;

/// A frame among many like it, where all resources and channels overlap wholly: its time is the
/// largest demand. No schedule of such frames is faster; dependencies, fill and room in buffers are
/// left out.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Demand {
    /// Nanoseconds of a frame.
    pub span_ns: f64,
    /// The resource or channel with the largest demand.
    pub bottleneck: &'static str,
    /// Nanoseconds of a frame if the units of the accelerator took no time.
    pub free_units_ns: f64,
    /// Energy of the device.
    pub energy: EnergyByPart,
}

impl AtBounds<Demand> {
    /// Energy in millijoules; `None` where a part is not known.
    #[must_use]
    pub fn total_mj(&self) -> Option<AtBounds<f64>> {
        let both = self.max.energy.total_mj().zip(self.sum.energy.total_mj());
        both.map(|(max, sum)| AtBounds { max, sum })
    }
}

/// Nanoseconds of a frame on each resource and channel, by name in reports.
fn demands(jobs: &[Job]) -> Vec<(&'static str, f64)> {
    let mut own: BTreeMap<Resource, f64> = BTreeMap::new();
    let mut through: BTreeMap<Shared, f64> = BTreeMap::new();
    for job in jobs {
        *own.entry(job.resource).or_default() += job.own_ns;
        for share in &job.shares {
            *through.entry(share.of).or_default() += share.ns;
        }
    }
    let own = own.into_iter().map(|(of, ns)| (of.name(), ns));
    let through = through.into_iter().map(|(of, ns)| (of.name(), ns));
    own.chain(through).collect()
}

fn largest(jobs: &[Job]) -> (&'static str, f64) {
    let all = demands(jobs).into_iter();
    all.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
}

impl Model<'_> {
    /// The demands of a frame at both bounds of the GPU's kernels.
    #[must_use]
    pub fn demand(&self, work: &FrameWork, gathering: Gathering) -> AtBounds<Demand> {
        let at = |overlap| {
            let mut composer = self.composer(overlap);
            composer.frame(work, gathering, &[], 0);
            let (jobs, spent) = (&composer.jobs, &composer.spent);
            let (bottleneck, span_ns) = largest(jobs);
            let free: Vec<Job> = jobs.iter().map(Job::with_free_units).collect();
            // A kernel is at work until its bytes are through.
            let gpu = jobs.iter().filter(|job| job.resource == Resource::Gpu);
            let at_work: f64 = gpu
                .map(|job| job.own_ns.max(job.alone_ns(Shared::Memory)))
                .sum();
            let busy = BTreeMap::from([(Resource::Gpu, at_work.min(span_ns))]);
            Demand {
                span_ns,
                bottleneck,
                free_units_ns: largest(&free).1,
                energy: self.energy(spent, &busy, span_ns, 1),
            }
        };
        AtBounds {
            max: at(Overlap::Whole),
            sum: at(Overlap::None),
        }
    }
}
