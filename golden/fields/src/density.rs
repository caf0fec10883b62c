//! The density of a field at any point, for surfaces.

use glam::DVec3;

use super::Field;

/// Buffers of a sample, reused from point to point.
#[derive(Debug, Clone)]
pub struct Density {
    places: Vec<DVec3>,
    features: Vec<f64>,
}

impl Density {
    /// Buffers for a field.
    #[must_use]
    pub fn new(field: &dyn Field) -> Self {
        Self {
            places: vec![DVec3::ZERO; field.tables().len()],
            features: vec![0.0; field.channels()],
        }
    }

    /// The features at a world point, whether or not the field is known to be empty there.
    pub fn gather(&mut self, field: &(impl Field + ?Sized), at: DVec3) -> &[f64] {
        field.place(at, &mut self.places);
        let mut rest = &mut *self.features;
        for (table, place) in field.tables().iter().zip(&self.places) {
            let (own, other) = rest.split_at_mut(table.channels());
            table.gather(*place, own);
            rest = other;
        }
        &self.features
    }
}
