//! Workloads for the verification of hardware: a frame, or its trace.

use std::path::{Path, PathBuf};

use potamoi_formats::config::{Config, Sums};
use potamoi_reference::{ReferenceUnits, Units};
use potamoi_rtl::verify::Verifier;
use potamoi_scene::Scene;
use potamoi_scene::trace::Trace;

use crate::ExploreError;

/// Workload for verification.
pub enum Work {
    /// The frame that a scene's camera sees.
    Scene(Box<Scene>),
    /// A trace of a frame, with its file.
    Trace(PathBuf, Box<Trace>),
}

impl Work {
    /// The scene's name.
    #[must_use]
    pub fn scene(&self) -> &str {
        match self {
            Self::Scene(scene) => scene.name(),
            Self::Trace(_, trace) => &trace.scene,
        }
    }

    /// Items that agreement with the units of the configuration does not cover.
    #[must_use]
    pub fn not_checked(&self, config: &Config) -> Vec<String> {
        match self {
            Self::Scene(scene) => scene.not_checked(config),
            Self::Trace(..) => {
                vec!["all that lies outside the units: a trace holds their work alone".to_owned()]
            }
        }
    }

    /// Width and height in pixels; `None` for a trace.
    #[must_use]
    pub fn size(&self) -> Option<[u32; 2]> {
        match self {
            Self::Scene(scene) => Some([scene.camera().width, scene.camera().height]),
            Self::Trace(..) => None,
        }
    }

    /// Total feature vectors, elements of vector operations, and pixels of the splat unit.
    ///
    /// # Errors
    /// A scene that the configuration cannot render.
    pub fn counts(&self, config: &Config) -> Result<[u64; 3], ExploreError> {
        match self {
            Self::Scene(scene) => {
                let mut twins = ReferenceUnits::new(config);
                let frame = scene.render_fixed(config, &mut twins)?.counts;
                let elements = frame.elements.values().sum();
                Ok([frame.feature_vectors, elements, twins.counts().splat_pixels])
            }
            Self::Trace(_, trace) => {
                let entries = trace.gathered.iter().map(|g| g.task.entries.len() as u64);
                let elements = trace.computed.iter().map(|c| c.a.len() as u64);
                Ok([entries.sum(), elements.sum(), 0])
            }
        }
    }

    /// Sends the work through a verifier.
    ///
    /// # Errors
    /// A scene that cannot be rendered, a trace that differs from this version's golden values, or
    /// the verifier's first error.
    pub fn run(&self, config: &Config, verifier: &mut Verifier<'_>) -> Result<(), ExploreError> {
        let done = match self {
            Self::Scene(scene) => {
                let rendered = scene.render_fixed(config, verifier);
                rendered.map(|_| ()).map_err(ExploreError::from)
            }
            Self::Trace(path, trace) => replay(path, trace, verifier),
        };
        let finished = verifier.finish();
        done?;
        Ok(finished?)
    }
}

/// Sends a trace through units that also compute golden values, which must equal the trace's.
fn replay(path: &Path, trace: &Trace, units: &mut dyn Units) -> Result<(), ExploreError> {
    let differs = |what: &str| {
        ExploreError::Check(format!(
            "trace {}: its {what} differ from the golden model's: it was written by another \
             version of potamoi; write it again",
            path.display()
        ))
    };
    let tasks: Vec<_> = trace.gathered.iter().map(|g| g.task.clone()).collect();
    let mut features: Vec<i32> = vec![];
    match trace.sums {
        Sums::Exact => units.sums(&tasks, &mut features),
        Sums::Rounded => {
            let mut codes = vec![];
            let gathered = units.gather(&tasks, &mut codes);
            features.extend(codes.into_iter().map(i32::from));
            gathered
        }
    }
    .map_err(ExploreError::Unit)?;
    let expected = trace.gathered.iter().flat_map(|g| &g.features);
    if !features.iter().eq(expected) {
        return Err(differs("features"));
    }
    for computed in &trace.computed {
        let mut out = vec![0; computed.a.len()];
        units
            .vector(computed.op, &computed.a, &computed.b, &mut out)
            .map_err(ExploreError::Unit)?;
        if out != computed.out {
            return Err(differs("results"));
        }
    }
    Ok(())
}

/// Extent of verification within a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// About this many feature vectors, elements and pixels of the splat unit, spread evenly over the
    /// frame.
    Share([u64; 3]),
    /// The whole frame.
    Full,
}

impl Extent {
    /// Sampling intervals for feature vectors, elements and pixels of the splat unit: each how many-th
    /// is verified, for these totals.
    #[must_use]
    pub fn every(self, total: [u64; 3]) -> [u64; 3] {
        match self {
            Self::Full => [1; 3],
            Self::Share(aim) => [0, 1, 2].map(|i| total[i].div_ceil(aim[i]).max(1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A share never exceeds its aim, and small totals are verified in full.
    #[test]
    fn a_share_is_no_more_than_its_aim() {
        let aim = Extent::Share([100, 10, 4]);
        for total in [
            [0, 0, 0],
            [99, 9, 3],
            [100, 11, 5],
            [101, 1000, 9],
            [12_345, 67, 1],
        ] {
            let every = aim.every(total);
            for i in 0..3 {
                let taken = total[i].div_ceil(every[i]);
                assert!(taken <= [100, 10, 4][i], "{total:?} {every:?}");
                assert!(taken >= total[i].min([50, 5, 2][i]), "{total:?} {every:?}");
            }
        }
        assert_eq!(Extent::Full.every([12_345, 67, 8]), [1; 3]);
    }
}
