//! The order in which MVoxels are visited: by the Manhattan distance of their indices from the
//! camera's.

use super::{FRACTION_BITS, Tiling};

/// The distances of MVoxels from a camera.
#[derive(Debug, Clone, Copy)]
pub struct CameraDistances {
    /// The index of the camera's MVoxel; 0 along axes of one vertex.
    own: [i64; 3],
}

impl Tiling {
    /// Distances from a camera at `eye`, in vertices.
    pub fn distances_from(&self, eye: [f64; 3]) -> CameraDistances {
        let stride = self.stride();
        let along = |axis: usize| match self.points()[axis] {
            1 => 0,
            _ => {
                let index =
                    position_code(eye[axis]).div_euclid((stride[axis] as i64) << FRACTION_BITS);
                // Far enough, and no sum of three overflows.
                index.clamp(-(1 << 50), 1 << 50)
            }
        };
        CameraDistances {
            own: [0, 1, 2].map(along),
        }
    }
}

impl CameraDistances {
    /// Manhattan distance of an MVoxel's index from the camera's. A ray that leaves the camera
    /// meets the owners of its samples at strictly increasing distances, since none of its indices
    /// ever turns back.
    #[inline]
    pub fn distance(&self, index: [usize; 3]) -> u64 {
        let along = |axis: usize| self.own[axis].abs_diff(index[axis] as i64);
        along(0) + along(1) + along(2)
    }
}

/// A coordinate rounded to 12 fraction bits, to nearest; monotone and saturating.
#[inline]
pub fn position_code(v: f64) -> i64 {
    (v * f64::from(1u32 << FRACTION_BITS)).round() as i64
}
