//! Energy, leakage and area of a unit's logic at the system's node: measured on netlists, estimated
//! by formulas, or measured and scaled by a ratio of formulas.

use potamoi_formats::config::Config;
use potamoi_synth::fit::{Fit, Ratio, Work};
use potamoi_synth::scaling::{self, Factors};
use potamoi_synth::{Power, PowerReport, SynthError, SynthReport, Synthesised, UnitKind};

use super::unit_source::{Base, Known, UnitSource};

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
#[derive(Debug, Clone, Copy)]
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

    /// Logic of a unit by formulas; of the gathering unit with all banks at work.
    pub(super) fn estimated(
        fit: &Fit,
        config: &Config,
        unit: UnitKind,
        factors: &Factors,
    ) -> Result<Self, SynthError> {
        let channels = config.gu.banks.into();
        let at = |busy| fit.estimate(config, unit, Work { busy, channels });
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

    /// Logic of a unit from the best source that is known, and the name of that source.
    ///
    /// # Errors
    /// Why there is none.
    pub(super) fn of(
        known: &Known<'_>,
        config: &Config,
        unit: UnitKind,
        factors: &Factors,
    ) -> Result<(Self, &'static str), String> {
        let formulas = || {
            let own = Self::estimated(known.fit, config, unit, factors);
            own.map_err(|why| why.to_string())
        };
        let composed = |base: &Base<'_>| match base {
            Base::Reported(base) => {
                let own = Self::measured(&base.report, unit);
                own.ok_or_else(|| format!("{unit}: the parameters lack its power or node"))
            }
            Base::Beside(base) => {
                let own = Self::estimated(known.fit, base, unit, factors);
                own.map_err(|why| why.to_string())
            }
        };
        match known.source(config, unit) {
            UnitSource::Synthesised(own) => match Self::measured(&own.report, unit) {
                Some(own) => Ok((own, "netlists of this configuration")),
                None => Ok((formulas()?, FORMULAS)),
            },
            UnitSource::Formulas => Ok((formulas()?, FORMULAS)),
            UnitSource::Composed(base, ratio) => Ok((composed(&base)?.times(&ratio), COMPOSED)),
            UnitSource::Unknown(why) if unit == UnitKind::Vector => {
                let own = Self::in_proportion(known.fit, config, known.reports);
                own.map(|own| (own, PROPORTION)).ok_or(why)
            }
            UnitSource::Unknown(why) => Err(why),
        }
    }

    /// Scaled by the ratio of two units.
    fn times(self, ratio: &Ratio) -> Self {
        Self {
            energy: UnitEnergy {
                rest_pj: self.energy.rest_pj * ratio.rest,
                work_pj: self.energy.work_pj * ratio.work,
            },
            leakage_nw: self.leakage_nw * ratio.leakage,
            area_um2: self.area_um2 * ratio.area,
        }
    }
}

/// Sources by name.
pub(super) const FORMULAS: &str = "formulas fitted to syntheses";
const COMPOSED: &str = "composed of the netlists of a unit and of the parts in which it differs";
const PROPORTION: &str =
    "netlists of a unit with another exponential, in the proportion of formulas";

pub(super) fn power_of(report: &SynthReport, unit: UnitKind) -> Option<&PowerReport> {
    match report.unit(unit)?.power.as_ref()? {
        Power::Estimated(power) => Some(power),
        Power::Absent { .. } => None,
    }
}
