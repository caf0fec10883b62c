//! Built-in scenes with exact ground truth: analytic radiance fields, composed of signed
//! distances, smooth densities and noise.
//!
//! A scene is rendered by ray marching the field itself ([`Analytic::truth`]). It is also sampled
//! to a grid of vertices ([`Analytic::bake`]), the input of any other renderer, whose error
//! against the truth can then be measured.
//!
//! ```
//! use potamoi_analytic::Analytic;
//!
//! let scene = Analytic::named("moons").unwrap();
//! let truth = scene.truth(&scene.camera(0.0, 16, 16), [0.0; 3]);
//! assert_eq!(truth.transmittance.len(), 16 * 16);
//! ```

mod appearance;
mod bake;
mod cairn;
mod chrome;
mod city;
mod curve;
mod field;
mod gallery;
mod ground_truth;
mod heights;
pub mod lantern;
mod lattice;
mod mist;
mod moons;
mod noise;
mod sampler;
mod sdf;
#[cfg(test)]
mod tests;
mod vase;

use glam::DVec3;

pub use appearance::Appearance;
pub use ground_truth::Truth;
pub use sampler::Sampler;

use field::{Field, Motion, SceneSetup};
use potamoi_base::camera::Camera;
use potamoi_fields::voxels::Grid;
use potamoi_march::MarchError;

/// A built-in analytic scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Analytic {
    /// Balanced stones: diffuse solids.
    Cairn,
    /// A glazed vase: glossy.
    Vase,
    /// A lattice of thin rods in a sphere.
    Lattice,
    /// Hills in morning fog.
    Mist,
    /// A planet with rings and moons: mostly empty space.
    Moons,
    /// Metal balls: mirror-like.
    Chrome,
    /// A room with pictures: large flat surfaces.
    Gallery,
    /// Blocks of houses: many small details.
    City,
}

impl Analytic {
    /// All scenes.
    pub const ALL: [Self; 8] = [
        Self::Cairn,
        Self::Vase,
        Self::Lattice,
        Self::Mist,
        Self::Moons,
        Self::Chrome,
        Self::Gallery,
        Self::City,
    ];

    /// The scene with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scene| scene.name() == name)
    }

    fn field(self) -> &'static dyn Field {
        match self {
            Self::Cairn => &cairn::Cairn,
            Self::Vase => &vase::Vase,
            Self::Lattice => &lattice::Lattice,
            Self::Mist => &mist::Mist,
            Self::Moons => &moons::Moons,
            Self::Chrome => &chrome::Chrome,
            Self::Gallery => &gallery::Gallery,
            Self::City => &city::City,
        }
    }

    fn frame(self) -> &'static SceneSetup {
        self.field().frame()
    }

    /// Its name on a command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.frame().name
    }

    /// The difficulty of the scene for a renderer, in a few words.
    #[must_use]
    pub fn asks(self) -> &'static str {
        self.frame().asks
    }

    /// Background, linear RGB.
    #[must_use]
    pub fn background(self) -> [f32; 3] {
        self.frame().background
    }

    /// The camera of the scene's path after `seconds`, for any picture size; at 0, the default
    /// camera. The whole scene fits the smaller side.
    #[must_use]
    pub fn camera(self, seconds: f64, width: u32, height: u32) -> Camera {
        let frame = self.frame();
        let tall = f64::from(height) / f64::from(width.max(1));
        let fov = 2.0 * ((frame.fov.to_radians() / 2.0).tan() * tall.max(1.0)).atan();
        let turned =
            |v: DVec3, degrees: f64| glam::DMat3::from_rotation_z(degrees.to_radians()) * v;
        let away = frame.eye - frame.target;
        let (eye, target) = match frame.motion {
            Motion::Orbit(speed) => {
                let rise = 1.0 + 0.06 * (0.7 * seconds).sin();
                let away = turned(away, speed * seconds) * DVec3::new(1.0, 1.0, rise);
                (frame.target + away, frame.target)
            }
            Motion::Pan(speed) => (frame.eye, frame.eye - turned(away, speed * seconds)),
        };
        Camera::look_at(eye, target, DVec3::Z, fov, width, height)
    }

    /// Ground truth: the field itself along the rays of a camera, in 64-bit floating point. Steps
    /// are an eighth of a voxel edge through surfaces, half of one through haze, and as long as
    /// possible through empty space. Steps of half the length give the same picture to better than
    /// 60 dB.
    #[must_use]
    pub fn truth(self, camera: &Camera, background: [f32; 3]) -> Truth {
        self.truth_in_steps(camera, background, 1.0)
    }

    /// Ground truth with steps that are `scale` times as long, above 0. A scale below 1 shows how
    /// far the truth is from its limit.
    #[must_use]
    pub(crate) fn truth_in_steps(self, camera: &Camera, background: [f32; 3], scale: f64) -> Truth {
        ground_truth::render(
            self.field(),
            camera,
            background,
            scale.clamp(1.0 / 64.0, 8.0),
        )
    }

    /// Samples the scene to a grid: densities at the vertices, and colours fitted by least squares
    /// over the directions from which they are visible.
    ///
    /// # Errors
    /// None in practice: size and values are valid by construction.
    pub fn bake(self) -> Result<Grid, MarchError> {
        bake::bake(self.field())
    }

    /// The same with about `count` vertices in the same box, for grids of another size.
    ///
    /// # Errors
    /// `count` is too small or too large for a grid.
    pub fn bake_of(self, count: usize) -> Result<Grid, MarchError> {
        bake::bake_of(self.field(), count)
    }

    /// Source of samples for models that are not grids.
    #[must_use]
    pub fn sampler(self) -> Sampler {
        Sampler(self.field())
    }

    /// Corners of the box that contains the scene, in world coordinates.
    #[must_use]
    pub fn bounds(self) -> [DVec3; 2] {
        self.frame().bounds()
    }

    /// Edge of a voxel of the sampled grid, in world units.
    #[must_use]
    pub fn voxel(self) -> f64 {
        self.frame().voxel
    }

    /// Density at a world point: an optical depth per unit of length, at least 0.
    #[must_use]
    pub fn density(self, p: DVec3) -> f64 {
        let [low, high] = self.bounds();
        if p.cmplt(low).any() || p.cmpgt(high).any() {
            return 0.0;
        }
        self.field().probe(p).density.max(0.0)
    }

    /// Radius in world units of an empty ball around a world point; at least 0.
    #[must_use]
    pub fn clearance(self, p: DVec3) -> f64 {
        self.field().probe(p).clearance
    }

    /// The colour of a world point, fitted linearly in the unit viewing direction (x, y, z): for
    /// red, green and blue a constant and the slopes along x, y, z.
    #[must_use]
    pub fn linear_colour(self, p: DVec3) -> [[f32; 4]; 3] {
        bake::linear(&self.field().look(p))
    }

    /// The appearance of a world point whose density is not 0.
    #[must_use]
    pub fn look(self, p: DVec3) -> Appearance {
        self.field().look(p)
    }
}
