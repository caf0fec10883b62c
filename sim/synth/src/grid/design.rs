//! Experimental design of the grid.

use std::collections::{BTreeMap, BTreeSet};

use potamoi_formats::config::{Config, ConfigError, Organisation};
use potamoi_formats::units::OpCode;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::UnitKind;

/// Units that differ in numbers only.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// The channel-major gathering unit.
    Gathering,
    /// The channel-major gathering unit, pipelined.
    GatheringPipelined,
    /// The vector unit with restoring exponentials, one iteration a clock.
    Vector,
    /// The vector unit with restoring exponentials, pipelined.
    VectorPipelined,
}

impl Family {
    /// All families.
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

    /// Varied fields with their values in order.
    const fn knobs(self) -> &'static [Knob] {
        match self {
            Self::Gathering => &GATHERING,
            Self::GatheringPipelined => &GATHERING_PIPELINED,
            Self::Vector => &VECTOR,
            Self::VectorPipelined => &VECTOR_PIPELINED,
        }
    }

    /// Number of configurations, and their common differences from the default.
    const fn points(self) -> (usize, &'static str) {
        match self {
            Self::Gathering => (20, ""),
            Self::GatheringPipelined => (14, "gu.pipelined = true\n"),
            Self::Vector => (16, ""),
            Self::VectorPipelined => (12, "vu.exp.pipelined = true\n"),
        }
    }
}

/// Fields that keep a configuration's unit out of every family.
pub type Differences = Vec<String>;

impl Family {
    /// The family with the same pipelining, whatever else differs; `None` for a unit without numbers
    /// that a formula could be of.
    pub(crate) const fn plain(config: &Config, unit: UnitKind) -> Option<Self> {
        match unit {
            UnitKind::Gathering if config.gu.pipelined => Some(Self::GatheringPipelined),
            UnitKind::Gathering => Some(Self::Gathering),
            UnitKind::Vector if config.vu.exp.pipelined => Some(Self::VectorPipelined),
            UnitKind::Vector => Some(Self::Vector),
            UnitKind::ArrayMac | UnitKind::Splat => None,
        }
    }

    /// Fields whose numbers its formulas take.
    pub(crate) fn numbers(self) -> impl Iterator<Item = &'static str> + Clone {
        self.knobs().iter().map(|(field, _)| *field)
    }

    /// The family of a configuration's unit, and its numbers outside the grid: `field = value, the
    /// grid has a to b`.
    ///
    /// # Errors
    /// The fields in which the unit differs from every family in more than numbers; none, if no family
    /// is of such units.
    pub fn of(config: &Config, unit: UnitKind) -> Result<(Self, Vec<String>), Differences> {
        let Some(family) = Self::plain(config, unit) else {
            return Err(vec![]);
        };
        let (own, usual) = (fields(config), fields(&Config::default()));
        let (mut others, mut beyond) = (vec![], vec![]);
        for (field, value) in own.iter().filter(|(field, _)| matters(field, unit)) {
            let values = family.knobs().iter().find(|(knob, _)| knob == field);
            let is_as_usual = match (values, field.as_str()) {
                (Some((_, values)), _) => {
                    let (least, most) = (values[0], values[values.len() - 1]);
                    let number = value.as_u64().unwrap_or_default();
                    if !(u64::from(least)..=u64::from(most)).contains(&number) {
                        beyond.push(format!("{field} = {value}, the grid has {least} to {most}"));
                    }
                    true
                }
                (None, "vu.ops") => [&usual[field], &json!(["exp"])].contains(&value),
                (None, "gu.pipelined" | "vu.exp.pipelined") => true,
                (None, _) => usual.get(field) == Some(value),
            };
            if !is_as_usual {
                // A field that is left out by default has no usual value.
                let expected = match usual.get(field) {
                    None | Some(Value::Null) => "nothing".to_owned(),
                    Some(usual) => usual.to_string(),
                };
                others.push(format!("{field} = {value}, expected {expected}"));
            }
        }
        match others.is_empty() {
            true => Ok((family, beyond)),
            false => Err(others),
        }
    }
}

/// A configuration in which a setting that is stated and the same setting derived are alike.
fn as_derived(config: &Config) -> Config {
    let mut own = config.clone();
    own.gu.fifo_depth = Some(config.feature_fifo_depth());
    own.rit.stream_bits = None;
    if own.rit_stream_bits() != config.rit_stream_bits() {
        own.rit.stream_bits = config.rit.stream_bits;
    }
    // The number of channels selects the organisation, and nothing else.
    own.gu.channels = None;
    own.gu.organisation = match config.organisation().0 {
        Organisation::ChannelMajor => Organisation::Auto,
        other => other,
    };
    // Without square-sum, stated widths also leave out the bit that its sum has more.
    if config.vu.ops.contains(&OpCode::SquareSum) && !config.vu.has_narrow_operands() {
        own.vu.operands = None;
    }
    own
}

/// All fields of a configuration by path.
fn fields(config: &Config) -> BTreeMap<String, Value> {
    fn add(path: &str, value: Value, to: &mut BTreeMap<String, Value>) {
        match value {
            Value::Object(inner) => {
                for (name, value) in inner {
                    let dot = if path.is_empty() { "" } else { "." };
                    add(&format!("{path}{dot}{name}"), value, to);
                }
            }
            other => drop(to.insert(path.to_owned(), other)),
        }
    }
    let mut found = BTreeMap::new();
    let config = serde_json::to_value(as_derived(config)).unwrap_or_default();
    add("", config, &mut found);
    found
}

/// A field with its values in order.
type Knob = (&'static str, &'static [u32]);

const BANKS: Knob = ("gu.banks", &[8, 12, 16, 20, 24, 32, 40, 48, 56, 64]);
const PORTS: Knob = ("gu.ports", &[1, 2, 4]);
const FEATURE: Knob = ("gu.feature_bits", &[8, 9, 10, 11, 12, 13, 14, 15, 16]);
const WEIGHT: Knob = ("gu.weight_bits", &[7, 8, 9, 10, 11, 12, 13, 14, 15]);
const LANES: Knob = ("vu.lanes", &[4, 8, 12, 16, 20, 24, 32, 40, 48]);
const OUTPUT: Knob = ("vu.exp.output_bits", &[8, 10, 12, 14, 16, 18, 20]);
const EXP: &str = "[\"exp\"]";
/// The preset `fields`' vector unit, but for how many iterations a clock it does.
const FIELDS: &str = "\
[vu]
ops = [\"pass\", \"relu\", \"add\", \"multiply\", \"square-sum\", \"exp\", \"one-minus-exp\", \"sigmoid\", \"softplus\"]

[vu.exp]
iterations = 18
accumulator_bits = 20
constant_bits = 20
";

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
    /// Family of its unit.
    pub family: Family,
    /// Its differences from the defaults, as TOML.
    pub text: String,
}

impl Point {
    /// Name on one line.
    #[must_use]
    pub fn name(&self) -> String {
        self.text.trim_end().replace('\n', "; ")
    }

    /// Its configuration.
    ///
    /// # Errors
    /// It breaks a rule of configurations.
    pub fn config(&self) -> Result<Config, ConfigError> {
        Config::from_toml(&self.text, "the grid")
    }
}

/// The grid, a Latin hypercube: each value of a knob is used about equally often, in an independent
/// order. Half of the vector units have exponentials only, the others all operations.
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
            points.push(Point { family, text });
        }
    }
    points
}

/// Units that no formula covers, each on its own: the paper's with other exponentials, exact sums,
/// and records that share a row; and the preset `fields`' vector unit with settings outside the
/// formulas; and combinations of these; and exponentials by themselves. The family is the one from
/// which it differs in more than numbers.
#[must_use]
pub fn forms() -> Vec<Point> {
    let tails = [4, 6, 8, 9, 12, 14].map(|n| format!("iterations = {n}\ntail = true"));
    let radix_4 = [3, 4, 5].map(|n| format!("form = \"radix-4\"\niterations = {n}\ntail = true"));
    // With fewer, results of 16 bits are refused.
    let pieces =
        [64, 128, 256].map(|n| format!("form = \"piecewise\"\npieces = {n}\npipelined = true"));
    let clocks = [2, 4].map(|n| format!("iterations_per_clock = {n}"));
    let inputs = [8, 10, 11, 12].map(|n| format!("input = \"U3.{n}\""));
    let accumulators = [16, 17, 18, 19].map(|n| format!("accumulator_bits = {n}"));
    let constants = [14, 16, 17, 18].map(|n| format!("constant_bits = {n}"));
    let densities = [12, 14, 16, 18].map(|n| format!("one_minus_frac_bits = {n}"));
    let all = [
        &tails[..],
        &radix_4,
        &pieces,
        &["early_out = true".to_owned()],
        &clocks,
        &inputs,
        &accumulators,
        &constants,
        &densities,
    ];
    let units = all.into_iter().flatten().map(|text| Point {
        family: match text.contains("pipelined = true") {
            true => Family::VectorPipelined,
            false => Family::Vector,
        },
        text: format!("[vu.exp]\n{text}\n"),
    });
    let clocks = ["iterations_per_clock = 4".to_owned()];
    let two = |text: &String| format!("iterations_per_clock = 2\n{text}");
    let others = inputs.iter().chain(&densities).map(two);
    let fields = clocks.into_iter().chain(others).map(|text| Point {
        family: Family::Vector,
        text: format!("{FIELDS}{text}\n"),
    });
    let gathering = ["sums = \"exact\"", "records_a_row = 2"];
    let gathering = gathering.map(|text| Point {
        family: Family::Gathering,
        text: format!("[gu]\n{text}\n"),
    });
    let all = units.chain(gathering).chain(fields);
    all.chain(combinations()).chain(exponentials()).collect()
}

/// Vector units with several parts that were synthesised alone, to know the error of composition.
fn combinations() -> impl Iterator<Item = Point> {
    let pipelined = "iterations = 9\ntail = true\npipelined = true";
    let radix_4 = "form = \"radix-4\"\niterations = 4\ntail = true\npipelined = true";
    let clocks = "iterations = 8\ntail = true\niterations_per_clock = 4";
    let early = "early_out = true\naccumulator_bits = 18";
    let narrow =
        "form = \"radix-4\"\niterations = 5\ntail = true\noutput_bits = 12\ninput = \"U3.10\"";
    let all = [
        (4, Family::VectorPipelined, pipelined),
        (24, Family::VectorPipelined, radix_4),
        (24, Family::Vector, clocks),
        (12, Family::Vector, early),
        (32, Family::Vector, narrow),
    ];
    all.into_iter().map(|(lanes, family, exp)| Point {
        family,
        text: format!("vu.lanes = {lanes}\n\n[vu.exp]\n{exp}\n"),
    })
}

/// Exponentials by themselves: vector units of one lane and one operation, with the settings that are
/// compared.
fn exponentials() -> Vec<Point> {
    let iterations = [8, 10, 12, 14, 16, 20, 24, 27].map(|n| format!("iterations = {n}"));
    let tails = [4, 6, 8, 9, 14].map(|n| format!("iterations = {n}\ntail = true"));
    let radix_4 = [3, 4, 5].map(|n| format!("form = \"radix-4\"\niterations = {n}\ntail = true"));
    let pieces =
        [64, 128, 256].map(|n| format!("form = \"piecewise\"\npieces = {n}\npipelined = true"));
    let others = [
        "early_out = true",
        "pipelined = true",
        "form = \"radix-4\"\niterations = 8",
        "form = \"radix-4\"\niterations = 4\ntail = true\npipelined = true",
    ];
    let all = [&iterations[..], &tails, &radix_4, &pieces];
    let all = all.into_iter().flatten().map(String::as_str).chain(others);
    all.map(|text| Point {
        family: match text.contains("pipelined = true") {
            true => Family::VectorPipelined,
            false => Family::Vector,
        },
        text: format!("vu.lanes = 1\nvu.ops = {EXP}\n\n[vu.exp]\n{text}\n"),
    })
    .collect()
}

/// Whether a vector unit is an exponential by itself.
pub(crate) fn is_exponential(config: &Config) -> bool {
    config.vu.lanes == 1 && config.vu.ops == [OpCode::Exp]
}

/// Whether a field of a configuration affects a unit.
fn matters(field: &str, unit: UnitKind) -> bool {
    match unit {
        // Of the table, its path and the pairs that it lists are the GPU's.
        UnitKind::Gathering => {
            !["vu.", "su."].iter().any(|begin| field.starts_with(begin))
                && !["clock_mhz", "rit.path", "rit.pairs"].contains(&field)
        }
        // Of the samples that it computes the host's schedule decides.
        UnitKind::Vector => field.starts_with("vu.") && field != "vu.samples",
        // Units side by side are each the same.
        UnitKind::Splat => {
            let of_lanes = field.starts_with("vu.exp.") || field == "vu.registered";
            of_lanes || field.starts_with("su.") && field != "su.units"
        }
        UnitKind::ArrayMac => false,
    }
}

/// A configuration with its effective widths, and without settings that its exponential form does
/// not use.
fn in_effect(config: &Config) -> Config {
    let mut own = config.clone();
    own.vu.exp = own.vu.exp.in_effect();
    own
}

/// Fields of a unit that differ between two configurations as they are written.
pub(crate) fn differing(a: &Config, b: &Config, unit: UnitKind) -> Vec<String> {
    let (a, b) = (fields(a), fields(b));
    let names: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    let own = names.into_iter().filter(|name| matters(name, unit));
    own.filter(|name| a.get(*name) != b.get(*name))
        .cloned()
        .collect()
}

/// Whether a unit is equal in two configurations.
#[must_use]
pub fn is_same_unit(a: &Config, b: &Config, unit: UnitKind) -> bool {
    differing(&in_effect(a), &in_effect(b), unit).is_empty()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_netlist::Header;

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

    #[test]
    fn every_point_is_in_its_family() {
        for point in design() {
            let config = point.config().unwrap();
            let found = Family::of(&config, point.family.unit()).unwrap();
            assert_eq!(found, (point.family, vec![]), "{point:?}");
        }
    }

    /// No two are equal, and no formula covers any; none is of a unit of one lane.
    #[test]
    fn every_form_is_one_that_no_formula_is_of() {
        let forms = forms();
        for (at, point) in forms.iter().enumerate() {
            let config = point.config().unwrap();
            let unit = point.family.unit();
            let is_of_formulas =
                Family::of(&config, unit).is_ok_and(|(_, beyond)| beyond.is_empty());
            assert!(!is_of_formulas, "{point:?}");
            assert!(unit.module(&config).is_ok(), "{point:?}");
            let others = forms[..at].iter().filter(|o| o.family.unit() == unit);
            let same = |other: &Point| is_same_unit(&config, &other.config().unwrap(), unit);
            assert_eq!(others.filter(|other| same(other)).count(), 0, "{point:?}");
        }
    }

    /// Forms of the preset `fields` differ from it in one setting of the exponential.
    #[test]
    fn forms_of_fields_are_of_the_preset() {
        let preset = Config::from_toml(include_str!("../../../../configs/fields.toml"), "fields");
        let preset = preset.unwrap();
        let alike = |p: &Point| p.text.starts_with(FIELDS);
        let all: Vec<_> = forms().into_iter().filter(alike).collect();
        assert_eq!(all.len(), 9);
        for point in all {
            let own = point.config().unwrap();
            let [own, preset] = [&own, &preset].map(fields);
            let others: Vec<_> = own.iter().filter(|(f, v)| preset[*f] != **v).collect();
            assert_eq!(others.len(), 1, "{others:?}");
        }
    }

    #[test]
    fn what_is_no_number_of_a_family_is_named() {
        let of = |text: &str, unit| Family::of(&Config::from_toml(text, "test").unwrap(), unit);
        let compact = "rit.entry = \"compact\"\nvu.lanes = 2\n";
        let others = of(compact, UnitKind::Gathering).unwrap_err();
        assert_eq!(others, ["rit.entry = \"compact\", expected \"paper\""]);
        let (family, beyond) = of(compact, UnitKind::Vector).unwrap();
        assert_eq!(family, Family::Vector);
        assert_eq!(beyond, ["vu.lanes = 2, the grid has 4 to 48"]);
        let narrow = "vu.registered = true\n[vu.operands]\nsquare_sum = 19";
        assert_eq!(
            of(narrow, UnitKind::Vector).unwrap_err(),
            [
                "vu.operands.multiply = [32,32], expected nothing",
                "vu.operands.square_sum = 19, expected nothing",
                "vu.registered = true, expected nothing"
            ]
        );
        let radix = of(
            "vu.exp.form = \"radix-4\"\nvu.exp.iterations = 8",
            UnitKind::Vector,
        );
        assert_eq!(
            radix.unwrap_err(),
            ["vu.exp.form = \"radix-4\", expected \"restoring\""]
        );
    }

    #[test]
    fn what_the_gpu_does_otherwise_leaves_the_units_alike() {
        let paper = Config::paper();
        let text = "rit.path = \"direct\"\nrit.pairs = \"that-may-count\"\nsu.units = 2\n\
                    vu.samples = \"that-may-count\"";
        let other = Config::from_toml(text, "test").unwrap();
        for unit in [UnitKind::Gathering, UnitKind::Vector] {
            assert!(is_same_unit(&paper, &other, unit), "{unit}");
        }
    }

    /// Settings that are stated as they would be derived, and others: two units are the same where
    /// their Verilog is.
    #[test]
    fn units_of_the_same_verilog_are_the_same() {
        let verilog = |config: &Config, unit: UnitKind| {
            potamoi_netlist::verilog(&unit.module(config).unwrap(), &Header::default())
        };
        let fields = "vu.ops = [\"exp\", \"multiply\", \"sigmoid\"]\nvu.lanes = 2\n";
        for base in ["", "gu.ports = 1\n", fields] {
            let paper = Config::from_toml(base, "base").unwrap();
            let mut alike = 0;
            for text in [
                "rit.stream_bits = 128",
                "rit.stream_bits = 64",
                "gu.fifo_depth = 4",
                "gu.fifo_depth = 6",
                "gu.organisation = \"channel-major\"",
                "gu.organisation = \"feature-major\"",
                "gu.channels = 32",
                "gu.channels = 4",
                "vu.registered = false",
                "vu.exp.accumulator_bits = 19",
                "vu.exp.accumulator_bits = 20",
                "vu.exp.offset = 3",
                "vu.operands.multiply = [32, 32]",
                "vu.operands.multiply = [32, 31]",
            ] {
                let Ok(other) = Config::from_toml(&format!("{base}{text}"), "other") else {
                    continue;
                };
                for unit in [UnitKind::Gathering, UnitKind::Vector] {
                    let same = is_same_unit(&paper, &other, unit);
                    let bytes = verilog(&paper, unit) == verilog(&other, unit);
                    assert_eq!(same, bytes, "{base}{text}: {unit}");
                    alike += usize::from(same);
                }
            }
            assert!(alike > 14, "{alike}");
        }
    }

    /// Every value of every knob with enough points occurs.
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
