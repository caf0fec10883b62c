//! Sweep over every setting of every knob, one at a time.

use schemars::JsonSchema;
use serde::Serialize;

use super::bench::Bench;
use super::knobs::Knob;
use super::pareto_front::{CostQuality, front, knee};
use super::point::Point;
use super::references::Reference;
use crate::system::Rung;
use crate::{ExploreError, Progress};

/// Largest loss against the default, in dB, that counts as equal quality.
const EQUAL_DB: f64 = 0.1;

/// Measurements of a scene's knobs, one setting at a time.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Sweep {
    /// The scene's name.
    pub scene: String,
    /// The model's algorithm.
    pub algorithm: &'static str,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// What quality is measured against.
    pub reference: Reference,
    /// Hash of the default's configuration, as hexadecimal digits.
    pub configuration: String,
    /// Points; the default is first.
    pub points: Vec<Point>,
    /// Refused settings with the reasons.
    pub refused: Vec<Refused>,
    /// The Pareto front: indices of points by rising time.
    pub front: Vec<usize>,
    /// Index of the knee of the front.
    pub knee: Option<usize>,
    /// Accuracy of the time model: formulas, cycle models and the Verilated units; empty where it was
    /// not asked for.
    pub ladder: Vec<Rung>,
    /// Result of a search, if one was run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found: Option<SearchResult>,
}

/// A setting that cannot be applied.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Refused {
    /// The knob's name.
    pub knob: &'static str,
    /// The setting's label.
    pub setting: String,
    /// The reason, in a user's words.
    pub why: String,
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SearchResult {
    /// Knobs and labels of its settings.
    pub settings: Vec<String>,
    /// Measurements of all settings together.
    pub point: Point,
    /// Combinations that were tried in addition to single settings.
    pub tried: usize,
}

impl Sweep {
    /// Measures the default and each setting alone, one step each. Settings that cannot be applied
    /// are listed. The ladder is empty.
    ///
    /// # Errors
    /// The default cannot be rendered or modelled.
    pub fn of(
        bench: &Bench,
        knobs: &[Knob],
        progress: &dyn Progress,
    ) -> Result<Self, ExploreError> {
        let count: usize = knobs.iter().map(|knob| knob.settings.len()).sum();
        progress.expect(count as u64 + 1);
        let mut points = vec![bench.point("default", "", &[])?];
        progress.advance(1);
        let mut refused = vec![];
        for knob in knobs {
            progress.now(knob.name);
            turn(bench, knob, &mut points, &mut refused, progress);
        }
        let places: Vec<CostQuality> = points.iter().map(Point::place).collect();
        let front = front(&places);
        let scene = &bench.setup.scene;
        Ok(Self {
            scene: scene.name().to_owned(),
            algorithm: scene.model().algorithm(),
            size: [scene.camera().width, scene.camera().height],
            reference: bench.references.described(),
            configuration: bench.setup.config.hash(),
            knee: knee(&places, &front),
            front,
            points,
            refused,
            ladder: vec![],
            found: None,
        })
    }

    /// The default, the baseline of all others.
    #[must_use]
    pub fn default_point(&self) -> &Point {
        &self.points[0]
    }

    /// A knob's fastest setting with the default's quality, otherwise the one that loses least, and
    /// its loss against the default in dB; `None` where no setting could be applied.
    #[must_use]
    pub fn best_setting(&self, knob: &str) -> Option<(&Point, f64)> {
        let default = self.default_point().place().quality;
        let lost = |point: &Point| match point.place().quality {
            // Both are equal to what they are compared with.
            own if own == default => 0.0,
            own => default - own,
        };
        let own = || self.points.iter().filter(|p| p.knob == knob);
        let within = |most: f64| {
            let all = own().filter(|p| lost(p) <= most);
            all.min_by(|a, b| a.frame_ns.total_cmp(&b.frame_ns))
        };
        let least = own().map(lost).fold(f64::INFINITY, f64::min);
        let point = within(EQUAL_DB).or_else(|| within(least + EQUAL_DB))?;
        Some((point, lost(point)))
    }
}

/// Measures each setting of a knob alone, or records why it is refused.
fn turn(
    bench: &Bench,
    knob: &Knob,
    points: &mut Vec<Point>,
    refused: &mut Vec<Refused>,
    progress: &dyn Progress,
) {
    for setting in &knob.settings {
        match bench.point(knob.name, &setting.label, &[setting]) {
            Ok(point) => points.push(point),
            Err(error) => refused.push(Refused {
                knob: knob.name,
                setting: setting.label.clone(),
                why: error.to_string(),
            }),
        }
        progress.advance(1);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::knobs::{self, Change, RenderChange, Setting};
    use super::*;
    use crate::{ConfigChoice, Setup};
    use potamoi_base::precision::Precision;
    use potamoi_scene::Scene;
    use potamoi_system::system_model::System;

    /// A knob added as docs/adding/knob.md says is measured, reported and refused like others.
    #[test]
    fn an_added_knob_is_measured_like_the_others() {
        let mut scene = Scene::open("garden").unwrap();
        scene.set_size(Some(16), Some(16)).unwrap();
        let setup = Setup::new(
            ConfigChoice::for_scene(&scene).unwrap(),
            &System::default(),
            scene,
            None,
        )
        .unwrap();
        let bits = |n: u32| Setting {
            label: n.to_string(),
            change: Change::Scene(RenderChange::Precision(Precision {
                transmittance_bits: Some(n),
                ..Precision::default()
            })),
        };
        let added = Knob {
            name: "added",
            what: "a knob of this test",
            settings: vec![bits(8), bits(20), bits(99)],
        };
        let mut knobs = knobs::of(&setup.scene);
        knobs.push(added);
        let knobs = knobs::named(knobs, &["added".to_owned()]).unwrap();
        let bench = Bench::new(setup, 2).unwrap();
        let default = bench.point("default", "", &[]).unwrap();
        let (mut points, mut refused) = (vec![], vec![]);
        turn(&bench, &knobs[0], &mut points, &mut refused, &());
        let db = |point: &Point| point.converged.db.unwrap();
        assert_eq!(points.len(), 2);
        assert!(db(&points[0]) < db(&default) - 3.0, "{}", db(&points[0]));
        assert_eq!(db(&points[1]).to_bits(), db(&default).to_bits());
        assert_eq!((refused[0].knob, &*refused[0].setting), ("added", "99"));
        assert!(
            refused[0].why.contains("transmittance_bits"),
            "{}",
            refused[0].why
        );
    }
}
