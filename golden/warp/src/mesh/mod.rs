//! Triangle meshes, a cheap source of depth for [`warp`](crate) (paper, "Sparse Radiance Warping":
//! the depth of frames that are not rendered).
//!
//! A mesh is read from a file ([`read`]), or it is the surface at which a model's density crosses
//! a level ([`Mesh::of_density`]). [`Mesh::depth`] rasterises it.

mod cases;
mod error;
mod files;
mod level;
mod marching_cubes;
mod raster;
#[cfg(test)]
mod tests;

pub use error::MeshError;
pub use files::{OBJ, PLY, read, read_obj, read_ply, write_ply};
pub use level::half_light;
pub use marching_cubes::{Density, Lattice, MAX_CELLS, MAX_TRIANGLES};

use crate::{Geometry, WarpError};
use potamoi_base::camera::Camera;

/// Maximum number of pixels in a depth frame.
const MAX_PIXELS: u64 = 1 << 26;

/// A triangle mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A mesh of vertices in world coordinates, and of triangles with three vertex numbers each,
    /// counterclockwise as seen from outside, if there is an outside. It may be empty, open or
    /// self-intersecting; triangles may have no area.
    ///
    /// # Errors
    /// A coordinate is not finite, or a triangle refers to a vertex that does not exist.
    pub fn new(vertices: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        let is_wrong = |v: &[f32; 3]| v.iter().any(|c| !c.is_finite());
        if let Some(i) = vertices.iter().position(is_wrong) {
            return Err(MeshError::Value {
                field: format!("vertex {i}"),
                value: format!("{:?}", vertices[i]),
                expected: "finite coordinates".to_owned(),
            });
        }
        let is_wrong = |t: &[u32; 3]| t.iter().any(|v| *v as usize >= vertices.len());
        if let Some(i) = triangles.iter().position(is_wrong) {
            return Err(MeshError::Value {
                field: format!("triangle {i}"),
                value: format!("{:?}", triangles[i]),
                expected: format!("numbers below {}, one a vertex", vertices.len()),
            });
        }
        Ok(Self {
            vertices,
            triangles,
        })
    }

    /// Whether any triangle has an area, that is, corners that are not collinear.
    #[must_use]
    pub(crate) fn has_area(&self) -> bool {
        self.triangles.iter().any(|t| {
            let [a, b, c] = t.map(|v| glam::Vec3::from(self.vertices[v as usize]).as_dvec3());
            (b - a).cross(c - a) != glam::DVec3::ZERO
        })
    }

    /// Vertices in world coordinates.
    #[must_use]
    pub fn vertices(&self) -> &[[f32; 3]] {
        &self.vertices
    }

    /// The vertex numbers of each triangle.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Depth of each pixel's centre along the camera's axis, row by row: that of the nearest
    /// triangle, seen from either side; infinite if there is none. Everything in front of the
    /// camera's plane counts, however near. Pixels on an edge shared by two triangles belong to
    /// both, so there are no holes. Triangles seen edge-on or without area cover no pixels. The
    /// result does not depend on the number of threads or the order of triangles.
    #[must_use]
    pub fn depth(&self, camera: &Camera) -> Vec<f32> {
        raster::depth(self, camera)
    }
}

impl Geometry for Mesh {
    fn depth(&self, camera: &Camera) -> Result<Vec<f32>, WarpError> {
        let pixels = u64::from(camera.width) * u64::from(camera.height);
        if pixels > MAX_PIXELS {
            return Err(WarpError::Option {
                field: "camera",
                value: format!("{} x {} pixels", camera.width, camera.height),
                expected: format!("at most {MAX_PIXELS} pixels"),
            });
        }
        Ok(Self::depth(self, camera))
    }
}
