//! Clock of the accelerator: one for all its blocks, as fast as the slowest of them allows.

use potamoi_formats::config::Config;
use potamoi_synth::UnitKind;
use schemars::JsonSchema;
use serde::Serialize;

use super::block_periods::{BlockPeriod, Periods};

/// Clock of the accelerator, and the blocks that bound it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ClockOrigin {
    /// The longest period is of a block that was synthesised, or of a memory.
    Synthesised,
    /// The longest period is of formulas, or that of another block may be longer within its error.
    Estimated,
    /// The period of a block is not known: it is taken as the slowest of its kind that was synthesised.
    Guessed,
    /// The user assumes it.
    Assumed,
}

impl ClockOrigin {
    /// What marks a clock of this origin in tables.
    #[must_use]
    pub const fn mark(self) -> &'static str {
        match self {
            Self::Synthesised => "",
            Self::Estimated => "~",
            Self::Guessed => "?",
            Self::Assumed => "!",
        }
    }

    /// The word for tables.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Synthesised => "synthesised",
            Self::Estimated => "estimated",
            Self::Guessed => "guessed",
            Self::Assumed => "assumed",
        }
    }
}

impl Clock {
    /// The clock of a configuration's accelerator: the assumed one where the configuration has one,
    /// otherwise 1 over the longest period of gathering unit, vector unit, splat unit, multiply-accumulate
    /// unit of the array, and the cycle times of all memories.
    #[must_use]
    pub(super) fn of(config: &Config, known: &Periods<'_>) -> Self {
        let mut blocks = vec![
            known.unit(config, UnitKind::Gathering),
            known.unit(config, UnitKind::Vector),
            known.array(),
        ];
        if config.su.is_some() {
            blocks.push(known.unit(config, UnitKind::Splat));
        }
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
        let origin = match is_certain {
            _ if blocks.iter().any(|own| own.is_guess || own.ps.is_none()) => ClockOrigin::Guessed,
            true => ClockOrigin::Synthesised,
            false => ClockOrigin::Estimated,
        };
        let reached = Self {
            ghz: reached_ghz.unwrap_or(UNKNOWN_GHZ),
            origin,
            reached_ghz,
            wire_margin: known.wire_margin,
            blocks,
        };
        reached.assumed(config.clock_ghz())
    }

    /// The same blocks at a clock in gigahertz that the user assumes, if there is one.
    #[must_use]
    pub(super) fn assumed(self, ghz: Option<f64>) -> Self {
        match ghz {
            Some(ghz) => Self {
                ghz,
                origin: ClockOrigin::Assumed,
                ..self
            },
            None => self,
        }
    }
}

/// Clock where no period is known at all.
const UNKNOWN_GHZ: f64 = 1.0;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_synth::Synthesised;

    use super::*;
    use crate::system_model::unit_source::Known;
    use potamoi_synth::fit::Fit;

    fn clock(text: &str, wire_margin: f64) -> Clock {
        let config = Config::from_toml(text, "test").unwrap();
        let reports = Synthesised::checked_in().unwrap();
        let known = Known {
            fit: &Fit::checked_in().unwrap(),
            reports: &reports,
            estimated: &[],
        };
        let periods = Periods {
            known: &known,
            system: &reports[0].report,
            wire_margin,
        };
        Clock::of(&config, &periods)
    }

    /// The paper's vector unit takes 1583 ps, its gathering unit 1493 with its memories, both at
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
            (1656, 1481)
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
        assert_eq!(own.origin, ClockOrigin::Guessed);
        assert!(own.ghz < 0.45, "{}", own.ghz);
        // Even if another block is slower: it might be slower still.
        let text = "[rit]\nentry = \"compact\"\n[gu]\nrecords_a_row = 2\n";
        let own = clock(text, 0.0);
        let found = own.blocks.iter().find(|own| own.block == "gathering_unit");
        assert!(found.unwrap().is_guess, "{found:?}");
        assert_eq!(own.origin, ClockOrigin::Guessed);
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
