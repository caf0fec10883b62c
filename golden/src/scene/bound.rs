//! What pictures in the hardware's formats may be off by.

use potamoi_formats::config::Config;

use super::{Model, Scene, SceneError};
use crate::splats::{self, Order, View};
use crate::voxels::{self, MVoxels};

impl Scene {
    /// What each pixel's channels may be off by at most beside [`Scene::render_float`], derived
    /// from the formats and the units' own bounds; nothing of models or orders for which none is
    /// derived: those with networks, splats in the order in which MVoxels bring them, and frames that
    /// leave effects out.
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
                let view = View::by(cloud, &self.camera, self.profile, &self.splat_work())?;
                Ok(Some(splats::error_bounds(&view, exp, self.background)))
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
            _ => Ok(None),
        }
    }
}
