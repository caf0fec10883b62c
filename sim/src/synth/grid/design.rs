//! The configurations of the grid.

use potamoi_formats::config::{Config, ConfigError};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use crate::synth::UnitKind;

/// Units that differ in numbers alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// The channel-major gathering unit.
    Gathering,
    /// The same, pipelined.
    GatheringPipelined,
    /// The vector unit with restoring exponentials, an iteration a clock.
    Vector,
    /// The same, pipelined.
    VectorPipelined,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Gathering,
        Self::GatheringPipelined,
        Self::Vector,
        Self::VectorPipelined,
    ];

    /// The unit.
    #[must_use]
    pub const fn unit(self) -> UnitKind {
        match self {
            Self::Gathering | Self::GatheringPipelined => UnitKind::Gathering,
            Self::Vector | Self::VectorPipelined => UnitKind::Vector,
        }
    }

    /// What varies: field of the configuration, and values in order.
    const fn knobs(self) -> &'static [Knob] {
        match self {
            Self::Gathering => &GATHERING,
            Self::GatheringPipelined => &GATHERING_PIPELINED,
            Self::Vector => &VECTOR,
            Self::VectorPipelined => &VECTOR_PIPELINED,
        }
    }

    /// Configurations: so many, and what of the text is not the default.
    const fn points(self) -> (usize, &'static str) {
        match self {
            Self::Gathering => (20, ""),
            Self::GatheringPipelined => (14, "gu.pipelined = true\n"),
            Self::Vector => (16, ""),
            Self::VectorPipelined => (12, "vu.exp.pipelined = true\n"),
        }
    }
}

/// A field and the values that it takes.
type Knob = (&'static str, &'static [u32]);

const BANKS: Knob = ("gu.banks", &[8, 12, 16, 20, 24, 32, 40, 48, 56, 64]);
const PORTS: Knob = ("gu.ports", &[1, 2, 4]);
const FEATURE: Knob = ("gu.feature_bits", &[8, 9, 10, 11, 12, 13, 14, 15, 16]);
const WEIGHT: Knob = ("gu.weight_bits", &[7, 8, 9, 10, 11, 12, 13, 14, 15]);
const LANES: Knob = ("vu.lanes", &[4, 8, 12, 16, 20, 24, 32, 40, 48]);
const OUTPUT: Knob = ("vu.exp.output_bits", &[8, 10, 12, 14, 16, 18, 20]);
const EXP: &str = "[\"exp\"]";

const GATHERING: [Knob; 5] = [
    BANKS,
    PORTS,
    FEATURE,
    WEIGHT,
    ("gu.fifo_depth", &[4, 6, 8, 10]),
];
const GATHERING_PIPELINED: [Knob; 5] = [BANKS, PORTS, FEATURE, WEIGHT, ("gu.fifo_depth", &[8, 10])];
const VECTOR: [Knob; 3] = [
    LANES,
    OUTPUT,
    (
        "vu.exp.iterations",
        &[6, 8, 10, 11, 12, 13, 14, 15, 16, 17, 18, 20],
    ),
];
const VECTOR_PIPELINED: [Knob; 3] = [
    LANES,
    OUTPUT,
    ("vu.exp.iterations", &[6, 8, 10, 12, 14, 16, 18]),
];

/// A configuration of the grid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Point {
    /// Which units it is one of.
    pub family: Family,
    /// What it has in place of the defaults, as TOML.
    pub text: String,
    /// Whether its power is estimated too: that of half of them.
    pub has_power: bool,
}

impl Point {
    /// Its configuration.
    ///
    /// # Errors
    /// The rules of configurations, should they change.
    pub fn config(&self) -> Result<Config, ConfigError> {
        Config::from_toml(&self.text, "the grid")
    }
}

/// The grid, a Latin hypercube: every value of each knob about as often as the others,
/// in an order of its own. In every second vector unit there are exponentials alone, in
/// the others all operations.
#[must_use]
pub fn design() -> Vec<Point> {
    let mut points = vec![];
    for (number, family) in Family::ALL.into_iter().enumerate() {
        let (count, fixed) = family.points();
        let mut random = Pcg64Mcg::seed_from_u64(number as u64);
        let columns: Vec<Vec<u32>> = family
            .knobs()
            .iter()
            .map(|(_, values)| {
                let spread = (0..count).map(|i| values[i * values.len() / count]);
                let mut column: Vec<_> = spread.collect();
                column.shuffle(&mut random);
                column
            })
            .collect();
        for at in 0..count {
            let mut text = fixed.to_owned();
            for ((field, _), column) in family.knobs().iter().zip(&columns) {
                text += &format!("{field} = {}\n", column[at]);
            }
            if family.unit() == UnitKind::Vector && at % 2 == 0 {
                text += &format!("vu.ops = {EXP}\n");
            }
            points.push(Point {
                family,
                text,
                has_power: at % 4 < 2,
            });
        }
    }
    points
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_point_is_a_configuration_and_no_two_are_the_same() {
        let points = design();
        let hash = |p: &Point| {
            p.config()
                .map_err(|e| format!("{p:?}: {e}"))
                .unwrap()
                .hash()
        };
        let mut hashes: Vec<_> = points.iter().map(hash).collect();
        hashes.sort();
        hashes.dedup();
        assert_eq!(hashes.len(), points.len());
    }

    /// Every value of every knob that there are points enough for.
    #[test]
    fn knobs_are_swept() {
        let points = design();
        for family in Family::ALL {
            let own: Vec<_> = points.iter().filter(|p| p.family == family).collect();
            for (field, values) in family.knobs() {
                let is_there = |value: &&u32| {
                    let line = format!("{field} = {value}\n");
                    own.iter().any(|p| p.text.contains(&line))
                };
                let there = values.iter().filter(is_there).count();
                assert_eq!(there, values.len().min(own.len()), "{family:?}: {field}");
            }
        }
    }
}
