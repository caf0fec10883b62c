//! Terrain: tabulated heights over a square, for a formula that is slow to evaluate.

use glam::{DVec2, DVec4, dvec2};

/// Heights on a grid, with bicubic patches between the points that preserve their heights, slopes
/// and twists. The error falls with the fourth power of the spacing.
pub(super) struct Heights {
    corner: DVec2,
    /// Number of cells per unit of length.
    per_unit: f64,
    /// Number of cells along a side.
    cells: usize,
    /// Height, slopes along x and y, and twist at `cells + 1` points a side, x fastest, with a
    /// cell as the unit of length.
    points: Vec<DVec4>,
}

impl Heights {
    /// Tabulates `land`, which returns heights and slopes, within `half` of the origin along x and
    /// y.
    pub(super) fn new(half: f64, cells: usize, land: impl Fn(DVec2) -> (f64, DVec2)) -> Self {
        let corner = DVec2::splat(-half);
        let spacing = 2.0 * half / cells as f64;
        // A column more at either side, for the twist.
        let row = |y: usize| -> Vec<(f64, DVec2)> {
            let place = |x: usize| corner + spacing * dvec2(x as f64 - 1.0, y as f64);
            (0..cells + 3).map(|x| land(place(x))).collect()
        };
        let points = (0..=cells).flat_map(|y| {
            let row = row(y);
            (1..cells + 2)
                .map(|x| {
                    let (height, slope) = row[x];
                    let twist = (row[x + 1].1.y - row[x - 1].1.y) / 2.0;
                    DVec4::new(
                        height,
                        slope.x * spacing,
                        slope.y * spacing,
                        twist * spacing,
                    )
                })
                .collect::<Vec<_>>()
        });
        Self {
            corner,
            per_unit: spacing.recip(),
            cells,
            points: points.collect(),
        }
    }

    /// Height and slopes along x and y; `None` outside the square.
    pub(super) fn at(&self, at: DVec2) -> Option<(f64, DVec2)> {
        let place = (at - self.corner) * self.per_unit;
        let side = self.cells as f64;
        // Not a number is inside nothing.
        if !(place.cmpge(DVec2::ZERO).all() && place.cmplt(DVec2::splat(side)).all()) {
            return None;
        }
        let (x, y) = (place.x as usize, place.y as usize);
        let low = y * (self.cells + 1) + x;
        let high = low + self.cells + 1;
        let ([a, da], [b, db]) = (hermite(place.x - x as f64), hermite(place.y - y as f64));
        // Along x: height and slope along y, at the lower and the upper edge.
        let along = |w: DVec4, first: usize| {
            let (p, q) = (self.points[first], self.points[first + 1]);
            dvec2(p.x, p.z) * w.x
                + dvec2(p.y, p.w) * w.y
                + dvec2(q.x, q.z) * w.z
                + dvec2(q.y, q.w) * w.w
        };
        let join = |low: DVec2, high: DVec2| DVec4::new(low.x, low.y, high.x, high.y);
        let heights = join(along(a, low), along(a, high));
        let slopes = join(along(da, low), along(da, high));
        let slope = dvec2(slopes.dot(b), heights.dot(db)) * self.per_unit;
        Some((heights.dot(b), slope))
    }
}

/// Weights of the value and slope at 0 and of those at 1, and their derivatives.
fn hermite(t: f64) -> [DVec4; 2] {
    let s = t * t;
    let c = s * t;
    [
        DVec4::new(
            2.0 * c - 3.0 * s + 1.0,
            c - 2.0 * s + t,
            3.0 * s - 2.0 * c,
            c - s,
        ),
        DVec4::new(
            6.0 * (s - t),
            3.0 * s - 4.0 * t + 1.0,
            6.0 * (t - s),
            3.0 * s - 2.0 * t,
        ),
    ]
}
