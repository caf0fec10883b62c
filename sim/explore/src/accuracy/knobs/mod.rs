//! Knobs that trade accuracy for cost, each with its settings.

mod exponential;
mod rendering;

use potamoi_base::effects::Effect;
use potamoi_base::precision::Precision;
use potamoi_scene::Scene;
use potamoi_splats::{Order, Profile};
use thiserror::Error;

use self::exponential::exponential;
use self::rendering::{interpolation, left_out, splatting, stops, transmittances};
use crate::ExploreError;

/// A knob: one parameter with several settings.
#[derive(Debug, Clone, PartialEq)]
pub struct Knob {
    /// Name on the command line.
    pub name: &'static str,
    /// Description, a short phrase.
    pub what: &'static str,
    /// All settings except the default.
    pub settings: Vec<Setting>,
}

/// A setting of a knob, other than the default.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Label, unique within the knob; it ends with the number that it sets, if any.
    pub label: String,
    /// The change that it makes.
    pub change: Change,
}

/// Change made by a setting.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    /// A change of the configuration.
    Config {
        /// Keys that are first reset to their derived values.
        derived: &'static [&'static str],
        /// TOML that overrides the rest.
        toml: String,
    },
    /// A change of how the scene is rendered.
    Scene(RenderChange),
    /// A change of how the frames of a path are rendered.
    Path(PathVariant),
}

/// Change of how a scene is rendered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RenderChange {
    /// Order of Gaussians.
    Order(Order),
    /// Rasteriser profile.
    Profile(Profile),
    /// Sampling step in voxel edges.
    Step(f64),
    /// Numeric precision; overrides the scene's own.
    Precision(Precision),
    /// Leaves out an effect.
    Without(Effect),
}

impl RenderChange {
    /// Applies the change to a scene.
    ///
    /// # Errors
    /// A value that the scene's model does not support.
    pub fn apply(self, scene: &mut Scene) -> Result<(), ExploreError> {
        match self {
            Self::Order(order) => scene.set_order(order),
            Self::Profile(profile) => scene.set_profile(profile),
            Self::Step(step) => scene.set_step(step)?,
            Self::Precision(own) => scene.set_precision(scene.precision().and(own))?,
            Self::Without(effect) => scene.set_choices(scene.choices().leave_out(effect)),
        }
        Ok(())
    }
}

/// How other commands reproduce a change outside the configuration.
#[derive(Debug, Clone, PartialEq)]
pub enum Reproduce {
    /// Lines of `[render]`, in a scene description or a machine's file.
    Render(Vec<String>),
    /// An effect that `[render]` of a machine's file leaves out.
    Without(String),
    /// Lines of `[path]` in a machine's file.
    Path(Vec<String>),
}

impl Change {
    /// How other commands reproduce the change; `None` for changes of the configuration.
    #[must_use]
    pub(crate) fn reproduce(&self) -> Option<Reproduce> {
        Some(match self {
            Self::Config { .. } => return None,
            Self::Scene(RenderChange::Order(order)) => Reproduce::Render(vec![format!(
                "order = {:?}",
                match order {
                    Order::Exact => "exact",
                    Order::Approximate => "approximate",
                }
            )]),
            Self::Scene(RenderChange::Profile(own)) => {
                Reproduce::Render(vec![format!("profile = {:?}", own.name())])
            }
            Self::Scene(RenderChange::Step(step)) => {
                Reproduce::Render(vec![format!("step = {step}")])
            }
            Self::Scene(RenderChange::Precision(own)) => {
                let given = own.given().into_iter();
                Reproduce::Render(given.map(|(name, v)| format!("{name} = {v}")).collect())
            }
            Self::Scene(RenderChange::Without(effect)) => Reproduce::Without(effect.to_string()),
            Self::Path(PathVariant::Warped { window, phi }) => {
                let phi = phi.map(|phi| format!("phi = {phi:?}"));
                let lines = [
                    "variant = \"potamoi\"".to_owned(),
                    format!("window = {window}"),
                ];
                Reproduce::Path(lines.into_iter().chain(phi).collect())
            }
            Self::Path(PathVariant::Chained { window }) => {
                let lines = [
                    "variant = \"temp\"".to_owned(),
                    format!("window = {window}"),
                ];
                Reproduce::Path(lines.to_vec())
            }
            Self::Path(PathVariant::Half) => Reproduce::Path(vec!["variant = \"ds2\"".to_owned()]),
        })
    }
}

/// How the frames of a path are rendered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathVariant {
    /// Warped from references.
    Warped {
        /// Window: frames served by a reference.
        window: u32,
        /// Largest angle in degrees between the rays of a warped point; `None`: no limit.
        phi: Option<f64>,
    },
    /// Each warped from the frame before (Temp-N).
    Chained {
        /// Window, whose first frame is rendered in full.
        window: u32,
    },
    /// At half the resolution, upscaled (DS-2).
    Half,
}

/// Widths of the engine that are derived from its other numbers.
const WIDTHS: &[&str] = &["accumulator_bits", "constant_bits", "offset"];

fn config(label: impl Into<String>, toml: impl Into<String>) -> Setting {
    Setting {
        label: label.into(),
        change: Change::Config {
            derived: &[],
            toml: toml.into(),
        },
    }
}

/// A setting of the exponential engine with derived widths.
fn exp(label: impl Into<String>, toml: impl Into<String>) -> Setting {
    Setting {
        label: label.into(),
        change: Change::Config {
            derived: WIDTHS,
            toml: format!("[vu.exp]\n{}", toml.into()),
        },
    }
}

fn rendered(label: &str, change: RenderChange) -> Setting {
    Setting {
        label: label.to_owned(),
        change: Change::Scene(change),
    }
}

fn path(label: String, variant: PathVariant) -> Setting {
    Setting {
        label,
        change: Change::Path(variant),
    }
}

/// The knobs of a scene.
#[must_use]
pub fn of(scene: &Scene) -> Vec<Knob> {
    let splats = scene.model().is_splats();
    let mut knobs = exponential();
    if splats {
        knobs.extend(splatting());
    } else {
        knobs.extend(interpolation());
    }
    knobs.push(stops(scene));
    if scene.model().numbers().honour("transmittance_bits") {
        knobs.push(transmittances());
    }
    knobs.extend(left_out(scene));
    if scene.model().has_step() {
        let steps = [0.25, 0.625, 0.75, 1.0, 1.5, 2.0];
        knobs.push(Knob {
            name: "step",
            what: "voxel edges from sample to sample",
            settings: steps
                .map(|s| rendered(&s.to_string(), RenderChange::Step(s)))
                .to_vec(),
        });
    }
    knobs.extend(paths());
    knobs
}

fn paths() -> Vec<Knob> {
    let windows = [2, 4, 6, 8, 16];
    let angles = [1.0, 2.0, 4.0];
    let warped = |window, phi| PathVariant::Warped { window, phi };
    vec![
        Knob {
            name: "window",
            what: "frames that are warped from a reference (SpaRW)",
            settings: windows
                .map(|n| path(format!("{n}"), warped(n, None)))
                .to_vec(),
        },
        Knob {
            name: "phi",
            what: "the largest angle that is warped, in degrees, at up to 16 frames a reference",
            settings: angles
                .map(|d| path(format!("{d}"), warped(16, Some(d))))
                .to_vec(),
        },
        Knob {
            name: "chained",
            what: "each frame warped from the previous one, one frame in N rendered in full \
                   (Temp-N)",
            settings: [6, 16]
                .map(|window| path(format!("{window}"), PathVariant::Chained { window }))
                .to_vec(),
        },
        Knob {
            name: "resolution",
            what: "half the width and height, scaled up (DS-2)",
            settings: vec![path("half".to_owned(), PathVariant::Half)],
        },
    ]
}

/// A name that none of a scene's knobs has.
#[derive(Debug, Error)]
#[error("{name}: expected some of {known}")]
pub struct UnknownKnob {
    name: String,
    /// Known names, separated by commas.
    known: String,
}

/// Selects knobs by name; all of them without names.
///
/// # Errors
/// A name that no knob has.
pub fn named(all: Vec<Knob>, names: &[String]) -> Result<Vec<Knob>, UnknownKnob> {
    let known = all.iter().map(|knob| knob.name).collect::<Vec<_>>();
    if let Some(unknown) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(UnknownKnob {
            name: unknown.clone(),
            known: known.join(", "),
        });
    }
    let is_wanted = |knob: &Knob| names.is_empty() || names.iter().any(|name| name == knob.name);
    Ok(all.into_iter().filter(is_wanted).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Scenes of splats and of voxels have a dozen knobs each, none twice.
    #[test]
    fn every_scene_has_a_dozen_knobs() {
        for name in ["garden", "lantern", "cairn:voxels"] {
            let mut names: Vec<&str> = of(&Scene::open(name).unwrap())
                .iter()
                .map(|k| k.name)
                .collect();
            assert!(names.len() >= 12, "{name}: {names:?}");
            names.sort_unstable();
            names.dedup();
            assert!(names.len() >= 12, "{name}: {names:?}");
        }
    }

    /// No two settings of a knob make the same change, and each sets the number in its label.
    #[test]
    fn every_setting_changes_something_else() {
        for name in ["garden", "cairn:voxels", "cairn:ngp", "cairn:dvgo"] {
            let scene = Scene::open(name).unwrap();
            for knob in of(&scene) {
                for (i, own) in knob.settings.iter().enumerate() {
                    let told = format!("{name}: {} {}", knob.name, own.label);
                    for other in &knob.settings[..i] {
                        assert_ne!(own.change, other.change, "{told}, {}", other.label);
                        assert_ne!(own.label, other.label, "{told}");
                    }
                    let text = match &own.change {
                        Change::Config { toml, .. } => toml.clone(),
                        Change::Scene(RenderChange::Precision(precision)) => {
                            let given = precision.given();
                            assert_eq!(given.len(), 1, "{told}");
                            given[0].1.clone()
                        }
                        _ => continue,
                    };
                    let last = own.label.split(' ').next_back().unwrap();
                    if let Ok(number) = last.parse::<f64>() {
                        let mut numbers = text.split(|c: char| !c.is_ascii_digit() && c != '.');
                        assert!(
                            numbers.any(|n| n.parse() == Ok(number))
                                || text.ends_with(&format!(".{last}\"")),
                            "{told}: {text}"
                        );
                    }
                }
            }
        }
    }

    /// Lines of a description that a search writes give the scene that it measured.
    #[test]
    fn lines_of_a_description_set_what_the_knob_set() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        for (name, model) in [
            ("garden", "name = \"garden\""),
            ("cairn:ngp", "name = \"cairn\"\nrepresentation = \"ngp\""),
        ] {
            let scene = Scene::open(name).unwrap();
            let mut count = 0;
            for setting in of(&scene).iter().flat_map(|knob| &knob.settings) {
                let (Change::Scene(look), Some(Reproduce::Render(lines))) =
                    (&setting.change, setting.change.reproduce())
                else {
                    continue;
                };
                let mut set = scene.clone();
                look.apply(&mut set).unwrap();
                let text = format!("[model]\nkind = \"builtin\"\n{model}\n[render]\n");
                std::fs::write(&path, text + &lines.join("\n")).unwrap();
                let read = Scene::open(&path.to_string_lossy()).unwrap();
                let rules = |s: &Scene| {
                    let mut parts = s.identity();
                    let kept = ["precision", "profile", "order", "step"];
                    parts.retain(|(part, _)| kept.contains(part));
                    parts
                };
                assert_ne!(rules(&set), rules(&scene), "{name}: {lines:?}");
                assert_eq!(rules(&set), rules(&read), "{name}: {lines:?}");
                count += 1;
            }
            assert!(count >= 5, "{name}: {count}");
        }
    }

    #[test]
    fn unknown_knobs_are_refused_by_name() {
        let garden = || of(&Scene::open("garden").unwrap());
        let error = named(garden(), &["tails".to_owned()])
            .err()
            .unwrap()
            .to_string();
        assert!(
            error.contains("tails") && error.contains("tail, radix-4"),
            "{error}"
        );
        assert_eq!(named(garden(), &["tail".to_owned()]).unwrap().len(), 1);
    }
}
