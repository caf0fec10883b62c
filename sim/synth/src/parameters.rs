//! Reads files of synthesised parameters, for system models.

use potamoi_base::file_keys::told;
use std::path::Path;

use potamoi_formats::config::{Config, PRESETS};
use potamoi_formats::document::{self, Value};

use super::grid::is_same_unit;
use super::report::{
    COMMAND, FORMAT_VERSION, ScaledEnergy, ScaledMemory, ScaledUnit, with_memories_ps,
};
use super::{MemoryReport, SynthError, SynthReport, UnitKind, UnitReport};

const REMEDY: &str = "potamoi synth --json FILE";
const PAPER: &str = include_str!("../../../synth/paper-asap7.json");
const FIELDS: &str = include_str!("../../../synth/fields-asap7.json");
const RECORDS: &str = include_str!("../../../synth/records-asap7.json");
/// Tolerance of sums of rounded decimals.
const NEAR: f64 = 1e-9;
/// Size limit in bytes: a hundred times the files that come with the program.
const LIMIT: u64 = 2 << 20;

/// Parameters with their configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Synthesised {
    /// The configuration.
    pub config: Config,
    /// Parameters of its units.
    pub report: SynthReport,
}

impl Synthesised {
    /// Parameters of the presets `paper` and `fields` that come with the program.
    ///
    /// # Errors
    /// As [`SynthReport::checked_in`].
    pub fn checked_in() -> Result<[Self; 2], SynthError> {
        let [paper, fields] = SynthReport::checked_in()?;
        let of = |name: &str, report| -> Result<Self, SynthError> {
            let (_, text) = PRESETS
                .iter()
                .find(|(own, _)| *own == name)
                .unwrap_or(&PRESETS[0]);
            let config = Config::from_toml(text, name).map_err(|e| SynthError::Parameters {
                path: name.into(),
                why: e.to_string(),
                remedy: REMEDY,
            })?;
            Ok(Self { config, report })
        };
        Ok([of("paper", paper)?, of("fields", fields)?])
    }

    /// Whether a unit of a configuration equals the synthesised one.
    #[must_use]
    pub fn has(&self, config: &Config, unit: UnitKind) -> bool {
        is_same_unit(&self.config, config, unit)
    }
}

impl SynthReport {
    /// The files that come with the program, in ASAP7 at 7 nm: the preset `paper`, whose gathering
    /// unit ran entries of eight vertices, and the preset `fields`.
    ///
    /// # Errors
    /// A file fails the checks of [`SynthReport::read`].
    pub fn checked_in() -> Result<[Self; 2], SynthError> {
        Ok([
            Self::embedded("synth/paper-asap7.json", PAPER)?,
            Self::embedded("synth/fields-asap7.json", FIELDS)?,
        ])
    }

    /// The preset `paper`'s gathering unit, run with splat records.
    ///
    /// # Errors
    /// As [`SynthReport::checked_in`].
    pub fn of_records() -> Result<Self, SynthError> {
        Self::embedded("synth/records-asap7.json", RECORDS)
    }

    fn embedded(name: &str, text: &str) -> Result<Self, SynthError> {
        Self::parse(text).map_err(|why| SynthError::Parameters {
            path: name.into(),
            why,
            remedy: REMEDY,
        })
    }

    /// Reads and checks a file that `potamoi synth --json` wrote.
    ///
    /// # Errors
    /// It cannot be read, has another version, lacks a field, has an unknown one, or its figures
    /// contradict each other.
    pub fn read(path: &Path) -> Result<Self, SynthError> {
        let fail = |why: String| SynthError::Parameters {
            path: path.to_owned(),
            why,
            remedy: REMEDY,
        };
        let text = potamoi_base::files::read_text(path, LIMIT).map_err(|e| fail(e.to_string()))?;
        Self::parse(&text).map_err(fail)
    }

    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let document =
            document::json(text.as_bytes()).map_err(|e| format!("no parameters: {e}"))?;
        let version = document.get("format_version").and_then(Value::whole);
        if version != Some(FORMAT_VERSION.into()) {
            let found = version.map_or("missing".to_owned(), |v| v.to_string());
            return Err(format!("format_version {found}, expected {FORMAT_VERSION}"));
        }
        let report: Self = document.read().map_err(|e| e.to_string())?;
        // Readers of types within types pass keys over that neither has.
        let kept = serde_json::to_vec(&report).map_err(|e| e.to_string())?;
        let kept = document::json(&kept).map_err(|e| e.to_string())?;
        if let Some(lost) = document.lost_in(&kept) {
            return Err(lost.to_string());
        }
        report.check()?;
        Ok(report)
    }

    /// Checks that it is of this configuration; `path` names it in errors.
    ///
    /// # Errors
    /// It is of another configuration.
    pub fn of(self, config: &Config, path: &Path) -> Result<Self, SynthError> {
        match self.configuration == config.hash() {
            true => Ok(self),
            false => Err(SynthError::Parameters {
                path: path.to_owned(),
                why: format!(
                    "it is of configuration {}, expected {}",
                    self.configuration,
                    config.hash()
                ),
                remedy: REMEDY,
            }),
        }
    }

    /// Whether it is of this configuration.
    #[must_use]
    pub fn is_of(&self, config: &Config) -> bool {
        self.configuration == config.hash()
    }

    /// A unit at the library's node.
    #[must_use]
    pub fn unit(&self, unit: UnitKind) -> Option<&UnitReport> {
        self.raw.units.iter().find(|u| u.unit == unit.top())
    }

    /// A unit at the node that the file is scaled to.
    #[must_use]
    pub fn scaled_unit(&self, unit: UnitKind) -> Option<&ScaledUnit> {
        let logic = self.scaled.as_ref()?.logic.as_ref()?;
        logic.units.iter().find(|u| u.unit == unit.top())
    }

    /// A memory at the node of its model, and at the node that the file is scaled to.
    #[must_use]
    pub fn memory(&self, of: &str, name: &str) -> Option<(&MemoryReport, Option<&ScaledMemory>)> {
        let macros = &self.raw.memories.as_ref()?.macros;
        let at = macros.iter().position(|m| m.of == of && m.memory == name)?;
        let scaled = self.scaled.as_ref().and_then(|s| s.memories.as_ref());
        Some((&macros[at], scaled.and_then(|s| s.macros.get(at))))
    }

    fn check(&self) -> Result<(), String> {
        if self.command != COMMAND {
            let told = told(&self.command);
            return Err(format!("command `{told}`, expected `{COMMAND}`"));
        }
        for unit in &self.raw.units {
            let name = &unit.unit;
            positive(name, "area_um2", unit.area_um2)?;
            positive(name, "period_ps", unit.period_ps)?;
            equal(name, "clock_ghz", unit.clock_ghz, 1e3 / unit.period_ps)?;
            if let Some(own) = &unit.with_memories {
                positive(name, "with_memories.period_ps", own.period_ps)?;
                let ghz = 1e3 / own.period_ps;
                equal(name, "with_memories.clock_ghz", own.clock_ghz, ghz)?;
            }
            let area = unit.modules.iter().map(|m| m.count as f64 * m.area_um2);
            equal(name, "area_um2", unit.area_um2, area.sum())?;
            let cells: u64 = unit.modules.iter().map(|m| m.count * m.cells).sum();
            equal(name, "cells", unit.cells as f64, cells as f64)?;
        }
        let memories = self.raw.memories.iter().flat_map(|m| &m.macros);
        for own in memories {
            let f = &own.figures;
            let fields = [
                ("area_um2", f.area_um2),
                ("read_pj", f.read_pj),
                ("write_pj", f.write_pj),
                ("leakage_mw", f.leakage_mw),
                ("access_ps", f.access_ps),
                ("cycle_ps", f.cycle_ps),
            ];
            for (field, value) in fields {
                positive(&own.memory, field, value)?;
            }
        }
        self.check_scaled()
    }

    /// Checks that scaled figures follow from raw ones and the factors.
    fn check_scaled(&self) -> Result<(), String> {
        let Some(scaled) = &self.scaled else {
            return Ok(());
        };
        if let Some(logic) = &scaled.logic {
            if logic.units.len() != self.raw.units.len() {
                return Err("scaled.logic.units: as many as in raw.units expected".to_owned());
            }
            for (unit, raw) in logic.units.iter().zip(&self.raw.units) {
                let name = format!("scaled {}", told(&unit.unit));
                if unit.unit != raw.unit {
                    return Err(format!("{name}, expected {}", raw.unit));
                }
                let factors = &logic.factors;
                equal(
                    &name,
                    "area_um2",
                    unit.area_um2,
                    raw.area_um2 * factors.area,
                )?;
                equal(
                    &name,
                    "period_ps",
                    unit.period_ps,
                    raw.period_ps * factors.delay,
                )?;
                equal(&name, "clock_ghz", unit.clock_ghz, 1e3 / unit.period_ps)?;
                let expected = with_memories_ps(raw, factors);
                match (unit.with_memories_ps, expected) {
                    (None, None) => {}
                    (Some(own), Some(expected)) => {
                        equal(&name, "with_memories_ps", own, expected)?;
                    }
                    _ => {
                        return Err(format!(
                            "{name}: with_memories_ps, expected where the raw unit has it"
                        ));
                    }
                }
                check_energy(&name, unit.energy, ScaledEnergy::of(raw, factors))?;
            }
        }
        let Some(memories) = &scaled.memories else {
            return Ok(());
        };
        let raw = self.raw.memories.as_ref().map_or(&[][..], |m| &m.macros);
        if memories.macros.len() != raw.len() {
            return Err("scaled.memories.macros: as many as in raw.memories expected".to_owned());
        }
        for (own, raw) in memories.macros.iter().zip(raw) {
            let name = format!("scaled {}", told(&own.memory));
            if (&own.memory, &own.of) != (&raw.memory, &raw.of) {
                return Err(format!("{name}, expected {}", raw.memory));
            }
            let expected = raw.figures.scaled(&memories.factors);
            equal(&name, "area_um2", own.figures.area_um2, expected.area_um2)?;
            equal(&name, "read_pj", own.figures.read_pj, expected.read_pj)?;
            equal(&name, "write_pj", own.figures.write_pj, expected.write_pj)?;
            equal(
                &name,
                "leakage_mw",
                own.figures.leakage_mw,
                expected.leakage_mw,
            )?;
            equal(
                &name,
                "access_ps",
                own.figures.access_ps,
                expected.access_ps,
            )?;
            equal(&name, "cycle_ps", own.figures.cycle_ps, expected.cycle_ps)?;
        }
        Ok(())
    }
}

fn check_energy(
    of: &str,
    found: Option<ScaledEnergy>,
    expected: Option<ScaledEnergy>,
) -> Result<(), String> {
    let fields = |e: ScaledEnergy| {
        [
            ("zero_delay_pj_a_cycle", e.zero_delay_pj_a_cycle),
            ("with_glitches_pj_a_cycle", e.with_glitches_pj_a_cycle),
            ("zero_delay_pj_an_item", e.zero_delay_pj_an_item),
            ("with_glitches_pj_an_item", e.with_glitches_pj_an_item),
        ]
    };
    match (found, expected) {
        (None, None) => Ok(()),
        (Some(found), Some(expected)) => fields(found)
            .into_iter()
            .zip(fields(expected))
            .try_for_each(|((field, a), (_, b))| equal(of, field, a, b)),
        _ => Err(format!(
            "{of}: energy, expected where the raw unit has power"
        )),
    }
}

fn positive(of: &str, field: &str, value: f64) -> Result<(), String> {
    match value.is_finite() && value > 0.0 {
        true => Ok(()),
        false => Err(format!("{of}: {field} {value}, expected a number above 0")),
    }
}

fn equal(of: &str, field: &str, found: f64, expected: f64) -> Result<(), String> {
    match (found / expected - 1.0).abs() < NEAR || found == expected {
        true => Ok(()),
        false => Err(format!(
            "{of}: {field} {found}, expected {expected} by its other figures"
        )),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::SYSTEM;
    use std::path::PathBuf;

    fn path() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../synth/paper-asap7.json")
    }

    /// The parameters that come with the project are of its presets.
    #[test]
    fn the_papers_parameters_are_read() {
        let config = Config::paper();
        let report = SynthReport::read(&path())
            .unwrap()
            .of(&config, &path())
            .unwrap();
        assert_eq!(report.library.node_nm, Some(7));
        for unit in [UnitKind::Gathering, UnitKind::Vector] {
            let (raw, scaled) = (
                report.unit(unit).unwrap(),
                report.scaled_unit(unit).unwrap(),
            );
            assert!(scaled.area_um2 > raw.area_um2 && scaled.period_ps > raw.period_ps);
            let energy = scaled.energy.unwrap();
            assert!(energy.with_glitches_pj_a_cycle > energy.zero_delay_pj_a_cycle);
        }
        let banks = report.unit(UnitKind::Gathering).unwrap().memories.clone();
        for own in banks {
            let (raw, scaled) = report
                .memory(UnitKind::Gathering.top(), &own.module)
                .unwrap();
            assert_eq!((raw.count, raw.shape.words), (own.count, own.words));
            assert!(scaled.unwrap().figures.area_um2 < raw.figures.area_um2);
        }
        assert_eq!(
            report
                .memory(SYSTEM, "global_feature_buffer")
                .unwrap()
                .0
                .count,
            48
        );
        assert!(report.memory(SYSTEM, "mft_bank").is_none());

        let other = Config {
            clock_mhz: 500,
            ..config
        };
        let error = report.of(&other, &path()).unwrap_err().to_string();
        assert!(
            error.contains("expected") && error.contains(&other.hash()),
            "{error}"
        );
    }

    /// An unknown key in any kind of object, at any depth, in any kind of file is refused.
    #[test]
    fn keys_that_nobody_knows_are_refused_at_every_depth() {
        use serde_json::Value;

        /// Paths of objects; of lists only the first element's.
        fn objects(value: &Value, path: &str, found: &mut Vec<String>) {
            match value {
                Value::Object(entries) => {
                    found.push(path.to_owned());
                    for (key, value) in entries {
                        objects(value, &format!("{path}/{key}"), found);
                    }
                }
                Value::Array(values) => {
                    if let Some(first) = values.first() {
                        objects(first, &format!("{path}/0"), found);
                    }
                }
                _ => {}
            }
        }

        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../synth");
        type Parse = fn(&str) -> Result<(), String>;
        let report: Parse = |text| SynthReport::parse(text).map(drop);
        let grid: Parse = |text| {
            let read = crate::grid::Grid::parse(text, Path::new("grid.json"));
            read.map(drop).map_err(|e| e.to_string())
        };
        for (file, parse, least) in [
            ("paper-asap7.json", report, 10),
            ("grid-asap7.json", grid, 6),
            ("forms-asap7.json", grid, 6),
        ] {
            let text = std::fs::read_to_string(root.join(file)).unwrap();
            parse(&format!("\u{feff}{text}")).unwrap();
            let good: Value = serde_json::from_str(&text).unwrap();
            let mut paths = vec![];
            objects(&good, "", &mut paths);
            assert!(paths.len() >= least, "{file}: {paths:?}");
            // There, keys are names of memories.
            for path in paths.iter().filter(|path| !path.ends_with("/access_ps")) {
                let mut more = good.clone();
                more.pointer_mut(path).unwrap()["news"] = 1.into();
                let error = parse(&more.to_string()).unwrap_err();
                assert!(error.contains("news"), "{file}{path}: {error}");
            }
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let text = std::fs::read_to_string(path()).unwrap();
        let good: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert!(SynthReport::parse(&good.to_string()).is_ok());
        type Change = fn(&mut serde_json::Value);
        let changes: [(Change, &str); 14] = [
            (
                |v| v["format_version"] = 1.into(),
                "format_version 1, expected 3",
            ),
            (|v| v["command"] = "cost".into(), "command `cost`"),
            (
                |v| v["raw"]["units"][0]["area_um2"] = 1.0.into(),
                "gathering_unit: area_um2 1, expected",
            ),
            (
                |v| v["raw"]["units"][1]["cells"] = 7.into(),
                "vector_unit: cells 7, expected",
            ),
            (
                |v| v["raw"]["units"][0]["period_ps"] = (-1.0).into(),
                "period_ps -1, expected a number above 0",
            ),
            (
                |v| v["raw"]["memories"]["macros"][0]["read_pj"] = 0.0.into(),
                "mft_bank: read_pj 0",
            ),
            (
                |v| v["scaled"]["logic"]["factors"]["area"] = 2.0.into(),
                "scaled gathering_unit: area_um2",
            ),
            (
                |v| {
                    v["scaled"]["logic"]["units"][1]["energy"]["with_glitches_pj_an_item"] =
                        1.0.into()
                },
                "scaled vector_unit: with_glitches_pj_an_item 1, expected",
            ),
            (
                |v| v["scaled"]["logic"]["units"][0]["with_memories_ps"] = 1.0.into(),
                "scaled gathering_unit: with_memories_ps 1, expected",
            ),
            (
                |v| v["raw"]["units"][0]["with_memories"]["period_ps"] = 900.0.into(),
                "gathering_unit: with_memories.clock_ghz",
            ),
            (
                |v| v["scaled"]["logic"]["units"][0]["energy"] = serde_json::Value::Null,
                "scaled gathering_unit: energy, expected where",
            ),
            (
                |v| v["scaled"]["memories"]["macros"][1]["cycle_ps"] = 1.0.into(),
                "scaled rit_bank: cycle_ps",
            ),
            (
                |v| v["scaled"]["memories"]["macros"] = serde_json::json!([]),
                "as many as in raw",
            ),
            (|v| v["raw"]["unit"] = 1.into(), "raw.unit"),
        ];
        for (change, said) in changes {
            let mut bad = good.clone();
            change(&mut bad);
            let why = SynthReport::parse(&bad.to_string()).unwrap_err();
            assert!(why.contains(said), "{said}: {why}");
        }
        assert!(
            SynthReport::parse("{}")
                .unwrap_err()
                .contains("format_version")
        );
        assert!(SynthReport::parse(&text[..text.len() / 2]).is_err());
        let gone = SynthReport::read(Path::new("gone.json"))
            .unwrap_err()
            .to_string();
        assert!(
            gone.starts_with("gone.json: ") && gone.contains("potamoi synth --json"),
            "{gone}"
        );
    }
}
