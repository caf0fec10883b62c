//! The tiles in which a projected Gaussian is drawn.

use glam::DVec2;

use super::profile::{Extent, Rules};
use super::project::Projected;
use potamoi_reference::splat_unit::TILE;

/// Tile columns and rows of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Grid {
    pub(crate) columns: u32,
    pub(crate) rows: u32,
}

/// A rectangle of tiles: first column and row, and one past the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) x: [u32; 2],
    pub(crate) y: [u32; 2],
}

impl Span {
    /// Number of tiles.
    pub(crate) fn count(&self) -> u64 {
        let along = |[from, to]: [u32; 2]| u64::from(to.saturating_sub(from));
        along(self.x) * along(self.y)
    }

    /// The tiles that are in both.
    pub(crate) fn within(&self, other: &Self) -> Self {
        let both = |a: [u32; 2], b: [u32; 2]| [a[0].max(b[0]), a[1].min(b[1])];
        Self {
            x: both(self.x, other.x),
            y: both(self.y, other.y),
        }
    }
}

/// The number of tiles before a boundary at `value` tiles, clamped to 0..=limit.
fn held(value: f64, limit: u32) -> u32 {
    // The cast is exact after the clamp; NaN cannot reach it.
    value.clamp(0.0, f64::from(limit)) as u32
}

impl Grid {
    fn span(self, mean: DVec2, reach: DVec2, up: impl Fn(f64) -> f64) -> Span {
        let tile = f64::from(TILE);
        let low = (mean - reach) / tile;
        let high = mean + reach;
        Span {
            x: [
                held(low.x.floor(), self.columns),
                held(up(high.x), self.columns),
            ],
            y: [held(low.y.floor(), self.rows), held(up(high.y), self.rows)],
        }
    }
}

/// The squared distance `p^2 + q^2` at which alpha falls to the alpha threshold; `None` if the
/// opacity itself is below it.
fn reach_squared(splat: &Projected, rules: &Rules) -> Option<f64> {
    (splat.opacity >= rules.alpha_min).then(|| 2.0 * (splat.opacity / rules.alpha_min).ln())
}

/// The rectangle that holds every tile that the Gaussian is drawn in; `None` without any. By the rule
/// of the ellipse some of its tiles may be left out.
pub(crate) fn rectangle(splat: &Projected, grid: Grid, rules: &Rules) -> Option<Span> {
    let tile = f64::from(TILE);
    let [xx, _, yy] = splat.footprint.covariance;
    let round_up = |v: f64| (v / tile).ceil();
    match rules.extent {
        Extent::Square => {
            let radius = (3.0 * splat.footprint.reference_eigenvalue().sqrt()).ceil();
            // The reference adds a tile less one pixel and truncates.
            Some(grid.span(splat.mean, DVec2::splat(radius), |v| {
                ((v + (tile - 1.0)) / tile).floor()
            }))
        }
        Extent::AxisBox => {
            let reach = reach_squared(splat, rules)?;
            let extent = reach.sqrt().min(3.33);
            let radius = (extent * DVec2::new(xx, yy).map(f64::sqrt)).ceil();
            Some(grid.span(splat.mean, radius, round_up))
        }
        Extent::Ellipse => {
            let reach = reach_squared(splat, rules)?;
            let radius = DVec2::new(xx, yy).map(|v| (v * reach).sqrt());
            Some(grid.span(splat.mean, radius, round_up))
        }
    }
}

/// Calls `visit` with every tile that the Gaussian is drawn in, ascending.
pub(crate) fn tiles(splat: &Projected, grid: Grid, rules: &Rules, mut visit: impl FnMut(u32)) {
    let tile = f64::from(TILE);
    let Some(span) = rectangle(splat, grid, rules) else {
        return;
    };
    for y in span.y[0]..span.y[1] {
        for x in span.x[0]..span.x[1] {
            if rules.extent == Extent::Ellipse {
                let low = DVec2::new(f64::from(x), f64::from(y)) * tile - splat.mean;
                let nearest = splat.footprint.distance_to_box(low, low + tile);
                if reach_squared(splat, rules).is_none_or(|reach| nearest > reach) {
                    continue;
                }
            }
            visit(y * grid.columns + x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Footprint, Profile};
    use glam::DVec3;
    use proptest::prelude::*;

    const GRID: Grid = Grid {
        columns: 7,
        rows: 5,
    };

    fn splat(mean: DVec2, a: DVec3, b: DVec3, opacity: f64) -> Projected {
        Projected {
            index: 0,
            depth: 1.0,
            mean,
            footprint: Footprint::new(a, b, 0.3),
            opacity,
            colour: DVec3::ONE,
        }
    }

    fn covered(s: &Projected, rules: &Rules) -> Vec<u32> {
        let mut out = Vec::new();
        tiles(s, GRID, rules, |t| out.push(t));
        out
    }

    #[test]
    fn a_point_in_a_tile_covers_it_and_far_ones_nothing() {
        let point = |x, y| splat(DVec2::new(x, y), DVec3::ZERO, DVec3::ZERO, 0.9);
        for profile in Profile::ALL {
            let rules = profile.rules();
            assert_eq!(covered(&point(24.0, 24.0), &rules), [8], "{profile}");
            for (x, y) in [(-1e30, 5.0), (5.0, 1e30), (-20.0, -20.0), (1e300, 1e300)] {
                assert!(covered(&point(x, y), &rules).is_empty(), "{profile}");
            }
        }
    }

    #[test]
    fn a_splat_larger_than_the_frame_covers_all_of_it() {
        let big = splat(
            DVec2::new(-3000.0, 40.0),
            DVec3::new(1e20, 0.0, 0.0),
            DVec3::new(0.0, 1e19, 0.0),
            0.9,
        );
        for profile in Profile::ALL {
            assert_eq!(covered(&big, &profile.rules()).len(), 35, "{profile}");
        }
    }

    #[test]
    fn invisible_opacities_cover_nothing_where_the_rule_looks_at_them() {
        let faint = splat(DVec2::new(24.0, 24.0), DVec3::ZERO, DVec3::ZERO, 0.003);
        assert!(covered(&faint, &Profile::Gsplat.rules()).is_empty());
        assert!(covered(&faint, &Profile::Brush.rules()).is_empty());
        assert_eq!(covered(&faint, &Profile::Inria.rules()), [8]);
    }

    proptest! {
        /// The exact test drops no pixel above the alpha threshold, and the square keeps at least
        /// the tiles within two standard deviations.
        #[test]
        fn no_visible_pixel_is_missed(
            x in -50f64..160.0, y in -50f64..130.0, a in -20f64..20.0, b in -20f64..20.0,
            c in -20f64..20.0, opacity in 0.01f64..1.0
        ) {
            let s = splat(DVec2::new(x, y), DVec3::new(a, b, 0.0), DVec3::new(c, 0.1, 0.0), opacity);
            for profile in [Profile::Brush, Profile::Inria] {
                let rules = profile.rules();
                let list = covered(&s, &rules);
                prop_assert!(list.is_sorted_by(|p, q| p < q));
                for py in 0..GRID.rows * TILE {
                    for px in 0..GRID.columns * TILE {
                        let at = DVec2::new(f64::from(px), f64::from(py)) + rules.pixel_centre;
                        let seen = match profile {
                            Profile::Brush => s.alpha(at - s.mean) >= rules.alpha_min,
                            _ => s.footprint.distance_squared(at - s.mean) < 4.0,
                        };
                        let tile = py / TILE * GRID.columns + px / TILE;
                        prop_assert!(!seen || list.contains(&tile), "{profile} {px} {py}");
                    }
                }
            }
        }
    }
}
