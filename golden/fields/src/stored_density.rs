//! Fields whose densities and colours are stored, so that bounds follow from their values.

use potamoi_formats::config::Config;

use super::{FieldError, FixedOptions};
use potamoi_base::camera::Camera;
use potamoi_reference::bounds::VectorBounds;

/// A field whose features are densities and colours. Its values tell which effects matter to any
/// picture, so an effect that is left out is also left out in floating point.
pub trait StoredDensity {
    /// What owns a density, in the plural.
    fn owners(&self) -> &'static str;

    /// Upper bounds over all cameras.
    fn densities(&self) -> Densities;

    /// Empty cells and all cells in the formats of the hardware.
    ///
    /// # Errors
    /// Those of [`super::Field::coded`].
    fn void_cells(&self, config: &Config) -> Result<[u64; 2], FieldError>;

    /// Upper bound of an opacity's error, if the density is off only by its format.
    ///
    /// # Errors
    /// Those of [`super::Field::coded`].
    fn opacity_off(&self, config: &Config, vector: &VectorBounds) -> Result<f64, FieldError>;

    /// Upper bounds of the error of each pixel's channels, row after row. `stop` is the
    /// early-termination threshold (transmittance), the larger of the two pictures'.
    ///
    /// # Errors
    /// Those of [`super::Field::coded`].
    fn pixel_bounds(
        &self,
        config: &Config,
        vector: &VectorBounds,
        camera: &Camera,
        options: &FixedOptions,
        stop: f64,
    ) -> Result<Vec<f64>, FieldError>;

    /// Number of direction codes that harmonics up to a degree take.
    fn direction_codes(&self, degree: usize) -> usize;

    /// The hash that identifies the numbers in kept work.
    fn key(&self) -> blake3::Hash;
}

/// Upper bounds over all rays of all cameras.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Densities {
    /// The largest density, as optical depth a voxel edge.
    pub most: f64,
    /// Optical depth along a ray.
    pub depth: f64,
    /// Number of samples along a ray.
    pub samples: f64,
}
