//! The garden's light: a low sun, a blue sky, and the crown's shadow.

use glam::DVec3;

const SUN: DVec3 = DVec3::new(1.05, 0.93, 0.72);
const SKY: DVec3 = DVec3::new(0.40, 0.47, 0.60);
/// Light reflected by the grass, from below.
const GROUND: DVec3 = DVec3::new(0.22, 0.25, 0.14);

#[derive(Debug)]
pub(super) struct Light {
    /// Unit vector to the sun.
    pub(super) sun: DVec3,
    /// Centres and radii of the balls that cast shadows.
    shades: Vec<(DVec3, f64)>,
}

impl Light {
    pub(super) fn new(shades: Vec<(DVec3, f64)>) -> Self {
        Self {
            sun: DVec3::new(0.62, 0.72, 0.30).normalize(),
            shades,
        }
    }

    /// The fraction of the sun's light that reaches a point, 0 to 1.
    pub(super) fn sunlit(&self, at: DVec3) -> f64 {
        self.shades
            .iter()
            .map(|(centre, radius)| {
                let to = *centre - at;
                let along = to.dot(self.sun);
                // Only what stands between the point and the sun, with a soft
                // start so that a ball shades its own far side.
                let ahead = (along / radius).clamp(0.0, 1.0);
                let aside = (to.length_squared() - along * along) / (radius * radius);
                1.0 - 0.62 * ahead * (-1.1 * aside).exp()
            })
            .product()
    }

    /// The colour of a surface.
    pub(super) fn shade(&self, albedo: DVec3, normal: DVec3, at: DVec3) -> DVec3 {
        let up = 0.5 + 0.5 * normal.y;
        let sun = normal.dot(self.sun).max(0.0) * self.sunlit(at);
        albedo * (GROUND.lerp(SKY, up) + SUN * sun)
    }
}
