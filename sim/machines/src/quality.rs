//! Quality of a machine's picture beside one reference a scene.
// The error is that of the studies that are called here; it is rare, and boxed by the caller.
#![allow(clippy::result_large_err)]

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use potamoi_base::content_hash::hash_of;
use potamoi_explore::accuracy::{self, ReferenceKind};
use potamoi_explore::{ExploreError, Setup};
use potamoi_reference::ReferenceUnits;
use potamoi_scene::Scene;
use potamoi_system::system_model::work::{PathWork, Quality};
use potamoi_system::system_model::{Frames, Variant};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Quality of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PictureQuality {
    /// The reference: the truth, or the converged picture where the truth is not known.
    pub beside: ReferenceKind,
    /// PSNR in dB, from the mean squared error over all pixels and channels, peak 1; `None` where the
    /// pictures are equal.
    pub db: Option<f64>,
}

impl PictureQuality {
    /// The quality of a path's frames: that of a full frame in the hardware's formats, moved by what
    /// the variant changes in floating point. Squared errors beside the converged picture are
    /// added; beside the truth the difference in dB is.
    #[must_use]
    pub fn along(self, path: &PathWork, variant: Variant) -> Self {
        let moved = match variant.frames {
            Frames::Full => return self,
            Frames::Half => path.half_quality,
            Frames::Warped => path.warped_quality,
            Frames::Chained => path.chained_quality,
        };
        let db = match self.beside {
            ReferenceKind::Converged => sum_of_errors(self.db, moved.full_db),
            ReferenceKind::Truth => shifted(self.db, moved, path.full_quality),
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

/// References of scenes, each rendered once.
#[derive(Default)]
pub(crate) struct References(Mutex<HashMap<blake3::Hash, Arc<accuracy::References>>>);

/// Version of the comparison, raised where its results change.
const VERSION: &str = "2";

impl References {
    /// The quality of the frame that a setup's scene shows through reference units, beside the
    /// reference of the same scene without the machine's settings.
    pub(crate) fn frame(
        &self,
        setup: &Setup,
        plain: &Scene,
    ) -> Result<PictureQuality, ExploreError> {
        let quality = setup.of_frame(KIND, &[beside(plain)], || {
            let references = self.of(plain)?;
            let mut units = ReferenceUnits::new(&setup.config);
            let shown = setup.scene.render_fixed(&setup.config, &mut units)?.picture;
            let beside = references.described().kind;
            let own = match references.truth(&shown) {
                Some(own) => own,
                None => references.converged(&shown),
            };
            Ok::<_, ExploreError>(PictureQuality { beside, db: own.db })
        })?;
        Ok(*quality)
    }

    /// Name of the file that the quality of a setup's frame is kept in.
    pub(crate) fn file(setup: &Setup, plain: &Scene) -> String {
        setup.file_of_frame(KIND, &[beside(plain)])
    }

    fn of(&self, plain: &Scene) -> Result<Arc<accuracy::References>, ExploreError> {
        let key = identity_of(plain);
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().get(&key) {
            return Ok(Arc::clone(known));
        }
        let own = Arc::new(accuracy::References::of(plain)?);
        Ok(Arc::clone(lock().entry(key).or_insert(own)))
    }
}

/// Names of the cached result, and of its key's part for the reference picture.
const KIND: &str = "picture-quality";

fn beside(plain: &Scene) -> (&'static str, blake3::Hash) {
    ("beside", hash_of(&(VERSION, identity_of(plain).as_bytes())))
}

/// Hash of all that a scene's picture depends on.
#[must_use]
pub fn identity_of(scene: &Scene) -> blake3::Hash {
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
