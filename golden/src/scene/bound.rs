//! What pictures in the hardware's formats may be off by.

use potamoi_formats::config::{Config, ExpConfig};

use super::{Model, Scene, SceneError};
use crate::fields::{self, Field};
use crate::splats::{self, Cloud, Order, View};
use crate::voxels::{self, MVoxels};

impl Scene {
    /// What each pixel's channels may be off by at most beside [`Scene::render_float`], derived
    /// from the formats and the units' own bounds; nothing of models or orders for which none is
    /// derived: splats in the order in which MVoxels bring them, and frames that leave effects out.
    ///
    /// # Errors
    /// A scene or a configuration that does not fit.
    pub fn error_bounds(&self, config: &Config) -> Result<Option<Vec<f64>>, SceneError> {
        let exp = &config.vu.exp;
        if !self.choices.left_out().is_empty() {
            return Ok(None);
        }
        match &self.model {
            Model::Splats(cloud) if self.order == Order::Exact => {
                Ok(Some(self.splat_bounds(cloud, exp, 0.0)?))
            }
            Model::Compact(model) if self.order == Order::Exact => {
                let eye = self.camera.position();
                let off = model.colours_off(eye, config)?;
                Ok(Some(self.splat_bounds(&model.seen_from(eye), exp, off)?))
            }
            Model::Voxels(grid) => {
                let mvoxels = MVoxels::new(grid, config)?;
                let Some(formats) = mvoxels.formats() else {
                    return Ok(None);
                };
                let options = self.voxel_options();
                let bounds = voxels::error_bounds(grid, formats, exp, &self.camera, &options);
                Ok(Some(bounds.into_iter().map(|[colour, _]| colour).collect()))
            }
            Model::Dvgo(field) => self.field_bounds(&**field, config),
            Model::Tensorf(field) => self.field_bounds(&**field, config),
            Model::Field(field) => self.field_bounds(&**field, config),
            Model::Splats(_) | Model::Compact(_) => Ok(None),
        }
    }

    fn splat_bounds(
        &self,
        cloud: &Cloud,
        exp: &ExpConfig,
        colours_off: f64,
    ) -> Result<Vec<f64>, SceneError> {
        let view = View::by(cloud, &self.camera, self.profile, &self.splat_work())?;
        Ok(splats::error_bounds(
            &view,
            exp,
            self.background,
            colours_off,
        ))
    }

    fn field_bounds(
        &self,
        field: &dyn Field,
        config: &Config,
    ) -> Result<Option<Vec<f64>>, SceneError> {
        let options = fields::FixedOptions {
            background: self.background,
            terminate: self.stops(config.vu.exp.output_bits),
            ..fields::FixedOptions::default()
        };
        Ok(fields::error_bounds(field, config, &self.camera, &options)?)
    }
}
