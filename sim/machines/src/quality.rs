//! Quality of a machine's picture beside one reference a scene.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use potamoi_base::content_hash::hash_of;
use potamoi_base::effects::Choices;
use potamoi_base::picture::Picture;
use potamoi_explore::{ExploreError, Setup};
use potamoi_reference::ReferenceUnits;
use potamoi_scene::Scene;
use potamoi_system::system_model::work::{PathWork, Quality};
use potamoi_system::system_model::{Frames, Variant};
use serde::{Deserialize, Serialize};

/// What a picture is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Beside {
    /// The ground truth that the model was sampled from.
    Truth,
    /// The model in floating point with the scene's own settings, whatever the machine's are.
    Model,
}

impl Beside {
    /// The word in CSV and JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Truth => "truth",
            Self::Model => "model",
        }
    }

    /// The words in tables.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Truth => "the ground truth",
            Self::Model => "the model in floating point",
        }
    }
}

/// Quality of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PictureQuality {
    /// The reference.
    pub beside: Beside,
    /// PSNR in dB, from the mean squared error over all pixels and channels, peak 1; `None` where the
    /// pictures are equal.
    pub db: Option<f64>,
}

impl PictureQuality {
    /// The quality of a path's frames: that of a full frame in the hardware's formats, moved by what
    /// the variant changes in floating point. Squared errors beside the model are added; beside the
    /// truth the difference in dB is.
    #[must_use]
    pub fn along(self, path: &PathWork, variant: Variant) -> Self {
        let moved = match variant.frames {
            Frames::Full => return self,
            Frames::Half => path.half_quality,
            Frames::Warped => path.warped_quality,
            Frames::Chained => path.chained_quality,
        };
        let db = match self.beside {
            Beside::Model => sum_of_errors(self.db, moved.model_db),
            Beside::Truth => shifted(self.db, moved, path.full_quality),
        };
        Self { db, ..self }
    }
}

fn sum_of_errors(one: Option<f64>, other: Option<f64>) -> Option<f64> {
    let error = |db: Option<f64>| db.map_or(0.0, |db| 10f64.powf(-0.1 * db));
    let sum = error(one) + error(other);
    (sum > 0.0).then(|| -10.0 * sum.log10())
}

fn shifted(own: Option<f64>, moved: Quality, full: Quality) -> Option<f64> {
    Some(own? + moved.truth_db? - full.truth_db?)
}

/// Pictures that scenes are compared with, each rendered once.
#[derive(Default)]
pub(crate) struct References(Mutex<HashMap<blake3::Hash, Arc<Picture>>>);

/// Version of the comparison, raised where its results change.
const VERSION: &str = "1";

impl References {
    /// The quality of the frame that a setup's scene shows through reference units, beside the
    /// reference of the same scene without the machine's settings.
    pub(crate) fn frame(
        &self,
        setup: &Setup,
        plain: &Scene,
    ) -> Result<PictureQuality, ExploreError> {
        let identity = hash_of(&(VERSION, identity_of(plain).as_bytes()));
        let quality = setup.of_frame("picture-quality", &[("beside", identity)], || {
            let reference = self.of(plain)?;
            let mut units = ReferenceUnits::new(&setup.config);
            let shown = setup.scene.render_fixed(&setup.config, &mut units)?.picture;
            let db = shown.psnr(&reference, |_| true);
            Ok::<_, ExploreError>(PictureQuality {
                beside: beside(plain),
                db: db.filter(|db| db.is_finite()),
            })
        })?;
        Ok(*quality)
    }

    fn of(&self, plain: &Scene) -> Result<Arc<Picture>, ExploreError> {
        let key = identity_of(plain);
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().get(&key) {
            return Ok(Arc::clone(known));
        }
        let rendered = match beside(plain) {
            Beside::Truth => plain.render_truth()?,
            Beside::Model => {
                let mut whole = plain.clone();
                whole.set_choices(Choices::default());
                whole.render_float()?
            }
        };
        let own = Arc::new(rendered.picture);
        Ok(Arc::clone(lock().entry(key).or_insert(own)))
    }
}

const fn beside(scene: &Scene) -> Beside {
    match scene.analytic() {
        Some(_) => Beside::Truth,
        None => Beside::Model,
    }
}

/// Hash of all that a scene's picture depends on.
pub(crate) fn identity_of(scene: &Scene) -> blake3::Hash {
    let parts = scene.identity().into_iter();
    let parts: Vec<_> = parts.map(|(name, hash)| (name, *hash.as_bytes())).collect();
    hash_of(&parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_formats_and_of_warping_add_up() {
        assert_eq!(sum_of_errors(None, None), None);
        assert_eq!(sum_of_errors(Some(40.0), None), Some(40.0));
        let both = sum_of_errors(Some(40.0), Some(40.0));
        assert!((both.unwrap_or_default() - (40.0 - 10.0 * 2f64.log10())).abs() < 1e-9);
    }
}
