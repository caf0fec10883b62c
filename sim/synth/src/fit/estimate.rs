//! Estimates of a unit by formulas.

use schemars::JsonSchema;
use serde::Serialize;

use crate::grid::{GridActivity, GridPoint};
use crate::scaling::Factors;

/// Scene of the grid's gathering units and vertices of its samples: a field in voxels.
const VOXELS: (&str, u32) = ("lantern", 8);

/// Operating point of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Work {
    /// Share of cycles in which it issues, 0 to 1.
    pub busy: f64,
    /// Channels of a sample, for the gathering unit: banks without a channel do little.
    pub channels: u64,
}

impl Work {
    pub(super) fn of(activity: &GridActivity) -> Self {
        Self {
            busy: activity.busy as f64 / activity.cycles as f64,
            channels: activity.channels,
        }
    }
}

/// Workload of the grid's energies, on which formulas do not depend.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct EnergiesOf {
    /// Scene whose work drove the netlists.
    pub scene: String,
    /// Vertices of each sample for the gathering unit, where known.
    pub vertices: Option<u32>,
}

impl EnergiesOf {
    pub(super) fn new(activity: &GridActivity) -> Self {
        let (voxels, vertices) = VOXELS;
        let is_gathered = activity.channels > 0 && activity.scene == voxels;
        Self {
            scene: activity.scene.clone(),
            vertices: is_gathered.then_some(vertices),
        }
    }
}

/// Estimate of a unit at the node of the grid, without memories.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Estimate {
    /// Area in square micrometres.
    pub area_um2: f64,
    /// Longest path in picoseconds, before wires.
    pub period_ps: f64,
    /// Module of that path's end, or `outputs`.
    pub end: String,
    /// Operating point.
    pub work: Work,
    /// Energy of the flip-flops' clock pins, in picojoules a cycle.
    pub clock_pj: f64,
    /// Total energy in picojoules a cycle with zero delays: each net changes at most once a cycle.
    pub zero_delay_pj: f64,
    /// Total energy in picojoules a cycle with glitches.
    pub with_glitches_pj: f64,
    /// Leakage in nanowatts.
    pub leakage_nw: f64,
    /// Estimates by module.
    pub modules: Vec<EstimatedModule>,
    /// Numbers outside the grid's range, where formulas extrapolate.
    pub beyond: Vec<String>,
}

/// Estimate at another node. Leakage has no factor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct ScaledEstimate {
    /// Node in nanometres.
    pub node_nm: u32,
    /// Area in square micrometres.
    pub area_um2: f64,
    /// Longest path in picoseconds, before wires.
    pub period_ps: f64,
    /// Energy of the flip-flops' clock pins, in picojoules a cycle.
    pub clock_pj: f64,
    /// Total energy in picojoules a cycle with zero delays.
    pub zero_delay_pj: f64,
    /// Total energy in picojoules a cycle with glitches.
    pub with_glitches_pj: f64,
}

impl Estimate {
    /// Figures of a synthesised point; its energy above the clock's is attributed to its busy
    /// cycles.
    pub(super) fn of(point: &GridPoint, work: Work) -> Self {
        let clock_of_one = point.activity.clock_pj / point.flops() as f64;
        let busy = work.busy / Work::of(&point.activity).busy;
        let modules = point.modules.iter().map(|own| {
            let clock_pj = clock_of_one * (own.count * own.flops) as f64;
            let doing = |pj: f64| clock_pj + busy * (pj - clock_pj);
            EstimatedModule {
                module: own.module.clone(),
                count: own.count,
                area_um2: own.area_um2,
                clock_pj,
                zero_delay_pj: doing(own.energy.zero_delay_pj),
                with_glitches_pj: doing(own.energy.with_glitches_pj),
                leakage_nw: own.energy.leakage_nw,
            }
        });
        let ends = point.ends.iter();
        let longest = ends.max_by(|a, b| a.period_ps.total_cmp(&b.period_ps));
        let end = longest.map_or_else(String::new, |end| end.end.clone());
        Self::sum(modules.collect(), (end, point.period_ps), work)
    }

    /// Scales the energy above the clock's by the ratio of two estimates, module by module.
    pub(super) fn times(mut self, now: &Self, before: &Self) -> Self {
        let above = |of: &Self, name: &str| {
            let found = of.modules.iter().find(|m| m.module == name);
            found.map(|m| {
                [
                    m.zero_delay_pj - m.clock_pj,
                    m.with_glitches_pj - m.clock_pj,
                ]
            })
        };
        let whole = |of: &Self| {
            [
                of.zero_delay_pj - of.clock_pj,
                of.with_glitches_pj - of.clock_pj,
            ]
        };
        for module in &mut self.modules {
            let pair = above(now, &module.module).zip(above(before, &module.module));
            let (now, before) = pair.unwrap_or_else(|| (whole(now), whole(before)));
            let ratio = |i: usize| {
                if before[i] > 0.0 {
                    now[i] / before[i]
                } else {
                    1.0
                }
            };
            let clock = module.clock_pj;
            module.zero_delay_pj = clock + ratio(0) * (module.zero_delay_pj - clock);
            module.with_glitches_pj = clock + ratio(1) * (module.with_glitches_pj - clock);
        }
        Self::sum(self.modules, (self.end, self.period_ps), self.work)
    }

    /// Sums modules; `longest` is the longest path's end and picoseconds.
    pub(super) fn sum(
        modules: Vec<EstimatedModule>,
        (end, period_ps): (String, f64),
        work: Work,
    ) -> Self {
        let sum = |of: fn(&EstimatedModule) -> f64| modules.iter().map(of).sum();
        Self {
            area_um2: sum(|m| m.count as f64 * m.area_um2),
            period_ps,
            end,
            work,
            clock_pj: sum(|m| m.clock_pj),
            zero_delay_pj: sum(|m| m.zero_delay_pj),
            with_glitches_pj: sum(|m| m.with_glitches_pj),
            leakage_nw: sum(|m| m.leakage_nw),
            modules,
            beyond: vec![],
        }
    }

    /// Scales to the target node of the factors.
    #[must_use]
    pub fn scaled(&self, factors: &Factors) -> ScaledEstimate {
        ScaledEstimate {
            node_nm: factors.to_nm,
            area_um2: self.area_um2 * factors.area,
            period_ps: self.period_ps * factors.delay,
            clock_pj: self.clock_pj * factors.energy,
            zero_delay_pj: self.zero_delay_pj * factors.energy,
            with_glitches_pj: self.with_glitches_pj * factors.energy,
        }
    }
}

/// Estimate of all modules of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct EstimatedModule {
    /// Its name.
    pub module: String,
    /// Number of instances.
    pub count: u64,
    /// Area of one, in square micrometres.
    pub area_um2: f64,
    /// Clock energy of all instances, in picojoules a cycle.
    pub clock_pj: f64,
    /// Total energy of all instances with zero delays, in picojoules a cycle.
    pub zero_delay_pj: f64,
    /// Total energy of all instances with glitches, in picojoules a cycle.
    pub with_glitches_pj: f64,
    /// Leakage of all instances, in nanowatts.
    pub leakage_nw: f64,
}
