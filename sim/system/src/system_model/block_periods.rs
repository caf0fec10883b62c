//! Periods of the accelerator's blocks, each with its origin: as synthesised, by formulas, composed of
//! parts, or that of a memory.

use potamoi_formats::config::Config;
use potamoi_synth::fit::{Ratio, Work};
use potamoi_synth::{SYSTEM, SynthReport, Synthesised, UnitKind, scaling};
use schemars::JsonSchema;
use serde::Serialize;

use super::logic::NODE_NM;
use super::unit_source::{Base, Known, UnitSource};

/// Period of a block at the system's node.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BlockPeriod {
    /// Its name.
    pub block: String,
    /// Picoseconds with the margin for wires; `None` where it is not known.
    pub ps: Option<f64>,
    /// Origin of the period, or why it is not known.
    pub from: String,
    /// Whether it is estimated by formulas.
    pub is_estimated: bool,
    /// Root mean square error of an estimate, as a share, where it is known.
    pub error: Option<f64>,
    /// Whether nothing is known of it, and it is taken as the slowest that was synthesised.
    pub is_guess: bool,
}

impl BlockPeriod {
    /// Picoseconds with the error of the estimate; `None` where either is not known.
    pub(super) fn at_most_ps(&self) -> Option<f64> {
        match (self.is_guess, self.is_estimated) {
            (true, _) => None,
            (false, true) => Some(self.ps? * (1.0 + self.error?)),
            (false, false) => self.ps,
        }
    }
}

/// Parameters that periods come from.
pub(super) struct Periods<'a> {
    pub(super) known: &'a Known<'a>,
    /// Parameters of the memories around the units and of the array.
    pub(super) system: &'a SynthReport,
    /// Share that is added to periods of logic for wires.
    pub(super) wire_margin: f64,
}

/// A unit's period before the margin for wires.
struct Period {
    ps: f64,
    from: String,
    error: Option<f64>,
    is_estimated: bool,
    is_guess: bool,
}

impl Period {
    fn estimated(ps: f64, error: Option<f64>, from: &str) -> Self {
        Self {
            ps,
            from: from.to_owned(),
            error,
            is_estimated: true,
            is_guess: false,
        }
    }
}

/// Source of a composed period.
const COMPOSED: &str = "composed of the syntheses of a unit and of the ";

impl Periods<'_> {
    /// A unit with its memories: as synthesised, otherwise by formulas.
    pub(super) fn unit(&self, config: &Config, unit: UnitKind) -> BlockPeriod {
        let found = match self.known.source(config, unit) {
            UnitSource::Synthesised(own) => match self.synthesised(&own.report, unit) {
                Some(own) => return own,
                None => self.formulas(config, unit),
            },
            UnitSource::Formulas => self.formulas(config, unit),
            UnitSource::Composed(Base::Reported(base), ratio) => {
                let own = self.beside(base, unit, ratio);
                let own = own.ok_or_else(|| "the node of its parameters has no factors".to_owned());
                let error = Some(self.known.fit.composition_errors().period.rms);
                own.map(|ps| {
                    let from = format!("{COMPOSED}numbers in which it differs");
                    Period::estimated(ps, error, &from)
                })
            }
            UnitSource::Composed(Base::Beside(base), ratio) => {
                let own = self.formulas(&base, unit);
                let error = self.known.fit.composition_errors().period;
                let from = format!(
                    "{COMPOSED}parts in which it differs, rms error {:.1} % at {} combinations",
                    100.0 * error.rms,
                    error.points
                );
                own.map(|own| Period::estimated(own.ps * ratio.period, Some(error.rms), &from))
            }
            UnitSource::Unknown(why) => self.slowest(config, unit, why),
        };
        let block = unit.top().to_owned();
        match found {
            Ok(own) => BlockPeriod {
                block,
                ps: Some(own.ps * (1.0 + self.wire_margin)),
                from: own.from,
                is_estimated: own.is_estimated,
                error: own.error,
                is_guess: own.is_guess,
            },
            Err(why) => BlockPeriod {
                block,
                ps: None,
                from: why,
                is_estimated: true,
                error: None,
                is_guess: false,
            },
        }
    }

    /// Its period as synthesised, scaled to the system's node; paths from and to memories count
    /// where their access times are known.
    fn synthesised(&self, report: &SynthReport, unit: UnitKind) -> Option<BlockPeriod> {
        let factors = scaling::logic(report.library.node_nm?, NODE_NM)?;
        let own = report.unit(unit)?;
        let with_memories = own.with_memories.as_ref().map(|own| own.period_ps);
        let ps = with_memories.unwrap_or(own.period_ps).max(own.period_ps);
        let memories = match (with_memories.is_some(), own.memories.is_empty()) {
            (true, _) => ", with its memories' access times",
            (false, false) => ", without paths from and to its memories",
            (false, true) => "",
        };
        Some(BlockPeriod {
            block: unit.top().to_owned(),
            ps: Some(ps * factors.delay * (1.0 + self.wire_margin)),
            from: format!("synthesis in {}{memories}", report.library.name),
            is_estimated: false,
            error: None,
            is_guess: false,
        })
    }

    /// The period of the slowest unit that was synthesised, for one that nothing is known of: an
    /// unknown clock is no gain.
    fn slowest(&self, config: &Config, unit: UnitKind, why: String) -> Result<Period, String> {
        let reports = self.known.reports.iter();
        let reported = reports.filter_map(|own| self.synthesised(&own.report, unit)?.ps);
        let reported = reported.map(|ps| ps / (1.0 + self.wire_margin));
        let node = self.known.fit.grid().library.node_nm;
        let factors = node.and_then(|node| scaling::logic(node, NODE_NM));
        let beside = self.known.fit.slowest_ps(unit).zip(factors);
        let slower = match unit {
            UnitKind::Gathering => self.slower_by_memories(config).0,
            UnitKind::Vector | UnitKind::ArrayMac | UnitKind::Splat => 1.0,
        };
        let beside = beside.map(|(ps, factors)| ps * factors.delay * slower);
        let ps = reported.chain(beside).reduce(f64::max).ok_or(&why)?;
        let from = format!("not known, taken as the slowest that was synthesised: {why}");
        Ok(Period {
            is_guess: true,
            ..Period::estimated(ps, None, &from)
        })
    }

    /// Picoseconds of a unit in a ratio to a synthesised one, before the margin for wires.
    fn beside(&self, base: &Synthesised, unit: UnitKind, ratio: Ratio) -> Option<f64> {
        let own = self.synthesised(&base.report, unit)?.ps?;
        Some(own * ratio.period / (1.0 + self.wire_margin))
    }

    /// Its period before the margin for wires: as synthesised beside the formulas; by formulas, in
    /// their proportion to a synthesised unit where one differs in numbers alone; or why there is
    /// none.
    fn formulas(&self, config: &Config, unit: UnitKind) -> Result<Period, String> {
        let fit = self.known.fit;
        let grid = &fit.grid().library;
        let factors = (grid.node_nm).and_then(|node| scaling::logic(node, NODE_NM));
        let factors = factors.ok_or("the formulas are of a node without factors")?;
        let work = Work {
            busy: 1.0,
            channels: config.gu.banks.into(),
        };
        let estimate = fit.estimate(config, unit, work);
        let estimate = estimate.map_err(|error| error.to_string())?;
        let (slower, beside) = match unit {
            UnitKind::Gathering => self.slower_by_memories(config),
            UnitKind::Vector | UnitKind::ArrayMac | UnitKind::Splat => (1.0, String::new()),
        };
        let ps = estimate.period_ps * factors.delay * slower;
        let Ok(family) = fit.family(config, unit) else {
            return Ok(Period {
                ps,
                from: format!("synthesis in {}{beside}", grid.name),
                is_estimated: unit == UnitKind::Gathering,
                // Its memories' share is that of a unit that was synthesised, in another size.
                error: None,
                is_guess: false,
            });
        };
        let left_out = fit.left_out(family).map_err(|e| e.to_string())?;
        let rms = Some(left_out.period.rms);
        let error = format!(
            "formulas, rms error {:.1} % at held-out points",
            100.0 * left_out.period.rms
        );
        let mut alike = self.known.reports.iter();
        let alike = alike.find_map(|own| {
            let ratio = fit.ratio(config, &own.config, unit)?;
            self.beside(own, unit, ratio)
        });
        Ok(match alike {
            Some(ps) => {
                let from = format!("synthesis of other numbers, times {error}");
                Period::estimated(ps, rms, &from)
            }
            None => Period::estimated(ps, rms, &format!("{error}{beside}")),
        })
    }

    /// How much longer the period of the synthesised gathering unit that is as pipelined is with its
    /// memories' access times, as a ratio.
    fn slower_by_memories(&self, config: &Config) -> (f64, String) {
        let alike = self.known.reports.iter().filter(|known| {
            let own = &known.config;
            own.gu.pipelined == config.gu.pipelined && own.organisation() == config.organisation()
        });
        let ratio = alike.filter_map(|known| {
            let unit = known.report.unit(UnitKind::Gathering)?;
            Some(unit.with_memories.as_ref()?.period_ps / unit.period_ps)
        });
        match ratio.reduce(f64::max) {
            Some(ratio) => {
                let ratio = ratio.max(1.0);
                let text = format!(", times {ratio:.3} for its memories as in a synthesised unit");
                (ratio, text)
            }
            None => (1.0, ", without its memories".to_owned()),
        }
    }

    pub(super) fn array(&self) -> BlockPeriod {
        let own = self.synthesised(self.system, UnitKind::ArrayMac);
        own.unwrap_or_else(|| BlockPeriod {
            block: UnitKind::ArrayMac.top().to_owned(),
            ps: None,
            from: "the parameters lack it".to_owned(),
            is_estimated: true,
            error: None,
            is_guess: false,
        })
    }

    /// Cycle times of memories; those of the units are the paper's where the configuration's own
    /// were not modelled.
    pub(super) fn memories(&self, config: &Config) -> Vec<BlockPeriod> {
        let gathering = UnitKind::Gathering;
        let own = (self.known.reports.iter()).find(|own| own.has(config, gathering));
        let (units, of) = match own.map(|own| &own.report) {
            Some(report) if report.raw.memories.is_some() => (report, ""),
            _ => (self.system, ", of the preset `paper`"),
        };
        let periods = |report: &SynthReport, owner: &'static str, of: &str| {
            let raw = report.raw.memories.iter().flat_map(|all| &all.macros);
            let own: Vec<_> = (raw.filter(|own| own.of == owner))
                .map(|own| (own.memory.clone(), own.figures.cycle_ps))
                .collect();
            let node = report.raw.memories.as_ref().map(|all| all.origin.node_nm);
            let factor = node.and_then(|node| scaling::memory(node, NODE_NM));
            let of = of.to_owned();
            own.into_iter().map(move |(block, ps)| BlockPeriod {
                ps: factor.as_ref().map(|factor| ps * factor.delay),
                from: format!("cycle time by CACTI{of}"),
                is_estimated: false,
                error: None,
                is_guess: false,
                block,
            })
        };
        let splat = UnitKind::Splat;
        let own = (self.known.reports.iter())
            .find(|own| config.su.is_some() && own.has(config, splat))
            .map(|own| periods(&own.report, splat.top(), ""));
        let all = periods(units, gathering.top(), of).chain(own.into_iter().flatten());
        all.chain(periods(self.system, SYSTEM, "")).collect()
    }
}
