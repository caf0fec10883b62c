//! A grid that marks where a field may be non-empty.

use glam::DVec3;

/// A separate grid that marks where the field may be non-empty.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Mask {
    /// Number of vertices along x, y, z.
    pub points: [usize; 3],
    /// One flag a vertex, x fastest.
    pub filled: Vec<bool>,
    /// Scale from field vertices to mask vertices.
    pub scale: DVec3,
    /// Offset added after scaling.
    pub shift: DVec3,
}

impl Mask {
    /// Whether the nearest vertex is filled; `false` outside the mask.
    #[must_use]
    pub fn holds(&self, at: DVec3) -> bool {
        let near = (at * self.scale + self.shift).round();
        let last = DVec3::from(self.points.map(|p| p as f64 - 1.0));
        if !(near.cmpge(DVec3::ZERO).all() && near.cmple(last).all()) {
            return false;
        }
        let [x, y, z] = near.to_array().map(|v| v as usize);
        let index = x + self.points[0] * (y + self.points[1] * z);
        self.filled.get(index).copied().unwrap_or_default()
    }
}
