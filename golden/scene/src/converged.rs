//! The converged picture of a scene: its model rendered with every approximation of the renderer
//! taken so far that more of it changes nothing that is measured. Settings of the scene that only
//! trade accuracy for time do not change it.

use potamoi_base::effects::Choices;
use potamoi_base::picture::Picture;
use potamoi_base::precision::Precision;
use potamoi_fields::{self as fields, Field, FloatOptions, WithEarlyTermination};
use potamoi_gaussians::Cloud;
use potamoi_splats::{self as splats, Order, Profile, Work};
use schemars::JsonSchema;
use serde::Serialize;

use super::model_facts::Cache;
use super::{Kind, Scene, SceneError};

/// Step of the coarsest of the compared pictures, in voxel edges.
const FIRST_STEP: f64 = 0.25;
/// Root-mean-square change of a channel, peak 1, below which a halving of the step counts as none:
/// a unit of 16 fraction bits.
const BOUND: f64 = 1.0 / 65_536.0;
/// Maximum number of halvings; each doubles the time of a picture.
const MOST_HALVINGS: u32 = 5;
/// Step in voxel edges for which models state their thresholds of opacity and weight. Both are
/// proportional to the step, so that at another step the same densities are skipped.
const STEP_OF_THRESHOLDS: f64 = 0.5;
/// Transmittance at which rays of fields end: what lies behind is less than half a unit in the last
/// place of a channel near 1 in 32-bit floating point, which is 2^-25.
const STOP: f64 = 1.0 / (1u64 << 30) as f64;

/// A converged picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Converged {
    /// The picture, including the background.
    pub picture: Picture,
    /// How its sampling step was found; `None` for splats, and for fields whose step is part of the
    /// model.
    pub steps: Option<Halvings>,
}

/// Halvings of a sampling step, until the picture changes by less than a bound.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Halvings {
    /// Step of the picture, in voxel edges.
    pub step: f64,
    /// Number of halvings of the first step, 1/4 voxel edge.
    pub halvings: u32,
    /// Root-mean-square change of a channel by the last halving, peak 1.
    pub change: f64,
    /// The bound of that change.
    pub bound: f64,
}

impl Halvings {
    /// Whether the last halving changed the picture by less than the bound; otherwise the limit of
    /// halvings was reached.
    #[must_use]
    pub fn is_within(&self) -> bool {
        self.change < self.bound
    }
}

impl Scene {
    /// Renders the converged picture in 64-bit floating point.
    ///
    /// Rays end where less than 2^-30 of the light is left, and splats never. Splats are in the
    /// order of their depths, by the rules of the original rasteriser. The step of fields that have
    /// one is halved, from 1/4 voxel edge, until a halving changes the picture by less than 2^-16
    /// (root mean square), at most five times. No effect is left out. Profile, order, step,
    /// precision and choices of the scene have no influence; camera and background have.
    ///
    /// # Errors
    /// The camera is out of range.
    pub fn render_converged(&self) -> Result<Converged, SceneError> {
        self.converged().map_err(|e| e.of(&self.name))
    }

    fn converged(&self) -> Result<Converged, SceneError> {
        let whole = Self {
            profile: Profile::Inria,
            order: Order::Exact,
            precision: Precision::RULES,
            choices: Choices::default(),
            found: Cache::default(),
            ..self.clone()
        };
        match whole.model.kind() {
            Kind::Splats(cloud) => Ok(Converged {
                picture: whole.unstopped(cloud)?,
                steps: None,
            }),
            Kind::Field(field) => match field.stepped() {
                None => Ok(Converged {
                    picture: whole.unstopped_field(field, 1.0)?,
                    steps: None,
                }),
                Some(_) => whole.halved(field),
            },
        }
    }

    fn unstopped(&self, cloud: &Cloud) -> Result<Picture, SceneError> {
        let options = splats::FloatOptions {
            background: self.background,
            work: Work {
                stops: false,
                ..self.splat_work()
            },
            ..splats::FloatOptions::default()
        };
        let cloud = self.seen_from(cloud, &self.camera);
        Ok(splats::render_float(&cloud, &self.camera, self.profile, &options)?.picture)
    }

    /// `thresholds` is the factor of the field's thresholds.
    fn unstopped_field(&self, field: &dyn Field, thresholds: f64) -> Result<Picture, SceneError> {
        let options = FloatOptions {
            terminate: true,
            thresholds,
            ..self.float_options(field)
        };
        let field = WithEarlyTermination::new(field, Some(STOP));
        Ok(fields::render_masked(&field, &self.camera, &options, None)?.picture)
    }

    fn halved(&self, field: &dyn Field) -> Result<Converged, SceneError> {
        let at = |step: f64| match field.stepped() {
            Some(own) => self.unstopped_field(&*own.with_step(step), step / STEP_OF_THRESHOLDS),
            None => self.unstopped_field(field, 1.0),
        };
        let mut picture = at(FIRST_STEP)?;
        let mut reached = Halvings {
            step: FIRST_STEP,
            halvings: 0,
            change: f64::INFINITY,
            bound: BOUND,
        };
        while !reached.is_within() && reached.halvings < MOST_HALVINGS {
            reached.step *= 0.5;
            reached.halvings += 1;
            let finer = at(reached.step)?;
            // Pictures of one camera have one size.
            let change = finer.mean_squared_error(&picture, |_| true);
            reached.change = change.unwrap_or_default().sqrt();
            picture = finer;
        }
        Ok(Converged {
            picture,
            steps: Some(reached),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_analytic::Analytic;
    use potamoi_base::effects::Effect;

    use super::*;

    fn small(name: &str) -> Scene {
        let mut scene = crate::tests::opened(name);
        scene.set_size(Some(24), Some(24)).unwrap();
        scene
    }

    /// Settings that trade accuracy for time: what quality is measured against must not be one of
    /// what it measures.
    #[test]
    fn no_setting_changes_it() {
        let stop = Precision {
            stop_below: Some(0.02),
            ..Precision::default()
        };
        for name in ["garden", "lantern", "cairn:dvgo"] {
            let scene = small(name);
            let own = scene.render_converged().unwrap();
            assert!(own.steps.is_none_or(|steps| steps.is_within()), "{name}");
            assert_eq!(own, scene.render_converged().unwrap(), "{name}");
            let mut other = scene.clone();
            other.set_profile(Profile::Brush);
            other.set_order(Order::Approximate);
            other.set_precision(stop).unwrap();
            other.set_step(0.75).unwrap();
            other.set_choices(Choices::default().leave_out(Effect::EarlyTermination));
            assert_eq!(own, other.render_converged().unwrap(), "{name}");
            assert_ne!(
                scene.render_float().unwrap().picture,
                other.render_float().unwrap().picture,
                "{name}"
            );
            other.set_background("", [0.5; 3]).unwrap();
            assert_ne!(own, other.render_converged().unwrap(), "{name}");
        }
    }

    /// A finer step and a smaller threshold are nearer, down to settings finer than the defaults.
    #[test]
    fn finer_settings_are_nearer() {
        let set = |scene: &mut Scene, stop| {
            let precision = Precision {
                stop_below: Some(stop),
                ..Precision::default()
            };
            scene.set_precision(precision).unwrap();
        };
        let db = |scene: &Scene, own: &Converged| {
            let shown = scene.render_float().unwrap().picture;
            shown.psnr(&own.picture, |_| true).unwrap()
        };
        for name in ["lantern", "cairn:voxels"] {
            let mut scene = small(name);
            let own = scene.render_converged().unwrap();
            assert!(own.steps.unwrap().is_within(), "{name}: {:?}", own.steps);
            set(&mut scene, 1e-6);
            let all = [2.0, 1.0, 0.5, 0.25, 0.125].map(|step| {
                scene.set_step(step).unwrap();
                db(&scene, &own)
            });
            assert!(all.is_sorted(), "{name}: {all:?}");
            // A setting finer than the default is nearer by as much as it is finer.
            assert!(all[3] > all[2] + 6.0, "{name}: {all:?}");
        }
        let mut scene = small("garden");
        let own = scene.render_converged().unwrap();
        assert_eq!(own.steps, None);
        let all = [0.05, 0.004, 1e-4, 1e-6].map(|stop| {
            set(&mut scene, stop);
            db(&scene, &own)
        });
        assert!(all.is_sorted(), "{all:?}");
    }

    /// Every kind of field with a step, and every analytic scene, within the limit of halvings.
    #[test]
    #[ignore = "exhaustive; run with make test-full"]
    fn every_scene_of_steps_converges() {
        let fields = ["lantern", "cairn:dvgo", "cairn:tensorf"].map(str::to_owned);
        let analytic = Analytic::ALL.map(|own| format!("{}:voxels", own.name()));
        for name in fields.into_iter().chain(analytic) {
            let scene = small(&name);
            let own = scene.render_converged().unwrap();
            let float = scene.render_float().unwrap().picture;
            let db = float.psnr(&own.picture, |_| true).unwrap();
            println!("{name}: {:?}, the default {db:.2} dB", own.steps);
            assert!(own.steps.unwrap().is_within(), "{name}: {:?}", own.steps);
        }
    }
}
