//! Clock of the accelerator: one for all its blocks, as fast as the slowest of them allows.

use potamoi_formats::config::Config;
use potamoi_synth::fit::{Ratio, Work};
use potamoi_synth::{SYSTEM, SynthReport, Synthesised, UnitKind, scaling};
use serde::Serialize;

use super::logic::NODE_NM;
use super::unit_source::{Base, Known, UnitSource};

/// Clock of the accelerator, and the blocks that bound it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Clock {
    /// Gigahertz.
    pub ghz: f64,
    /// Origin of the clock.
    pub origin: ClockOrigin,
    /// Gigahertz that the slowest block reaches, whatever is assumed; `None` where the period of no
    /// block is known.
    pub reached_ghz: Option<f64>,
    /// Share that is added to periods of logic for wires, which synthesis leaves out.
    pub wire_margin: f64,
    /// The blocks, the slowest first, those of unknown period last.
    pub blocks: Vec<BlockPeriod>,
}

/// Origin of a clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClockOrigin {
    /// The longest period is of a block that was synthesised, or of a memory.
    Synthesised,
    /// The longest period is of formulas, or that of another block may be longer: it is not known, or
    /// is within its error.
    Estimated,
    /// The user assumes it.
    Assumed,
}

impl ClockOrigin {
    /// The word for tables.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Synthesised => "synthesised",
            Self::Estimated => "estimated",
            Self::Assumed => "assumed",
        }
    }
}

/// Period of a block at the system's node.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    fn at_most_ps(&self) -> Option<f64> {
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

impl Clock {
    /// The clock of a configuration's accelerator: the assumed one where the configuration has one,
    /// otherwise 1 over the longest period of gathering unit, vector unit, multiply-accumulate unit
    /// of the array, and the cycle times of all memories.
    #[must_use]
    pub(super) fn of(config: &Config, known: &Periods<'_>) -> Self {
        let mut blocks = vec![
            known.unit(config, UnitKind::Gathering),
            known.unit(config, UnitKind::Vector),
            known.array(),
        ];
        blocks.extend(known.memories(config));
        // Unknown ones last; a stable sort keeps the order of equal ones.
        blocks.sort_by(|a, b| {
            let of = |own: &BlockPeriod| own.ps.unwrap_or(0.0);
            of(b).total_cmp(&of(a))
        });
        let slowest = blocks.first().and_then(|own| own.ps);
        let reached_ghz = slowest.map(|ps| 1e3 / ps);
        // An estimated block may be the slowest within its error.
        let is_certain = blocks.first().is_some_and(|own| !own.is_estimated)
            && (blocks.iter().map(BlockPeriod::at_most_ps)).all(|own| {
                own.zip(slowest)
                    .is_some_and(|(own, slowest)| own <= slowest)
            });
        let origin = match (config.clock_ghz(), is_certain) {
            (Some(_), _) => ClockOrigin::Assumed,
            (None, true) => ClockOrigin::Synthesised,
            (None, false) => ClockOrigin::Estimated,
        };
        Self {
            ghz: config.clock_ghz().or(reached_ghz).unwrap_or(UNKNOWN_GHZ),
            origin,
            reached_ghz,
            wire_margin: known.wire_margin,
            blocks,
        }
    }
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

/// Clock where no period is known at all.
const UNKNOWN_GHZ: f64 = 1.0;

impl Periods<'_> {
    /// A unit with its memories: as synthesised, otherwise by formulas.
    fn unit(&self, config: &Config, unit: UnitKind) -> BlockPeriod {
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
            UnitKind::Vector | UnitKind::ArrayMac => 1.0,
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
            UnitKind::Vector | UnitKind::ArrayMac => (1.0, String::new()),
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

    fn array(&self) -> BlockPeriod {
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
    fn memories(&self, config: &Config) -> Vec<BlockPeriod> {
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
        let all = periods(units, gathering.top(), of);
        all.chain(periods(self.system, SYSTEM, "")).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_synth::fit::Fit;

    fn clock(text: &str, wire_margin: f64) -> Clock {
        let config = Config::from_toml(text, "test").unwrap();
        let reports = Synthesised::checked_in().unwrap();
        let known = Known {
            fit: &Fit::checked_in().unwrap(),
            reports: &reports,
        };
        let periods = Periods {
            known: &known,
            system: &reports[0].report,
            wire_margin,
        };
        Clock::of(&config, &periods)
    }

    /// The paper's vector unit takes 1602 ps, its gathering unit 1564 with its memories, both at
    /// 12 nm; the weight buffer 756.
    #[test]
    fn the_slowest_block_is_the_clock() {
        let own = clock("", 0.0);
        let period = |of: &str| {
            let block = own.blocks.iter().find(|b| b.block == of).unwrap();
            block.ps.unwrap().round() as u64
        };
        assert_eq!(own.blocks[0].block, "vector_unit");
        assert_eq!(
            (period("vector_unit"), period("gathering_unit")),
            (1602, 1564)
        );
        assert_eq!(period("weight_buffer"), 756);
        assert_eq!(own.blocks.len(), 7);
        assert_eq!(own.origin, ClockOrigin::Synthesised);
        assert_eq!(Some(own.ghz), own.reached_ghz);
        assert!((own.ghz - 1e3 / own.blocks[0].ps.unwrap()).abs() < 1e-12);
    }

    /// An assumed clock is the clock; what is reached is told beside it.
    #[test]
    fn an_assumed_clock_is_marked() {
        let own = clock("clock_ghz = 1.0", 0.0);
        assert_eq!((own.ghz, own.origin), (1.0, ClockOrigin::Assumed));
        assert_eq!(own.reached_ghz, clock("", 0.0).reached_ghz);
    }

    /// Half as much again for wires: of logic, while memories have theirs.
    #[test]
    fn wires_slow_logic_alone() {
        let [plain, wired] = [0.0, 0.5].map(|margin| clock("", margin));
        assert!((plain.ghz / wired.ghz - 1.5).abs() < 1e-12);
        let weights = |own: &Clock| {
            let block = own.blocks.iter().find(|b| b.block == "weight_buffer");
            block.unwrap().ps
        };
        assert_eq!(weights(&plain), weights(&wired));
    }

    /// Nothing is gained by a unit that was never synthesised: it is as slow as the slowest.
    #[test]
    fn an_unknown_unit_is_as_slow_as_the_slowest() {
        let own = clock("[vu.exp]\nform = \"radix-4\"\niterations = 7\n", 0.0);
        let slowest = &own.blocks[0];
        assert_eq!(slowest.block, "vector_unit");
        assert!(slowest.from.starts_with("not known"), "{}", slowest.from);
        assert_eq!(own.origin, ClockOrigin::Estimated);
        assert!(own.ghz < 0.45, "{}", own.ghz);
        // Even if another block is slower: it might be slower still.
        let text = "[rit]\nentry = \"compact\"\n[gu]\nrecords_a_row = 2\n";
        let own = clock(text, 0.0);
        let found = own.blocks.iter().find(|own| own.block == "gathering_unit");
        assert!(found.unwrap().is_guess, "{found:?}");
        assert_eq!(own.origin, ClockOrigin::Estimated);
    }

    /// A unit between two of the grid's is estimated, and said to be.
    #[test]
    fn a_unit_that_was_not_synthesised_is_estimated() {
        let own = clock("[vu]\nlanes = 20\n", 0.0);
        let slowest = &own.blocks[0];
        assert_eq!(own.origin, ClockOrigin::Estimated);
        assert!(slowest.from.contains("held-out points"), "{}", slowest.from);
        let paper = clock("", 0.0).ghz;
        assert!(
            (own.ghz / paper - 1.0).abs() < 0.1,
            "{} and {paper}",
            own.ghz
        );
    }
}
