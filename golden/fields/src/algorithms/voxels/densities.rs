//! Bounds that follow from the stored densities of a grid.

use glam::DVec3;
use potamoi_formats::config::Config;
use serde::Serialize;

use super::bound::{error_bounds, opacity_off};
use super::field::StoredField;
use super::formats::Formats;
use super::grid::Grid;
use crate::{Densities, FieldError, FixedOptions, StoredDensity};
use potamoi_base::camera::Camera;
use potamoi_base::content_hash::hash_of;
use potamoi_reference::bounds::VectorBounds;

/// A grid as kept work names it.
#[derive(Serialize)]
enum Kept<'a> {
    Voxels(&'a Grid),
}

impl StoredDensity for StoredField {
    fn owners(&self) -> &'static str {
        "vertices"
    }

    fn densities(&self) -> Densities {
        let channels = self.grid.layout().channels();
        let vertices = self.grid.features().chunks_exact(channels);
        let most = f64::from(vertices.fold(0f32, |most, vertex| most.max(vertex[0])));
        let diagonal = DVec3::from(self.grid.points().map(|p| (p - 1) as f64)).length();
        Densities {
            most,
            // A sample more at each end.
            depth: most * (diagonal + 2.0 * self.step),
            samples: diagonal / self.step + 2.0,
        }
    }

    fn void_cells(&self, config: &Config) -> Result<[u64; 2], FieldError> {
        let (volume, _) = self.fixed(config)?;
        Ok(volume.mvoxels.void_cells())
    }

    fn opacity_off(&self, config: &Config, vector: &VectorBounds) -> Result<f64, FieldError> {
        let formats = Formats::new(&self.grid, config)?;
        Ok(opacity_off(&formats, vector, self.step))
    }

    fn pixel_bounds(
        &self,
        config: &Config,
        vector: &VectorBounds,
        camera: &Camera,
        options: &FixedOptions,
        stop: f64,
    ) -> Result<Vec<f64>, FieldError> {
        let formats = Formats::new(&self.grid, config)?;
        // Also where no ray can stop, the bound allows for it.
        let options = FixedOptions {
            terminate: true,
            ..*options
        };
        let bounds = error_bounds(self, &formats, vector, camera, &options, stop);
        Ok(bounds.into_iter().map(|[colour, _]| colour).collect())
    }

    /// A constant takes none.
    fn direction_codes(&self, degree: usize) -> usize {
        if degree == 0 { 0 } else { 3 }
    }

    /// Without the step, which a scene keeps beside its model.
    fn key(&self) -> blake3::Hash {
        hash_of(&Kept::Voxels(&self.grid))
    }
}
