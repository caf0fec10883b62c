//! Signed distances, negative inside. The exact ones are the usual formulas of constructive solid
//! geometry; those that are only bounds are marked.

use glam::{DMat3, DVec2, DVec3};

/// A box with half sides `half` and edges rounded by `round`.
pub(super) fn cuboid(p: DVec3, half: DVec3, round: f64) -> f64 {
    let q = p.abs() - half + DVec3::splat(round);
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0) - round
}

/// A disc about the z axis with a rounded rim.
pub(super) fn disc(p: DVec3, radius: f64, half: f64, round: f64) -> f64 {
    let q = DVec2::new(p.truncate().length() - radius, p.z.abs() - half) + DVec2::splat(round);
    q.max(DVec2::ZERO).length() + q.max_element().min(0.0) - round
}

/// A ring about the z axis.
pub(super) fn torus(p: DVec3, radius: f64, thick: f64) -> f64 {
    (p.truncate().length() - radius).hypot(p.z) - thick
}

/// An ellipsoid with half axes `half`: exact on the surface, and correct to first order near it.
pub(super) fn ellipsoid(p: DVec3, half: DVec3) -> f64 {
    let scaled = (p / half).length();
    let slope = (p / (half * half)).length();
    if slope < 1e-9 {
        return -half.min_element();
    }
    scaled * (scaled - 1.0) / slope
}

/// The union of two solids, blended over `blend`.
pub(super) fn smooth_min(a: f64, b: f64, blend: f64) -> f64 {
    let near = (blend - (a - b).abs()).max(0.0) / blend;
    a.min(b) - near * near * blend / 4.0
}

/// A rotation of points about an axis, in degrees.
pub(super) fn turned(axis: DVec3, degrees: f64) -> DMat3 {
    DMat3::from_axis_angle(axis.normalize(), degrees.to_radians())
}

/// The unit normal of a distance, by its differences over a tetrahedron of edge about `e`; zero
/// where it is undefined.
pub(super) fn normal(distance: impl Fn(DVec3) -> f64, p: DVec3, e: f64) -> DVec3 {
    const CORNERS: [DVec3; 4] = [
        DVec3::new(1.0, -1.0, -1.0),
        DVec3::new(-1.0, -1.0, 1.0),
        DVec3::new(-1.0, 1.0, -1.0),
        DVec3::new(1.0, 1.0, 1.0),
    ];
    let sum: DVec3 = CORNERS.iter().map(|k| *k * distance(p + *k * e)).sum();
    sum.normalize_or_zero()
}
