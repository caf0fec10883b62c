//! Pictures that quality is measured against.

use potamoi_base::picture::Picture;
use potamoi_scene::{Converged, Halvings, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::image_quality::ImageQuality;
use crate::ExploreError;

/// The picture that quality, front, knee and goals of a search are measured against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReferenceKind {
    /// The analytic field that the model was sampled from.
    Truth,
    /// The model itself, without approximations of its renderer.
    Converged,
}

impl ReferenceKind {
    /// The words in a sentence.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Truth => "the ground truth",
            Self::Converged => "the converged picture",
        }
    }

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Truth => "truth",
            Self::Converged => "converged",
        }
    }
}

/// Description of a scene's references for reports.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Reference {
    /// The one that counts: the truth where it is known.
    pub kind: ReferenceKind,
    /// How the converged picture was rendered.
    pub converged: Convergence,
}

/// How a converged picture was rendered.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Convergence {
    /// The rules, in words.
    pub how: &'static str,
    /// How its step was found; `None` where the model has none that a setting changes.
    pub steps: Option<Halvings>,
}

impl Convergence {
    /// A sentence for a table.
    #[must_use]
    pub fn words(&self) -> String {
        let Some(steps) = self.steps else {
            return self.how.to_owned();
        };
        let db = |change: f64| -20.0 * change.log10();
        format!(
            "{}, steps of 1/{} voxel edge: halved {} times, {:.1} dB from the step before{}",
            self.how,
            1.0 / steps.step,
            steps.halvings,
            db(steps.change),
            match steps.is_within() {
                true => String::new(),
                false => format!(
                    ", which is less than the {:.1} dB of a converged step",
                    db(steps.bound)
                ),
            }
        )
    }
}

/// The references of a scene, rendered.
#[derive(Debug, Clone)]
pub struct References {
    truth: Option<Picture>,
    converged: Converged,
    how: &'static str,
}

impl References {
    /// Renders the ground truth, where it is known, and the converged picture. Settings of the
    /// scene that trade accuracy for time do not change them.
    ///
    /// # Errors
    /// A scene that cannot be rendered.
    pub fn of(scene: &Scene) -> Result<Self, ExploreError> {
        let splats = scene.model().is_splats();
        Ok(Self {
            truth: match scene.analytic() {
                Some(_) => Some(scene.render_truth()?.picture),
                None => None,
            },
            converged: scene.render_converged()?,
            how: match splats {
                true => "no early termination, exact order, rules of the original rasteriser",
                false => "no early termination",
            },
        })
    }

    /// The picture that counts: the truth, or the converged one where the truth is not known.
    #[must_use]
    pub fn picture(&self) -> &Picture {
        self.truth.as_ref().unwrap_or(&self.converged.picture)
    }

    /// Quality of a picture against the truth, where it is known.
    #[must_use]
    pub fn truth(&self, shown: &Picture) -> Option<ImageQuality> {
        (self.truth.as_ref()).map(|truth| ImageQuality::of(shown, truth))
    }

    /// Quality of a picture against the converged one.
    #[must_use]
    pub fn converged(&self, shown: &Picture) -> ImageQuality {
        ImageQuality::of(shown, &self.converged.picture)
    }

    /// Description for reports.
    #[must_use]
    pub fn described(&self) -> Reference {
        Reference {
            kind: match self.truth {
                Some(_) => ReferenceKind::Truth,
                None => ReferenceKind::Converged,
            },
            converged: Convergence {
                how: self.how,
                steps: self.converged.steps,
            },
        }
    }
}
