//! Work of the GPU that other hardware would do: what would have to move where the GPU binds.

use potamoi_system::system_model::work::PathWork;
use potamoi_system::system_model::{AtBounds, Model, Scenario, Variant};
use schemars::JsonSchema;
use serde::Serialize;

use crate::{ExploreError, Setup};

/// Parts of a frame that hardware beside the GPU could do, and their kernels.
const PARTS: [(&str, &[&str]); 4] = [
    ("projection", &["preprocess"]),
    ("sorting", SORTING),
    (
        "projection and sorting",
        &[
            "preprocess",
            "scan of tiles touched",
            "duplicate with keys",
            "sort: histogram",
            "sort: pass",
            "tile ranges",
        ],
    ),
    ("marching of rays", &["march"]),
];

/// Pairs of tile and Gaussian, listed and sorted.
const SORTING: &[&str] = &[
    "scan of tiles touched",
    "duplicate with keys",
    "sort: histogram",
    "sort: pass",
    "tile ranges",
];

/// A part of the GPU's work that other hardware does in no time. Its bytes still move; the area and the
/// energy of that hardware are not known.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Moved {
    /// The part.
    pub work: &'static str,
    /// Its kernels.
    pub kernels: &'static [&'static str],
    /// Frames a second of each variant, in their order, rendered locally.
    pub frames_per_second: Vec<AtBounds<f64>>,
}

impl Moved {
    /// The parts that a path's frames have, each moved by itself.
    pub(super) fn all(
        setup: &Setup,
        path: &PathWork,
        variants: &[Variant],
    ) -> Result<Vec<Self>, ExploreError> {
        let is_splats = setup.scene.model().is_splats();
        let has = |kernels: &[&str]| is_splats != kernels.contains(&"march");
        let of = |(work, kernels): (_, &'static [&'static str])| {
            let mut system = setup.system.clone();
            system.gpu.moved = kernels;
            let model = Model {
                system: &system,
                ..setup.model()
            };
            let rate = |variant: &Variant| {
                let (found, _) = model.run(path, *variant, Scenario::Local)?;
                Ok(found.run.frames_per_second())
            };
            Ok(Self {
                work,
                kernels,
                frames_per_second: variants
                    .iter()
                    .map(rate)
                    .collect::<Result<_, ExploreError>>()?,
            })
        };
        PARTS.into_iter().filter(|own| has(own.1)).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::config::Config;
    use potamoi_scene::Scene;
    use potamoi_system::system_model::System;
    use potamoi_system::system_model::work::{PathOptions, PathParts};
    use potamoi_warp::Profile;

    use super::*;
    use crate::ConfigChoice;

    fn found(scene: &str, preset: Option<&str>) -> (Vec<Moved>, Vec<AtBounds<f64>>) {
        let scene = Scene::open(scene).unwrap();
        let mut chosen = ConfigChoice::for_scene(&scene).unwrap();
        if let Some(preset) = preset {
            chosen.config = Config::preset(preset).unwrap();
        }
        let system = System::default();
        let options = PathOptions {
            frames: 2,
            fps: 30.0,
            window: 2,
            phi: None,
            profile: Profile::Potamoi,
            array: [system.array_rows.into(), system.array_columns.into()],
            is_double_buffered: system.array_double_buffered,
            cache: system.gpu.cache_bytes(),
            parts: PathParts::FullFrames,
        };
        let mut setup = Setup::new(chosen, &system, scene, None).unwrap();
        let (path, _) = setup.count(&options, &()).unwrap();
        let variants = [Variant::named("fs+gu").unwrap()];
        let moved = Moved::all(&setup, &path, &variants).unwrap();
        let model = setup.model();
        let run = |own| model.run(&path, own, Scenario::Local).unwrap().0.run;
        let rates = variants.map(|own| run(own).frames_per_second());
        (moved, rates.into())
    }

    /// A machine whose GPU binds is faster without a part of its work, by more the more is moved; one that
    /// its units bind is not.
    #[test]
    fn what_binds_is_what_has_to_move() {
        let (lean, before) = found("garden", Some("lean-splats"));
        let names = ["projection", "sorting", "projection and sorting"];
        assert_eq!(lean.iter().map(|own| own.work).collect::<Vec<_>>(), names);
        let rates: Vec<f64> = lean
            .iter()
            .map(|own| own.frames_per_second[0].mid())
            .collect();
        assert!(
            rates[0] > before[0].mid() && rates[1] > before[0].mid(),
            "{rates:?}"
        );
        assert!(rates[2] > rates[0].max(rates[1]), "{rates:?}");
        let (paper, before) = found("garden", None);
        let by = paper[2].frames_per_second[0].mid() / before[0].mid();
        assert!((1.0..1.2).contains(&by), "{by}");
    }

    #[test]
    fn fields_have_their_own_part() {
        let (found, before) = found("lantern", None);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].work, "marching of rays");
        assert!(found[0].frames_per_second[0].mid() >= before[0].mid());
    }
}
