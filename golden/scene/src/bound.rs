//! Error bounds of pictures in the hardware's formats.

use potamoi_formats::config::{Config, ExpConfig, SplatOpacity};

use super::{Model, Scene, SceneError};
use potamoi_base::precision::Precision;
use potamoi_fields::{self as fields, Field, WithEarlyTermination};
use potamoi_gaussians::Cloud;
use potamoi_reference::bounds::VectorBounds;
use potamoi_splats::{self as splats, Order, Pair, Rules, View, Work};

impl Scene {
    /// Upper bounds of the error of each pixel's channels against [`Scene::render_float`], derived
    /// from the formats and the units' own bounds. `None` for models and options without a bound:
    /// splats in approximate order, and frames that leave out effects or levels.
    ///
    /// # Errors
    /// The scene or the configuration is invalid.
    pub fn error_bounds(&self, config: &Config) -> Result<Option<Vec<f64>>, SceneError> {
        let vector = VectorBounds::by_formula(&config.vu.exp);
        self.error_bounds_beside(config, self.precision, &vector)
    }

    /// Error bounds against the floating-point picture with another precision, for a vector unit
    /// with error bounds `vector`.
    ///
    /// # Errors
    /// Those of [`Scene::error_bounds`].
    pub fn error_bounds_beside(
        &self,
        config: &Config,
        float: Precision,
        vector: &VectorBounds,
    ) -> Result<Option<Vec<f64>>, SceneError> {
        let exp = (&config.vu.exp, self.opacity(config));
        if !self.choices.left_out().is_empty() || self.precision.hashed_levels.is_some() {
            return Ok(None);
        }
        match self.model() {
            Model::Splats(cloud) if self.order == Order::Exact => {
                Ok(Some(self.splat_bounds(cloud, (exp, vector), float, 0.0)?))
            }
            Model::Compact(model) if self.order == Order::Exact => {
                let eye = self.camera.position();
                let off = model.colours_off(eye, config)?;
                Ok(Some(self.splat_bounds(
                    &model.seen_from(eye),
                    (exp, vector),
                    float,
                    off,
                )?))
            }
            Model::Field(field) => self.field_bounds(&**field, config, vector, float),
            Model::Splats(_) | Model::Compact(_) => Ok(None),
        }
    }

    fn splat_bounds(
        &self,
        cloud: &Cloud,
        ((exp, opacity), vector): ((&ExpConfig, SplatOpacity), &VectorBounds),
        float: Precision,
        colours_off: f64,
    ) -> Result<Vec<f64>, SceneError> {
        let [own, float] = [self.precision, float].map(|p| self.profile.rules().with(&p));
        let work = Work {
            precision: Precision {
                alpha_min: Some(own.alpha_min.min(float.alpha_min)),
                ..self.precision
            },
            ..self.splat_work()
        };
        let view = View::by(cloud, &self.camera, self.profile, &work)?;
        let fixed = Rules {
            alpha_min: own.alpha_min,
            ..*view.rules()
        };
        Ok(splats::error_bounds(
            &view,
            &Pair {
                fixed,
                float,
                opacity,
            },
            exp,
            vector,
            self.background,
            colours_off,
        ))
    }

    fn field_bounds(
        &self,
        field: &dyn Field,
        config: &Config,
        vector: &VectorBounds,
        float: Precision,
    ) -> Result<Option<Vec<f64>>, SceneError> {
        let own = field.sampling().stop;
        // Each of the two leaves out what less than its limit lets through.
        let [fixed, float] = [self.precision, float].map(|p| p.stop_below.unwrap_or(own));
        let field = WithEarlyTermination::new(field, Some(fixed.max(float)));
        let options = fields::FixedOptions {
            background: self.background,
            terminate: self.stops(self.lost_a_sample(config)?),
            transmittance_bits: self.transmittance_bits(),
            ..fields::FixedOptions::default()
        };
        Ok(fields::error_bounds(
            &field,
            config,
            vector,
            &self.camera,
            &options,
        )?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::sync::Arc;

    use super::*;
    use potamoi_reference::ReferenceUnits;

    /// Colours and opacities beyond their formats saturate; a bound without this effect would be a
    /// hundred times too small.
    #[test]
    fn what_is_held_at_the_end_of_a_format_counts() {
        let count = 60u8;
        let of = |i: u8, k: f32| (f32::from(i) * k).sin();
        let cloud = Cloud::new(
            0,
            (0..count)
                .map(|i| [of(i, 1.3), of(i, 0.7), of(i, 2.1)])
                .collect(),
            vec![[-2.0; 3]; count.into()],
            vec![[1.0, 0.0, 0.0, 0.0]; count.into()],
            (0..count)
                .map(|i| if i % 3 == 0 { 20.0 } else { 0.0 })
                .collect(),
            // Colours up to 34, in a format up to 16.
            (0..count)
                .map(|i| [2.0 * f32::from(i), 60.0, 0.0])
                .collect(),
        );
        let mut scene = crate::tests::opened("cairn:splats");
        scene.set_size(Some(48), Some(40)).unwrap();
        scene.model = Arc::new(Model::Splats(cloud.unwrap()));
        let config = Config::paper();
        let bounds = scene.error_bounds(&config).unwrap().unwrap();
        let float = scene.render_float().unwrap().picture;
        let fixed = scene.render_fixed(&config, &mut ReferenceUnits::new(&config));
        let fixed = fixed.unwrap().picture;
        let mut most = 0f64;
        for ((a, b), bound) in fixed.rgb.iter().zip(&float.rgb).zip(&bounds) {
            for (a, b) in a.iter().zip(b) {
                let off = f64::from((a - b).abs());
                assert!(off <= *bound, "{off} {bound}");
                most = most.max(off);
            }
        }
        assert!(most > 5.0, "{most}");
    }

    /// Results of the exponential beyond its range must not count: they would be drawn all over a
    /// tile.
    #[test]
    fn the_least_cut_off_is_above_what_is_past_the_exponential_s_range() {
        let cut_off = |alpha_min| Precision {
            alpha_min: Some(alpha_min),
            ..Precision::default()
        };
        let mut scene = crate::tests::opened("garden");
        scene.set_size(Some(40), Some(40)).unwrap();
        for below in [1e-4, 3.4e-4, 3.99e-4] {
            let said = scene.set_precision(cut_off(below)).unwrap_err().to_string();
            assert!(
                said.contains("alpha_min") && said.contains("exp(-8)"),
                "{said}"
            );
        }
        let config = Config::paper();
        let mut twins = ReferenceUnits::new(&config);
        let mut shown = |alpha_min| {
            scene.precision = cut_off(alpha_min);
            let float = scene.render_float().unwrap().picture;
            let fixed = scene.render_fixed(&config, &mut twins).unwrap().picture;
            fixed.psnr(&float, |_| true).unwrap()
        };
        let [least, below] = [4e-4, 3e-4].map(&mut shown);
        assert!(least > 80.0 && below < 30.0, "{least} {below}");
    }
}
