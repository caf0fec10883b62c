//! Subtiles of 8 x 8 pixels that a Gaussian's oriented box meets.

use glam::DVec2;
use potamoi_gaussians::Cloud;
use potamoi_scene::Scene;
use potamoi_splats::{Projected, TILE, View};

/// Standard deviations of a box's half sides.
const DEVIATIONS: f64 = 3.0;

/// Of all subtiles in the tiles of Gaussians, the share that their boxes of three standard deviations along their own
/// axes meet.
pub(super) fn share(scene: &Scene, cloud: &Cloud) -> Result<f64, potamoi_splats::RenderError> {
    let view = View::new(cloud, scene.camera(), scene.profile())?;
    let [columns, _] = view.grid();
    let (mut all, mut met) = (0u64, 0u64);
    for (rank, splat) in view.splats().iter().enumerate() {
        let own = OrientedBox::of(splat);
        for tile in view.tiles_of(rank) {
            let corner = DVec2::new(f64::from(tile % columns), f64::from(tile / columns));
            for quarter in 0..4u32 {
                let half = f64::from(TILE) / 2.0;
                let place = DVec2::new(f64::from(quarter % 2), f64::from(quarter / 2));
                let low = corner * f64::from(TILE) + place * half;
                all += 1;
                met += u64::from(own.meets(low, low + DVec2::splat(half)));
            }
        }
    }
    Ok(met as f64 / all.max(1) as f64)
}

/// A box along a Gaussian's axes.
struct OrientedBox {
    mean: DVec2,
    /// Unit vectors, and half sides along them.
    axes: [DVec2; 2],
    halves: [f64; 2],
}

impl OrientedBox {
    fn of(splat: &Projected) -> Self {
        let [xx, xy, yy] = splat.footprint.covariance;
        let [large, small] = splat.footprint.eigenvalues();
        let long = match xy == 0.0 {
            true if xx >= yy => DVec2::X,
            true => DVec2::Y,
            false => DVec2::new(xy, large - xx).normalize(),
        };
        Self {
            mean: splat.mean,
            axes: [long, long.perp()],
            halves: [large, small].map(|own| DEVIATIONS * own.sqrt()),
        }
    }

    /// Whether it meets a rectangle: no axis of either separates them.
    fn meets(&self, low: DVec2, high: DVec2) -> bool {
        let (centre, side) = ((low + high) / 2.0 - self.mean, (high - low) / 2.0);
        let along = |axis: DVec2| {
            let own: f64 = (0..2)
                .map(|i| self.halves[i] * self.axes[i].dot(axis).abs())
                .sum();
            let other = side.x * axis.x.abs() + side.y * axis.y.abs();
            centre.dot(axis).abs() <= own + other
        };
        [DVec2::X, DVec2::Y, self.axes[0], self.axes[1]]
            .into_iter()
            .all(along)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A needle along the diagonal passes two of the four quarters of a square, an upright box all of them.
    #[test]
    fn a_needle_misses_the_corners_beside_it() {
        let diagonal = DVec2::new(1.0, 1.0).normalize();
        let needle = OrientedBox {
            mean: DVec2::splat(8.0),
            axes: [diagonal, diagonal.perp()],
            halves: [20.0, 0.5],
        };
        let upright = OrientedBox {
            axes: [DVec2::X, DVec2::Y],
            halves: [8.0, 8.0],
            ..needle
        };
        let quarters = [(0.0, 0.0), (8.0, 0.0), (0.0, 8.0), (8.0, 8.0)];
        let met = |own: &OrientedBox, margin: f64| {
            let side = DVec2::splat(8.0 - 2.0 * margin);
            let of = |(x, y)| DVec2::new(x, y) + DVec2::splat(margin);
            quarters.map(|low| own.meets(of(low), of(low) + side))
        };
        assert_eq!(met(&needle, 1.0), [true, false, false, true]);
        assert_eq!(met(&upright, 1.0), [true; 4]);
    }
}
