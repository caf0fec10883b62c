//! Energy, leakage and area of a unit's logic at the system's node: measured on netlists, estimated
//! by formulas, or measured and scaled by a ratio of formulas.

use potamoi_formats::config::Config;
use potamoi_synth::fit::{Fit, Work};
use potamoi_synth::scaling::{self, Factors};
use potamoi_synth::{Power, PowerReport, SynthError, SynthReport, Synthesised, UnitKind};

/// The system's node in nanometres (paper, Sec. "Experimental Setup").
pub(super) const NODE_NM: u32 = 12;

/// Picojoules a cycle of a unit's logic: idle, and the excess at work.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnitEnergy {
    pub(super) rest_pj: f64,
    pub(super) work_pj: f64,
}

impl UnitEnergy {
    /// Energy as measured on netlists.
    pub(super) fn measured(report: &SynthReport, unit: UnitKind, factor: f64) -> Option<Self> {
        let power = power_of(report, unit)?;
        let figures = &power.with_glitches;
        let busy = power.activity.busy as f64 / power.activity.cycles.max(1) as f64;
        let rest = figures.rest_pj_a_cycle;
        (busy > 0.0).then(|| Self {
            rest_pj: rest * factor,
            work_pj: (figures.pj_a_cycle - rest) / busy * factor,
        })
    }

    pub(super) fn of(&self, cycles: u64, busy: u64) -> f64 {
        self.rest_pj * cycles as f64 + self.work_pj * busy as f64
    }
}

/// Logic of a unit at 12 nm.
pub(super) struct Logic {
    pub(super) energy: UnitEnergy,
    /// Leakage at its own node, in nanowatts.
    pub(super) leakage_nw: f64,
    pub(super) area_um2: f64,
}

impl Logic {
    /// Logic as measured on netlists; `None` where power or the node's scaling factors are not
    /// known.
    pub(super) fn measured(report: &SynthReport, unit: UnitKind) -> Option<Self> {
        let factors = scaling::logic(report.library.node_nm?, NODE_NM)?;
        Some(Self {
            energy: UnitEnergy::measured(report, unit, factors.energy)?,
            leakage_nw: power_of(report, unit)?.leakage_nw,
            area_um2: report.unit(unit)?.area_um2 * factors.area,
        })
    }

    /// Logic of a measured unit that differs in its exponential alone, scaled by the ratio that
    /// formulas give for the two exponentials in the paper's unit; `None` where no such unit is
    /// known. The ratio leaves out clock energy beside an exponential.
    pub(super) fn in_proportion(
        fit: &Fit,
        config: &Config,
        reports: &[Synthesised],
    ) -> Option<Self> {
        let with = |of: &Config| {
            let mut plain = Config::paper();
            plain.vu.exp = of.vu.exp.clone();
            let exp = &mut plain.vu.exp;
            exp.iterations_per_clock = 1;
            (exp.accumulator_bits, exp.constant_bits, exp.offset) = (None, None, None);
            plain
        };
        let alike = |r: &&Synthesised| {
            let mut other = config.clone();
            let clocks = other.vu.exp.iterations_per_clock;
            other.vu.exp = r.config.vu.exp.clone();
            r.config.vu.exp.iterations_per_clock == clocks && r.has(&other, UnitKind::Vector)
        };
        let (known, report) = reports.iter().filter(alike).find_map(|r| {
            Some((
                with(&r.config),
                Self::measured(&r.report, UnitKind::Vector)?,
            ))
        })?;
        let at = |of: &Config, busy| {
            fit.estimate(of, UnitKind::Vector, Work { busy, channels: 0 })
                .ok()
        };
        let own = with(config);
        let [rest, busy] = [0.0, 1.0].map(|b| Some([at(&own, b)?, at(&known, b)?]));
        let ([rest, rest_known], [busy, busy_known]) = (rest?, busy?);
        let work = [&busy, &busy_known].map(|e| e.with_glitches_pj);
        let idle = [&rest, &rest_known].map(|e| e.with_glitches_pj);
        Some(Self {
            energy: UnitEnergy {
                rest_pj: report.energy.rest_pj * idle[0] / idle[1],
                work_pj: report.energy.work_pj * (work[0] - idle[0]) / (work[1] - idle[1]),
            },
            leakage_nw: report.leakage_nw * rest.leakage_nw / rest_known.leakage_nw,
            area_um2: report.area_um2 * rest.area_um2 / rest_known.area_um2,
        })
    }

    /// Logic of the vector unit by formulas.
    pub(super) fn estimated(
        fit: &Fit,
        config: &Config,
        factors: &Factors,
    ) -> Result<Self, SynthError> {
        let at = |busy| fit.estimate(config, UnitKind::Vector, Work { busy, channels: 0 });
        let (rest, work) = (at(0.0)?, at(1.0)?);
        Ok(Self {
            energy: UnitEnergy {
                rest_pj: rest.with_glitches_pj * factors.energy,
                work_pj: (work.with_glitches_pj - rest.with_glitches_pj) * factors.energy,
            },
            leakage_nw: rest.leakage_nw,
            area_um2: rest.scaled(factors).area_um2,
        })
    }
}

pub(super) fn reached_ghz(report: &SynthReport) -> Option<f64> {
    let units = &report.scaled.as_ref()?.logic.as_ref()?.units;
    let slowest = units
        .iter()
        .map(|unit| unit.with_memories_ps.unwrap_or(unit.period_ps))
        .fold(0.0, f64::max);
    (slowest > 0.0).then(|| 1e3 / slowest)
}

pub(super) fn power_of(report: &SynthReport, unit: UnitKind) -> Option<&PowerReport> {
    match report.unit(unit)?.power.as_ref()? {
        Power::Estimated(power) => Some(power),
        Power::Absent { .. } => None,
    }
}
