//! Triangle meshes, which tell [`warp`](crate) at little cost how far away
//! things are (paper, "Sparse Radiance Warping": the depth of frames that are
//! not rendered).
//!
//! A mesh is read from a file ([`read`]), or it is the surface of a model at
//! which its density passes a level ([`of_scene`], [`Mesh::of_density`]).
//! [`Mesh::depth`] draws it.

mod cases;
mod error;
mod files;
mod level;
mod march;
mod raster;
#[cfg(test)]
mod tests;

pub use error::MeshError;
pub use files::{OBJ, PLY, read, read_obj, read_ply, write_ply};
pub use level::half_light;
pub use march::{Density, Lattice, MAX_CELLS, MAX_TRIANGLES};

use crate::{Geometry, WarpError};
use potamoi_base::camera::Camera;

/// The most pixels of a frame of depths.
const MAX_PIXELS: u64 = 1 << 26;

/// A triangle mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A mesh of vertices in the world, and of triangles that name three of
    /// them each, counterclockwise as seen from outside where it has one. It may
    /// be empty, open, and cut itself; triangles may have no area.
    ///
    /// # Errors
    /// Coordinates that are not finite, or a triangle of a vertex that is not
    /// there.
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

    /// Whether any triangle has an area: its corners are not all on a line.
    #[must_use]
    pub fn has_area(&self) -> bool {
        self.triangles.iter().any(|t| {
            let [a, b, c] = t.map(|v| glam::Vec3::from(self.vertices[v as usize]).as_dvec3());
            (b - a).cross(c - a) != glam::DVec3::ZERO
        })
    }

    /// Vertices, in the world.
    #[must_use]
    pub fn vertices(&self) -> &[[f32; 3]] {
        &self.vertices
    }

    /// Numbers of the vertices of each triangle.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Depth of each pixel's centre along the camera's axis, row by row: that of
    /// the nearest triangle, whichever of its faces is seen; infinite where
    /// there is none. Everything in front of the camera's plane counts, however
    /// near. Pixels on the edge that two triangles share belong to both, so that
    /// there is no hole, and triangles seen edge-on, or without area, have none.
    /// The result does not depend on the number of threads or the order of
    /// triangles.
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
