//! What the cameras of a path see.

use glam::DVec3;

use potamoi_base::camera::{Camera, crossing};

/// Visibility of a scene along a path.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PathVisibility {
    /// Number of frames on the path.
    pub frames: usize,
    /// Frames whose camera differs in any bit from that of the frame before.
    pub moves: usize,
    /// Largest distance from the first camera's position, in world units.
    pub distance: f64,
    /// Largest rotation from the first camera, in degrees.
    pub turn: f64,
    /// Frames in which any part may be visible.
    pub in_view: usize,
    /// For fields, pixels whose rays cross the model's bounds; for splats, (tile, Gaussian) pairs.
    pub met: u64,
    /// For splats, frames whose depth order differs from the stored order.
    pub unsorted: usize,
    /// For splats, bytes of records fetched one by one.
    pub fetched_bytes: u64,
}

/// Whether every camera equals the first one bit by bit.
#[must_use]
pub fn is_still(path: &[Camera]) -> bool {
    path.windows(2).all(|pair| pair[0] == pair[1])
}

impl PathVisibility {
    /// The motion of a path's cameras.
    #[must_use]
    pub fn moved(path: &[Camera]) -> Self {
        let mut seen = Self {
            frames: path.len(),
            moves: path.windows(2).filter(|pair| pair[0] != pair[1]).count(),
            ..Self::default()
        };
        let Some(first) = path.first() else {
            return seen;
        };
        for camera in path {
            let away = camera.position() - first.position();
            seen.distance = seen.distance.max(away.length());
            let between =
                camera.world_to_camera.matrix3 * first.world_to_camera.matrix3.transpose();
            // The sum of the axes' cosines, less what rounding adds; none where nothing turned.
            let cosine = (between.x_axis.x + between.y_axis.y + between.z_axis.z - 1.0) / 2.0;
            if camera.world_to_camera.matrix3 != first.world_to_camera.matrix3 {
                seen.turn = seen.turn.max(cosine.clamp(-1.0, 1.0).acos().to_degrees());
            }
        }
        seen
    }

    /// Counts pixels of a camera whose rays cross a box.
    pub(super) fn cross(&mut self, camera: &Camera, bounds: [DVec3; 2]) {
        let pixels = (0..camera.height).flat_map(|y| (0..camera.width).map(move |x| [x, y]));
        let met = pixels.filter(|[x, y]| {
            let (origin, direction) = camera.ray(*x, *y);
            let [near, far] = crossing(bounds, origin, direction, [0.0, f64::INFINITY]);
            near <= far
        });
        let met = met.count() as u64;
        self.met += met;
        self.in_view += usize::from(met > 0);
    }
}
