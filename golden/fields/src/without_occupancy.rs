//! A field without its test for empty space: every sample is gathered.

use glam::DVec3;

use super::{Algorithm, Field, Sampling, Table};

/// Wraps a field and marks no space as empty.
pub(super) struct WithoutOccupancy<'a>(pub(super) &'a dyn Field);

impl Field for WithoutOccupancy<'_> {
    fn algorithm(&self) -> &'static Algorithm {
        self.0.algorithm()
    }

    fn tables(&self) -> &[Table] {
        self.0.tables()
    }

    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        self.0.place(at, places);
    }

    fn holds(&self, _: DVec3) -> bool {
        true
    }

    fn depth(&self, features: &[f64]) -> f64 {
        self.0.depth(features)
    }

    fn colour(&self, features: &[f64], direction: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
        self.0.colour(features, direction, scratch)
    }

    fn sampling(&self) -> Sampling {
        self.0.sampling()
    }
}
