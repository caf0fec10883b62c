//! The whole comparison.

use potamoi_scene::{Model, Scene};
use schemars::JsonSchema;
use serde::Serialize;

use crate::error::SpeedError;
use crate::fields;
use crate::machine::{Busy, Machine, TimeSource, Tool};
use crate::row::{Row, Section};
use crate::sizes::Sizes;
use crate::splats;
use crate::time::Meter;
use crate::units::{self, Units};
use crate::verification;

/// What to compare.
#[derive(Debug, Clone)]
pub struct Options {
    /// Sections to measure; each is measured once, in their own order.
    pub sections: Vec<Section>,
    /// Runs of each work, of which the fastest counts; at least 1.
    pub runs: u32,
    /// A scene of the user's: of Gaussians in [`Section::Splats`], of a field in [`Section::Fields`].
    pub scene: Option<Scene>,
}

impl Options {
    fn has(&self, section: Section) -> bool {
        self.sections.contains(&section)
    }

    /// Whether the C++ testbenches are measured: verification is held to them.
    fn runs_units(&self) -> bool {
        self.has(Section::Units) || self.has(Section::Verify)
    }

    /// Checks before any work that the user's scene is of a section that is measured.
    ///
    /// # Errors
    /// It is not.
    pub fn check(&self) -> Result<(), SpeedError> {
        let Some(scene) = &self.scene else {
            return Ok(());
        };
        let wrong = |found, expected| {
            Err(SpeedError::Kind {
                scene: scene.name().to_owned(),
                found,
                expected,
            })
        };
        match scene.model() {
            Model::Splats(_) if self.has(Section::Splats) => Ok(()),
            Model::Field(_) if self.has(Section::Fields) => Ok(()),
            Model::Splats(_) => wrong(
                "Gaussians, which are measured in the section splats",
                "that section (--only splats), or no scene",
            ),
            Model::Field(_) => wrong(
                "a field, which is measured in the section fields",
                "that section (--only fields), or no scene",
            ),
            Model::Compact(_) => wrong(
                "Gaussians coloured by a field, which no section measures",
                "a model of Gaussians or of a field",
            ),
        }
    }

    /// Number of steps that [`compare`] tells.
    #[must_use]
    pub fn steps(&self) -> u64 {
        let own = self.scene.as_ref();
        let parts = [
            (self.has(Section::Splats), splats::steps(own)),
            (self.has(Section::Fields), fields::steps(own)),
            (self.runs_units(), units::STEPS),
            (self.has(Section::Verify), verification::STEPS),
        ];
        let asked = parts.iter().filter(|(is_asked, _)| *is_asked);
        asked.map(|(_, steps)| steps).sum()
    }
}

/// What was measured on a machine.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Comparison {
    /// The machine.
    pub machine: Machine,
    /// Tools and peers of the sections.
    pub tools: Vec<Tool>,
    /// Where processor times come from. Those of units are the C library's, of the whole process.
    pub times: TimeSource,
    /// How busy the machine was.
    pub busy: Busy,
    /// Runs of each work, of which the fastest counts.
    pub runs: u32,
    /// The figures.
    pub rows: Vec<Row>,
}

/// Measures; `begin` is told what each step measures when it begins.
///
/// # Errors
/// A scene that cannot be opened or rendered, or is of no section that is measured. A tool that is
/// missing is told in the rows that need it.
pub fn compare(options: &Options, begin: &mut dyn FnMut(&str)) -> Result<Comparison, SpeedError> {
    compare_at(&Sizes::FULL, options, begin)
}

/// As [`compare`], for work of other sizes.
fn compare_at(
    sizes: &Sizes,
    options: &Options,
    begin: &mut dyn FnMut(&str),
) -> Result<Comparison, SpeedError> {
    options.check()?;
    let (runs, own) = (options.runs.max(1), options.scene.as_ref());
    let mut meter = Meter::default();
    let (mut rows, mut tools) = (vec![], vec![]);
    if options.has(Section::Splats) {
        rows.extend(splats::rows(sizes, runs, own, &mut meter, begin)?);
    }
    if options.has(Section::Fields) {
        let (found, jax) = fields::rows(sizes, runs, own, &mut meter, begin)?;
        rows.extend(found);
        tools.push(jax);
    }
    if options.runs_units() {
        let units = Units::measure(sizes, runs, begin)?;
        tools.extend(units.tools());
        if options.has(Section::Units) {
            rows.extend(units.rows());
        }
        if options.has(Section::Verify) {
            rows.push(verification::row(sizes, runs, &units, &mut meter, begin)?);
        }
    }
    Ok(Comparison {
        machine: Machine::here(),
        tools,
        times: match meter.is_elapsed() {
            true => TimeSource::ElapsedTimesThreads,
            false => TimeSource::Threads,
        },
        busy: Busy::of(&meter),
        runs,
        rows,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::config::Config;

    use super::*;

    const TINY: Sizes = Sizes {
        peak_rounds: 1_200,
        peak_runs: 1,
        dense: 16,
        garden: 16,
        fields: 8,
        units: 8,
        stimulus: [50, 200],
        verify: 8,
        config: || Config::preset("small").unwrap(),
    };

    fn run(sections: &[Section], scene: Option<&str>) -> Comparison {
        let scene = scene.map(|name| {
            let mut scene = Scene::open(name).unwrap();
            scene.set_size(Some(8), None).unwrap();
            scene
        });
        let options = Options {
            sections: sections.to_vec(),
            runs: 1,
            scene,
        };
        let mut steps = 0;
        let found = compare_at(&TINY, &options, &mut |_| steps += 1).unwrap();
        keeps_to_its_schema(&found);
        if found.tools.iter().all(|tool| tool.version.is_some()) {
            assert_eq!(steps, options.steps());
        }
        found
    }

    fn keeps_to_its_schema(found: &Comparison) {
        let settings = schemars::generate::SchemaSettings::draft2020_12().for_serialize();
        let schema = settings
            .into_generator()
            .into_root_schema_for::<Comparison>();
        let validator = jsonschema::validator_for(&schema.into()).unwrap();
        let report = serde_json::to_value(found).unwrap();
        let faults: Vec<_> = validator
            .iter_errors(&report)
            .map(|f| f.to_string())
            .collect();
        assert_eq!(faults, Vec::<String>::new());
    }

    /// Every figure that is there is a time; every other one has its reason.
    fn is_whole(row: &Row) {
        let figures = [
            (row.measured, &row.why),
            (row.beside.value, &row.beside.why),
        ];
        for (value, why) in figures {
            assert_ne!(value.is_some(), why.is_some(), "{row:?}");
            assert!(value.is_none_or(|value| value > 0.0), "{row:?}");
        }
        let both = row.measured.zip(row.beside.value);
        let ratio = both.map(|(measured, beside)| measured / beside);
        assert_eq!(row.ratio, ratio, "{row:?}");
    }

    #[test]
    fn splats_are_compared_on_each_level_of_vectors() {
        let found = run(&[Section::Splats], Some("garden"));
        found.rows.iter().for_each(is_whole);
        let levels = found.machine.vectors.len();
        assert_eq!(found.rows.len(), 3 * levels);
        let widest = found.machine.vectors.last().unwrap();
        assert_eq!(found.rows[0].what, format!("dense 16 x 16, {widest}"));
        assert!(
            found
                .rows
                .iter()
                .all(|row| row.measured.is_some() && row.ratio.is_some())
        );
        assert!(found.tools.is_empty());
    }

    #[test]
    fn fields_are_compared_with_jax_or_say_why_not() {
        let found = run(&[Section::Fields], Some("lantern"));
        found.rows.iter().for_each(is_whole);
        let names: Vec<&str> = found.rows.iter().map(|row| &*row.what).collect();
        assert_eq!(names.len(), 5, "{names:?}");
        assert!(names[0].starts_with("cairn:dvgo 8 x "), "{names:?}");
        let jax = &found.tools[0];
        assert_eq!(jax.name, "JAX");
        // Both of its models, or what to install.
        let figures = found.rows.iter().filter(|row| row.ratio.is_some()).count();
        match &jax.why {
            None => assert_eq!(figures, 2),
            Some(why) => assert!(figures == 0 && why.contains("pip install jax"), "{why}"),
        }
    }

    /// Half a minute of Verilator and the compiler where no model is kept.
    #[test]
    #[ignore = "exhaustive; run with make test-full"]
    fn units_and_verification_are_held_to_the_cpp_testbench_or_say_why_not() {
        let found = run(&[Section::Verify, Section::Units], None);
        found.rows.iter().for_each(is_whole);
        let sections: Vec<Section> = found.rows.iter().map(|row| row.section).collect();
        assert_eq!(sections, [Section::Units, Section::Units, Section::Verify]);
        let found = run(&[Section::Verify], None);
        assert_eq!(found.rows.len(), 1);
    }

    #[test]
    fn a_scene_of_no_section_is_refused() {
        let refused = |name: &str, sections: &[Section]| {
            let options = Options {
                sections: sections.to_vec(),
                runs: 1,
                scene: Some(Scene::open(name).unwrap()),
            };
            options.check().unwrap_err().to_string()
        };
        let said = refused("garden", &[Section::Units]);
        assert!(
            said.contains("garden: Gaussians, which are measured in the section splats"),
            "{said}"
        );
        let said = refused("lantern", &[Section::Splats]);
        assert!(said.contains("the section fields"), "{said}");
        let said = refused("cairn:compact", &Section::ALL);
        assert!(said.contains("no section measures"), "{said}");
    }
}
