//! Rays through a volume of vertices, and their samples.

use glam::DVec3;

use potamoi_base::camera::{Camera, crossing};
use potamoi_march::MarchError;

/// Maximum number of pixels in a picture.
pub(super) const MAX_PIXELS: u64 = 1 << 26;

/// A ray in vertex units. Sample `k` lies at `start + k step` along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Position of the camera.
    pub origin: DVec3,
    /// Vertices along the ray in a voxel edge; a unit vector if voxels are cubes.
    pub direction: DVec3,
    /// Unit direction in world coordinates.
    pub towards: DVec3,
    /// Distance at which it enters the volume; 0 if it starts inside.
    pub start: f64,
    /// Step in voxel edges.
    pub step: f64,
    /// Number of samples in the volume; 0 if the ray misses it.
    pub samples: u32,
}

impl Ray {
    /// A ray from `origin` along the unit vector `direction`, both in vertex units, through a
    /// volume of `points` vertices.
    #[must_use]
    pub fn new(points: [usize; 3], origin: DVec3, direction: DVec3, step: f64) -> Self {
        let all = [0.0, f64::INFINITY];
        Self::within(points, origin, direction, direction, step, all)
    }

    /// A ray through voxels that need not be cubes. `direction` is in vertices a voxel edge,
    /// `towards` is the unit vector in world coordinates. Samples are restricted to distances in
    /// `range`, in voxel edges.
    fn within(
        points: [usize; 3],
        origin: DVec3,
        direction: DVec3,
        towards: DVec3,
        step: f64,
        range: [f64; 2],
    ) -> Self {
        let last = DVec3::from(points.map(|p| (p - 1) as f64));
        let [near, far] = crossing([DVec3::ZERO, last], origin, direction, range);
        let samples = if far >= near && far.is_finite() {
            ((far - near) / step) as u32 + 1
        } else {
            0
        };
        Self {
            origin,
            direction,
            towards,
            start: near,
            step,
            samples,
        }
    }

    /// Distance of a sample along the ray, in voxel edges.
    #[must_use]
    pub fn distance(&self, k: u32) -> f64 {
        self.start + f64::from(k) * self.step
    }

    /// Position of a sample in vertex units. Every coordinate is monotone in `k`, including
    /// rounding.
    #[must_use]
    pub fn at(&self, k: u32) -> DVec3 {
        self.origin + self.direction * self.distance(k)
    }
}

/// Position of a volume of vertices in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Number of vertices along x, y, z.
    pub points: [usize; 3],
    /// Position of the first vertex.
    pub corner: DVec3,
    /// Distance between vertices along each axis.
    pub spacing: DVec3,
    /// Voxel edge, the unit of steps; equal to the spacing if voxels are cubes.
    pub edge: f64,
    /// Distances of the nearest and the farthest sample along the camera's axis, in world units.
    pub range: [f64; 2],
}

/// The rays of a camera that has been checked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rays {
    camera: Camera,
    placement: Placement,
    pub(crate) origin: DVec3,
    step: f64,
}

impl Rays {
    /// Checks a camera and a step in voxel edges.
    pub(crate) fn placed(
        placement: &Placement,
        camera: &Camera,
        step: f64,
    ) -> Result<Self, MarchError> {
        let refuse = |field, value: String, expected| {
            Err(MarchError::Camera {
                field,
                value,
                expected,
            })
        };
        let pixels = u64::from(camera.width) * u64::from(camera.height);
        if pixels == 0 || pixels > MAX_PIXELS {
            let value = format!("{} x {}", camera.width, camera.height);
            return refuse("width x height", value, "1 to 67108864 pixels");
        }
        let focal = camera.focal;
        if !(focal.is_finite() && focal.min_element() > 0.0) {
            let value = format!("{:?}", focal.to_array());
            return refuse("focal", value, "positive lengths in pixels");
        }
        if !camera.centre.is_finite() {
            let value = format!("{:?}", camera.centre.to_array());
            return refuse("centre", value, "finite numbers");
        }
        let pose = camera.world_to_camera;
        let rotation = pose.matrix3;
        let off = (rotation * rotation.transpose()).to_cols_array();
        let unit = glam::DMat3::IDENTITY.to_cols_array();
        let rigid = off.iter().zip(unit).all(|(a, b)| (a - b).abs() < 1e-4);
        if !(pose.is_finite() && rigid) {
            let value = format!("{:?}", rotation.to_cols_array_2d());
            return refuse(
                "world_to_camera",
                value,
                "a rotation and a finite translation",
            );
        }
        let origin = (camera.position() - placement.corner) / placement.spacing;
        if !(origin.is_finite() && origin.abs().max_element() < 1e9) {
            let value = format!("{:?}", camera.position().to_array());
            return refuse("position", value, "a place within 1e9 voxels of the grid");
        }
        if !(1.0 / 64.0..=8.0).contains(&step) {
            return Err(MarchError::Option {
                field: "step",
                value: step.to_string(),
                expected: "1/64 to 8 voxel edges",
            });
        }
        Ok(Self {
            camera: *camera,
            placement: *placement,
            origin,
            step,
        })
    }

    /// The ray through the centre of a pixel.
    #[must_use]
    pub(crate) fn ray(&self, x: u32, y: u32) -> Ray {
        let (_, towards) = self.camera.ray(x, y);
        let Placement {
            points,
            spacing,
            edge,
            range,
            ..
        } = self.placement;
        let direction = towards * (DVec3::splat(edge) / spacing);
        // A step along the ray over one along the camera's axis.
        let slant = 1.0 / self.camera.world_to_camera.matrix3.row(2).dot(towards);
        let range = range.map(|depth| depth / edge * slant);
        Ray::within(points, self.origin, direction, towards, self.step, range)
    }
}
