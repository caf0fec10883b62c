//! The appearance of a point: a view-independent colour and a view-dependent reflection.

use glam::{DVec3, dvec3};

use super::sdf;

/// Incoming light from a direction, linear RGB.
pub(super) type Surroundings = fn(DVec3) -> DVec3;

/// The radiance of a point, linear RGB, as a function of the viewing direction.
#[derive(Debug, Clone, Copy)]
pub struct Appearance {
    base: DVec3,
    normal: DVec3,
    /// Head-on reflectance by colour.
    mirror: DVec3,
    /// Increase of the reflectance at grazing angles: 0 for none, 1 up to total reflection.
    glance: f64,
    surroundings: Option<Surroundings>,
}

impl Appearance {
    /// A view-independent appearance.
    pub(super) fn matte(base: DVec3) -> Self {
        Self {
            base,
            normal: DVec3::ZERO,
            mirror: DVec3::ZERO,
            glance: 0.0,
            surroundings: None,
        }
    }

    /// Adds a reflection of `surroundings` in a surface with this unit normal.
    pub(super) fn reflecting(
        self,
        normal: DVec3,
        mirror: DVec3,
        glance: f64,
        surroundings: Surroundings,
    ) -> Self {
        Self {
            normal,
            mirror,
            glance,
            surroundings: Some(surroundings),
            ..self
        }
    }

    /// Whether the appearance is view-independent.
    #[must_use]
    pub fn is_matte(&self) -> bool {
        self.surroundings.is_none()
    }

    /// The outward normal; zero without a reflection.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Linear RGB seen along a unit direction from the camera into the scene.
    #[must_use]
    pub fn along(&self, direction: DVec3) -> DVec3 {
        let Some(surroundings) = self.surroundings else {
            return self.base;
        };
        let facing = (-direction.dot(self.normal)).clamp(0.0, 1.0);
        // Schlick's approximation of Fresnel's reflectance.
        let more = self.glance * (1.0 - facing).powi(5);
        let share = self.mirror + (DVec3::ONE - self.mirror) * more;
        let mirrored = direction - 2.0 * direction.dot(self.normal) * self.normal;
        self.base + share * surroundings(mirrored)
    }
}

/// Sun and sky over solids.
#[derive(Debug, Clone, Copy)]
pub(super) struct Daylight {
    /// Unit vector towards the sun.
    pub(super) to_sun: DVec3,
    pub(super) sun: DVec3,
    pub(super) sky: DVec3,
    /// Light reflected from the ground.
    pub(super) ground: DVec3,
    /// Distance up to which surfaces darken one another.
    pub(super) reach: f64,
    /// The longest step of a ray towards the sun.
    pub(super) stride: f64,
}

impl Daylight {
    /// Normal and light at the surface nearest to `p`, for points within a few voxels of it. They
    /// are constant along each normal, so that a surface has one colour through its whole depth.
    pub(super) fn at(
        &self,
        distance: impl Fn(DVec3) -> f64,
        p: DVec3,
        voxel: f64,
    ) -> (DVec3, DVec3) {
        let normal = sdf::normal(&distance, p, 0.5 * voxel);
        let surface = p - normal * distance(p);
        let mut open = 1.0;
        for k in 1..=3 {
            let away = self.reach * f64::from(k) / 3.0;
            let gap = distance(surface + normal * away) / away;
            open -= (1.0 - gap).clamp(0.0, 1.0) * [0.34, 0.26, 0.18][k as usize - 1];
        }
        let facing = normal.dot(self.to_sun);
        let sun = if facing > 0.0 {
            facing
                * shadow(
                    &distance,
                    surface + normal * voxel,
                    self.to_sun,
                    [1.5 * voxel, self.stride],
                )
        } else {
            0.0
        };
        let up = 0.5 + 0.5 * normal.z;
        let around = self.ground.lerp(self.sky, up);
        (normal, self.sun * sun + around * open)
    }
}

/// The visible fraction of a small sun: from the narrowest gap along the ray, relative to its
/// distance.
fn shadow(distance: impl Fn(DVec3) -> f64, from: DVec3, to: DVec3, steps: [f64; 2]) -> f64 {
    const SHARPNESS: f64 = 9.0;
    let mut seen: f64 = 1.0;
    let mut t = steps[0];
    for _ in 0..28 {
        let gap = distance(from + to * t);
        seen = seen.min(SHARPNESS * gap / t);
        if seen <= 0.0 || t > 2.5 {
            break;
        }
        t += gap.clamp(steps[0], steps[1]);
    }
    let seen = seen.clamp(0.0, 1.0);
    seen * seen * (3.0 - 2.0 * seen)
}

/// A colour of the colour wheel; `turn` 1 is one revolution.
pub(super) fn wheel(turn: f64) -> DVec3 {
    let wave = |offset: f64| 0.5 + 0.5 * (std::f64::consts::TAU * (turn + offset)).cos();
    dvec3(wave(0.0), wave(-0.33), wave(-0.67))
}

/// 0 below `from`, 1 above `to`, smooth between.
pub(super) fn smooth_step(from: f64, to: f64, v: f64) -> f64 {
    let t = ((v - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
