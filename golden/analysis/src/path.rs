//! What the cameras of a path see.

use glam::DVec3;

use potamoi_base::camera::{Camera, crossing};

/// What a path shows of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seen {
    /// Frames of the path.
    pub frames: usize,
    /// Frames whose camera is not, bit by bit, that of the frame before.
    pub moves: usize,
    /// Farthest from the first camera's place, in the world's unit.
    pub distance: f64,
    /// The largest angle to the first camera's axes, in degrees.
    pub turn: f64,
    /// Frames in which anything may be seen.
    pub in_view: usize,
    /// Of fields, pixels whose rays cross the model's bounds; of splats, (tile, Gaussian) pairs.
    pub met: u64,
    /// Of splats, frames in which depths are in another order than that in which they are stored.
    pub unsorted: usize,
    /// Of splats, bytes of records that are fetched one by one.
    pub fetched_bytes: u64,
}

/// Whether every camera is, bit by bit, the first one.
#[must_use]
pub fn is_still(path: &[Camera]) -> bool {
    path.windows(2).all(|pair| pair[0] == pair[1])
}

impl Seen {
    /// How the cameras of a path lie.
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
