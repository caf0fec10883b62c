//! Overrides a field's early-termination threshold (transmittance).

use glam::DVec3;
use potamoi_formats::config::Config;

use super::bound::Bounds;
use super::mlp::Mlp;
use super::{
    Algorithm, Density, Directions, Field, FieldError, Local, QuantisedField, Sampling,
    StoredDensity, Table,
};
use potamoi_base::camera::Camera;
use potamoi_reference::bounds::VectorBounds;

/// A field with its early-termination threshold.
pub struct WithEarlyTermination<'a> {
    field: &'a dyn Field,
    sampling: Sampling,
}

impl<'a> WithEarlyTermination<'a> {
    /// Stops rays below a transmittance of `stop`; by default at the field's own threshold.
    #[must_use]
    pub fn new(field: &'a dyn Field, stop: Option<f64>) -> Self {
        let own = field.sampling();
        Self {
            field,
            sampling: Sampling {
                stop: stop.unwrap_or(own.stop),
                ..own
            },
        }
    }
}

impl Field for WithEarlyTermination<'_> {
    fn algorithm(&self) -> &'static Algorithm {
        self.field.algorithm()
    }

    fn tables(&self) -> &[Table] {
        self.field.tables()
    }

    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        self.field.place(at, places);
    }

    fn holds(&self, at: DVec3) -> bool {
        self.field.holds(at)
    }

    fn index(&self, at: DVec3, places: &mut [DVec3]) -> bool {
        self.field.index(at, places)
    }

    fn empty_for(&self, at: DVec3, direction: DVec3) -> Option<f64> {
        self.field.empty_for(at, direction)
    }

    fn kept(&self) -> usize {
        self.field.kept()
    }

    fn depths(&self, features: &[f64], depths: &mut Vec<f64>, kept: &mut Vec<f64>) {
        self.field.depths(features, depths, kept);
    }

    fn encoded(&self) -> usize {
        self.field.encoded()
    }

    fn encode(&self, direction: DVec3, out: &mut Vec<f64>) {
        self.field.encode(direction, out);
    }

    fn colours(&self, kept: &[f64], directions: &[f64], out: &mut Vec<DVec3>) {
        self.field.colours(kept, directions, out);
    }

    fn depth(&self, features: &[f64]) -> f64 {
        self.field.depth(features)
    }

    fn colour(&self, features: &[f64], direction: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
        self.field.colour(features, direction, scratch)
    }

    fn sampling(&self) -> Sampling {
        self.sampling
    }

    fn coded(&self, config: &Config) -> Result<QuantisedField<'_>, FieldError> {
        self.field.coded(config)
    }

    fn bounds(
        &self,
        config: &Config,
        vector: &VectorBounds,
        camera: &Camera,
    ) -> Result<Option<Box<dyn Bounds + '_>>, FieldError> {
        self.field.bounds(config, vector, camera)
    }

    fn local(&self, camera: &Camera) -> Result<Option<Local<'_>>, FieldError> {
        self.field.local(camera)
    }

    fn density(&self, at: DVec3, sample: &mut Density) -> f64 {
        self.field.density(at, sample)
    }

    fn stored(&self) -> Option<&dyn StoredDensity> {
        self.field.stored()
    }

    fn perceptrons(&self) -> Vec<&Mlp> {
        self.field.perceptrons()
    }

    fn directions(&self) -> Directions<'_> {
        self.field.directions()
    }

    fn assumed(&self) -> Option<String> {
        self.field.assumed()
    }

    fn void(&self) -> Option<[u64; 2]> {
        self.field.void()
    }
}
