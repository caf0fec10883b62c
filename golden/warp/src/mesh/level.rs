//! The density level at which a model has its surface.

use super::marching_cubes::{Density, Lattice};

/// Approximate number of planes of points that are sampled.
const PLANES: usize = 48;

/// The density at which rays reach half transmittance, for rays from outside along x and y in both
/// directions: the quantile `share` over all rays that do. `None` if there are none.
///
/// A surface at that level lies at the depth of a rendering. The level depends on how steeply the
/// model's density rises: from fog to walls it varies by orders of magnitude, so no constant would
/// do.
#[must_use]
pub fn half_light(density: &dyn Density, lattice: &Lattice, share: f64) -> Option<f64> {
    let [width, height, depth] = lattice.points();
    let every = (depth / PLANES).max(1);
    let mut plane = vec![0f32; width * height];
    let mut found = vec![];
    for z in (every / 2..depth).step_by(every) {
        density.plane(lattice, z, &mut plane);
        let mut ray = |first: usize, step: usize, count: usize| {
            let along = (0..count).map(|k| f64::from(plane[first + k * step]));
            found.extend(stopped(along.clone(), lattice.cell()));
            found.extend(stopped(along.rev(), lattice.cell()));
        };
        (0..height).for_each(|y| ray(y * width, 1, width));
        (0..width).for_each(|x| ray(x, width, height));
    }
    found.sort_by(f64::total_cmp);
    let at = found.len().checked_sub(1)? as f64 * share.clamp(0.0, 1.0);
    found.get(at as usize).copied()
}

/// Minimum factor by which a density rises where a ray meets a surface.
const RISE: f64 = 1.05;

/// The density at which a ray reaches half transmittance, if it does; linear from value to value.
/// A ray that starts inside matter, as in a wall that the box cuts, has met no surface, and starts
/// again in empty space.
fn stopped(mut along: impl Iterator<Item = f64>, step: f64) -> Option<f64> {
    let mut rest = std::f64::consts::LN_2;
    // Not a number is not above another.
    let held = |v: f64| if v > 0.0 { v } else { 0.0 };
    let mut here = held(along.next()?);
    let mut least = here;
    for next in along.map(held) {
        let depth = 0.5 * step * (here + next);
        least = least.min(next);
        if depth >= rest && next > RISE * least {
            // Of the quadratic equation the root for either sign of the slope:
            // the square of the density grows by twice slope and depth.
            let slope = (next - here) / step;
            return Some((here * here + 2.0 * slope * rest).max(0.0).sqrt());
        }
        rest = (rest - depth).max(0.0);
        if rest == 0.0 && next == 0.0 {
            rest = std::f64::consts::LN_2;
        }
        here = next;
    }
    None
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::mesh::marching_cubes::Points;
    use glam::DVec3;

    /// A density that rises by 18 a unit of length has stopped half of the light
    /// after `sqrt(2 ln 2 / 18)`.
    #[test]
    fn of_a_linear_rise_it_is_the_density_at_that_depth() {
        let lattice = Lattice::new([DVec3::ZERO, DVec3::ONE], 100).unwrap();
        // Along y nothing is stopped: it is the same all along.
        let rise = Points(|p: DVec3| 18.0 * p.x.min(1.0 - p.x) - 0.18);
        let expected = (2.0 * std::f64::consts::LN_2 * 18.0).sqrt();
        let x = half_light(&rise, &lattice, 0.0).unwrap();
        assert!(x > 0.6 && x < expected + 0.01, "{x}");
        let most = stopped((0..100).map(|k| 0.18 * f64::from(k)), 0.01).unwrap();
        assert!((most - expected).abs() < 1e-9, "{most} {expected}");
        assert!(half_light(&Points(|_| 0.1), &lattice, 0.5).is_none());
        assert!(half_light(&Points(|_| f64::NAN), &lattice, 0.5).is_none());
        assert!(half_light(&Points(|_| 7.0), &lattice, 0.5).is_none());
    }

    /// A room whose walls the box cuts: its surface is inside, below what the
    /// walls are throughout.
    #[test]
    fn walls_that_the_box_cuts_are_met_from_inside() {
        let lattice = Lattice::new([DVec3::ZERO, DVec3::ONE], 200).unwrap();
        let off = |p: DVec3| (p.x - 0.5).abs().max((p.y - 0.5).abs());
        let room = Points(move |p| ((off(p) - 0.35) * 4000.0).clamp(0.0, 100.0));
        let level = half_light(&room, &lattice, 0.5).unwrap();
        assert!(level > 1.0 && level < 99.0, "{level}");
    }
}
