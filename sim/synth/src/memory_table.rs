//! CACTI's figures of memories by shape, for units that were not synthesised.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use potamoi_formats::config::{Config, PRESETS};
use potamoi_formats::document;
use serde::{Deserialize, Serialize};

use super::cacti::{Cacti, Figures, Settings, Shape, is_modelled};
use super::memories::{MemoryReport, macros, shape, system};
use super::{SynthError, UnitKind};

/// Version of the file.
const FORMAT_VERSION: u32 = 1;
/// The file that comes with the program, and the command that writes it.
const NAME: &str = "synth/memories-cacti.json";
const REMEDY: &str = "potamoi synth --memories FILE";
const TEXT: &str = include_str!("../../../synth/memories-cacti.json");

/// Words and ports of a memory, with its figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Known {
    #[serde(flatten)]
    shape: Shape,
    #[serde(flatten)]
    figures: Figures,
}

/// Figures of memories by shape, at the node of their model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MemoryTable {
    format_version: u32,
    /// Settings of the model.
    pub origin: Settings,
    memories: Vec<Known>,
}

impl MemoryTable {
    /// The table that comes with the program.
    ///
    /// # Errors
    /// It is none of this version.
    pub fn checked_in() -> Result<&'static Self, SynthError> {
        static TABLE: OnceLock<Result<MemoryTable, String>> = OnceLock::new();
        let table = TABLE.get_or_init(|| Self::parse(TEXT));
        table.as_ref().map_err(|why| SynthError::Parameters {
            path: NAME.into(),
            why: why.clone(),
            remedy: REMEDY,
        })
    }

    fn parse(text: &str) -> Result<Self, String> {
        let own: Self = (document::json(text.as_bytes()).and_then(|own| own.read()))
            .map_err(|error| error.to_string())?;
        match own.format_version {
            FORMAT_VERSION => Ok(own),
            found => Err(format!("format_version {found}, expected {FORMAT_VERSION}")),
        }
    }

    /// Figures of a memory; `None` where its shape was not modelled.
    #[must_use]
    pub fn figures(&self, shape: &Shape) -> Option<&Figures> {
        let own = self.memories.iter().find(|own| own.shape == *shape);
        own.map(|own| &own.figures)
    }

    /// Words of the memories that differ from a shape in nothing else, fewest first.
    #[must_use]
    pub fn words(&self, of: &Shape) -> Vec<u64> {
        let alike = |own: &&Known| {
            Shape {
                words: of.words,
                ..own.shape
            } == *of
        };
        let all = self
            .memories
            .iter()
            .filter(alike)
            .map(|own| own.shape.words);
        all.collect()
    }

    /// Memories of a unit that are not among its cells, with their figures at the node of the model.
    ///
    /// # Errors
    /// Why they are not known: a memory that is too small for the model, or of a shape that was not modelled.
    pub fn of_unit(&self, config: &Config, unit: UnitKind) -> Result<Vec<MemoryReport>, String> {
        let module = unit.module(config).map_err(|error| error.to_string())?;
        let each = module.memory_macros().into_iter().map(|own| {
            let (memory, count) = (own.module.clone(), own.count.into());
            let shape = shape(&own.into());
            let size = format!("{memory}, {} words of {} bits", shape.words, shape.bits);
            if is_modelled(&shape).is_err() {
                return Err(format!(
                    "{size}, is too small for CACTI: potamoi synth counts its cells"
                ));
            }
            let figures = self.figures(&shape).copied();
            Ok(MemoryReport {
                of: unit.top().to_owned(),
                figures: figures.ok_or_else(|| {
                    format!("{size}, is not among the memories that CACTI modelled: potamoi synth asks it")
                })?,
                memory,
                count,
                shape,
            })
        });
        each.collect()
    }

    /// Asks CACTI about all shapes that units and buffers have over the usual values of their fields.
    /// Shapes of which it finds no array are left out.
    ///
    /// # Errors
    /// CACTI cannot be run.
    pub fn model(cacti: &Cacti, step: &dyn Fn()) -> Result<Self, SynthError> {
        let mut memories = vec![];
        for shape in wanted() {
            match cacti.model("a memory of the table", &shape) {
                Ok(figures) => memories.push(Known { shape, figures }),
                Err(SynthError::Tool { .. }) => {}
                Err(error) => return Err(error),
            }
            step();
        }
        Ok(Self {
            format_version: FORMAT_VERSION,
            origin: cacti.settings(),
            memories,
        })
    }

    /// Number of shapes that [`MemoryTable::model`] asks about.
    #[must_use]
    pub fn wanted_len() -> u64 {
        wanted().len() as u64
    }

    /// Number of memories.
    #[must_use]
    pub fn len(&self) -> usize {
        self.memories.len()
    }

    /// Whether it has none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.memories.is_empty()
    }
}

/// Shapes of memories of the presets, of gathering units and splat units over the fields that change them,
/// and of the buffers.
fn wanted() -> BTreeSet<Shape> {
    let presets = PRESETS.iter().map(|(_, text)| (*text).to_owned());
    let ports = ["1", "2", "3", "4", "8"];
    let mut texts: Vec<String> = presets.collect();
    for ports in ports {
        for extra in ["copies", "split"] {
            for rows in [64, 128, 256, 512, 1024, 2048] {
                texts.push(format!(
                    "mvoxel.rows = {rows}\n[gu]\nports = {ports}\nextra_ports = \"{extra}\""
                ));
            }
        }
        for entries in [16, 32, 64, 128, 256, 512, 1024] {
            for entry in ["paper", "compact"] {
                texts.push(format!(
                    "rit.entries = {entries}\nrit.entry = \"{entry}\"\ngu.ports = {ports}"
                ));
                texts.push(format!(
                    "rit.entries = {entries}\nrit.entry = \"{entry}\"\n[gu]\nports = {ports}\nmodes = \"unstructured\""
                ));
            }
        }
    }
    for tiles in [2, 4, 8, 16, 32, 64] {
        for lanes in [1, 2, 4, 8, 16] {
            texts.push(format!(
                "vu.exp.pipelined = true\n[su]\ntiles = {tiles}\nlanes = {lanes}"
            ));
        }
    }
    let mut found = BTreeSet::new();
    for config in (texts.iter()).filter_map(|text| Config::from_toml(text, "memories").ok()) {
        let splat = config.su.is_some().then_some(UnitKind::Splat);
        for unit in [UnitKind::Gathering].into_iter().chain(splat) {
            let own = macros(&config, unit).unwrap_or_default();
            found.extend(own.iter().map(shape));
        }
    }
    for (_, _, own) in system() {
        let sizes = [1, 2, 4, 8, 16].map(|by| own.words / 4 * by);
        found.extend(sizes.map(|words| Shape { words, ..own }));
    }
    found.retain(|own| is_modelled(own).is_ok());
    found
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::parameters::Synthesised;

    /// The same program gave both: a memory of a synthesised preset has the figures of the table.
    #[test]
    fn the_table_has_the_memories_of_the_presets() {
        let table = MemoryTable::checked_in().unwrap();
        let (mut count, mut units) = (0, 0);
        for own in Synthesised::checked_in().unwrap() {
            let memories = own.report.raw.memories.unwrap();
            assert_eq!(memories.origin, table.origin);
            // Names, numbers and figures of a unit are those of its synthesis.
            let unit = UnitKind::Gathering.top();
            match table.of_unit(&own.config, UnitKind::Gathering) {
                Ok(mut of_unit) => {
                    let reported = memories.macros.iter().filter(|memory| memory.of == unit);
                    let mut reported: Vec<_> = reported.cloned().collect();
                    for all in [&mut of_unit, &mut reported] {
                        all.sort_by(|a, b| a.memory.cmp(&b.memory));
                    }
                    assert_eq!(of_unit, reported);
                    units += 1;
                }
                // Those of the lanes of the feature-major unit are cells.
                Err(why) => assert!(
                    why.contains("lane_entries") && why.contains("too small"),
                    "{why}"
                ),
            }
            for memory in memories.macros {
                assert_eq!(
                    table.figures(&memory.shape),
                    Some(&memory.figures),
                    "{memory:?}"
                );
                count += 1;
            }
        }
        assert!(count > 20 && units > 8, "{count} {units}");
    }

    /// More banks and more ports take more area; a memory that CACTI does not know is named.
    #[test]
    fn areas_of_units_that_were_not_synthesised_are_sums_over_their_memories() {
        let table = MemoryTable::checked_in().unwrap();
        let area = |text: &str| {
            let config = Config::from_toml(text, "test").unwrap();
            let all = table.of_unit(&config, UnitKind::Gathering)?;
            let each = all
                .iter()
                .map(|own| own.count as f64 * own.figures.area_um2);
            Ok::<f64, String>(each.sum())
        };
        let paper = area("").unwrap();
        assert!(area("gu.ports = 1").unwrap() < paper);
        assert!(area("gu.ports = 4").unwrap() > paper);
        assert!(area("rit.entries = 64").unwrap() < paper);
        // Twice the banks of the MFT; the RIT buffer stays.
        let config = Config::paper();
        let mft: f64 = (macros(&config, UnitKind::Gathering).unwrap().iter())
            .filter(|own| own.module == "mft_bank")
            .map(|own| own.count as f64 * table.figures(&shape(own)).unwrap().area_um2)
            .sum();
        let more = area("gu.banks = 64").unwrap();
        assert!(
            (more - paper - mft).abs() < 1e-6 * more,
            "{more} {paper} {mft}"
        );
        let error = area("mvoxel.rows = 500").unwrap_err();
        assert!(
            error.contains("mft_bank, 500 words of 16 bits, is not among"),
            "{error}"
        );
    }
}
