//! Scales and rotations of decoded Gaussians.
//!
//! The rasteriser builds a matrix from a quaternion without normalising it, and a sum of codes is
//! not of length 1. It draws the covariance `M Mᵀ`, where `M` is that matrix with scaled columns.
//! Here columns are rotated against each other until they are orthogonal, by one-sided Jacobi
//! rotations, which leave the covariance unchanged. Their lengths are then the scales.

use glam::{DMat3, DQuat, DVec3};

/// Maximum number of sweeps over all pairs of columns; four or five suffice.
const SWEEPS: usize = 12;
/// Largest cosine between columns that count as orthogonal.
const ORTHOGONAL: f64 = 1e-15;
/// The smallest scale, since the logarithm of 0 is not finite.
const LEAST: f64 = 1e-37;

/// Log scales and unit quaternion `w, x, y, z` of the Gaussian that the rasteriser draws for
/// decoded values.
pub(super) fn axes(scales: [f64; 3], rotation: [f64; 4]) -> ([f32; 3], [f32; 4]) {
    let mut columns = matrix(rotation);
    for (column, scale) in columns.iter_mut().zip(scales) {
        // A scale's sign does not change the covariance.
        *column *= scale.abs();
    }
    for _ in 0..SWEEPS {
        let turned = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| turn(&mut columns, i, j));
        if turned == [false; 3] {
            break;
        }
    }
    let lengths = columns.map(DVec3::length);
    let quaternion = DQuat::from_mat3(&frame(columns, lengths)).normalize();
    let log_scales = lengths.map(|l| l.max(LEAST).ln() as f32);
    let [x, y, z, w] = quaternion.to_array().map(|v| v as f32);
    (log_scales, [w, x, y, z])
}

/// The columns of the rasteriser's matrix for a quaternion of any length.
fn matrix([w, x, y, z]: [f64; 4]) -> [DVec3; 3] {
    let column = |a, b, c| DVec3::new(a, b, c);
    [
        column(
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
        ),
        column(
            2.0 * (x * y - w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + w * x),
        ),
        column(
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            1.0 - 2.0 * (x * x + y * y),
        ),
    ]
}

/// Rotates two columns within their plane until they are orthogonal; returns whether that was
/// needed.
fn turn(columns: &mut [DVec3; 3], i: usize, j: usize) -> bool {
    let (a, b) = (columns[i], columns[j]);
    let (aa, bb, ab) = (a.length_squared(), b.length_squared(), a.dot(b));
    if ab.abs() <= ORTHOGONAL * (aa * bb).sqrt() {
        return false;
    }
    let zeta = (bb - aa) / (2.0 * ab);
    let tan = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
    let cos = 1.0 / tan.hypot(1.0);
    let sin = cos * tan;
    columns[i] = a * cos - b * sin;
    columns[j] = a * sin + b * cos;
    true
}

/// The rotation whose axes are the columns. A column of length 0 is completed from the others, and
/// one is reversed if they are left-handed.
fn frame(columns: [DVec3; 3], lengths: [f64; 3]) -> DMat3 {
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| lengths[*b].total_cmp(&lengths[*a]));
    let [first, second, third] = order;
    let long = columns[first].try_normalize().unwrap_or(DVec3::X);
    // What rounding left along the longest is taken out.
    let across = columns[second].try_normalize().unwrap_or(DVec3::ZERO);
    let across = (across - long * long.dot(across)).try_normalize();
    let across = across.unwrap_or_else(|| long.any_orthonormal_vector());
    let mut axes = [DVec3::ZERO; 3];
    (axes[first], axes[second]) = (long, across);
    // Right-handed in the order of the columns.
    let even = (second + 3 - first) % 3 == 1;
    axes[third] = long.cross(across) * if even { 1.0 } else { -1.0 };
    DMat3::from_cols(axes[0], axes[1], axes[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use potamoi_gaussians::rotation;

    fn covariance(columns: [DVec3; 3]) -> DMat3 {
        let m = DMat3::from_cols(columns[0], columns[1], columns[2]);
        m * m.transpose()
    }

    fn error(scales: [f64; 3], quaternion: [f64; 4]) -> f64 {
        let mut drawn = matrix(quaternion);
        for (column, scale) in drawn.iter_mut().zip(scales) {
            *column *= scale;
        }
        let (log_scales, unit) = axes(scales, quaternion);
        let turned = rotation(unit);
        let mut made = [turned.x_axis, turned.y_axis, turned.z_axis];
        for (column, log) in made.iter_mut().zip(log_scales) {
            *column *= f64::from(log).exp();
        }
        let [drawn, made] = [drawn, made].map(covariance);
        let size = drawn.x_axis.x + drawn.y_axis.y + drawn.z_axis.z;
        let parts = (drawn - made).to_cols_array();
        parts.iter().fold(0.0f64, |m, v| m.max(v.abs())) / size.max(1e-30)
    }

    /// The covariance is the rasteriser's for quaternions of any length, scales
    /// of any sign, and flat and equal ones: to the rounding of a log scale
    /// (2^-24 of 8, doubled by the square) and of a quaternion.
    #[test]
    fn the_covariance_is_the_rasterisers() {
        let quaternions = [
            [1.0, 0.0, 0.0, 0.0],
            [0.9, 0.3, -0.2, 0.4],
            [0.5, -0.6, 0.6, 0.1],
            [0.0, 1.3, 0.2, -0.4],
            [0.0, 0.0, 0.0, 0.0],
            [-0.02, 0.7, 0.7, 0.01],
        ];
        let scales = [
            [0.01, 0.2, 0.05],
            [0.3, 0.3, 0.3],
            [0.1, -0.2, 0.001],
            [1e-6, 2.0, 1e-5],
            [0.5, 0.0, 0.2],
            [0.0, 0.0, 0.2],
        ];
        for quaternion in quaternions {
            for scale in scales {
                let error = error(scale, quaternion);
                assert!(error < 2e-6, "{quaternion:?} {scale:?}: {error}");
            }
        }
        assert_eq!(
            axes([0.0; 3], [1.0, 0.0, 0.0, 0.0]).0,
            [LEAST.ln() as f32; 3]
        );
    }

    /// What is normalised stays what it is.
    #[test]
    fn unit_quaternions_keep_their_axes() {
        let unit = DQuat::from_xyzw(0.3, -0.2, 0.4, 0.9).normalize();
        let (logs, found) = axes([0.1, 0.2, 0.3], [unit.w, unit.x, unit.y, unit.z]);
        for (log, scale) in logs.iter().zip([0.1f64, 0.2, 0.3]) {
            assert!((f64::from(*log) - scale.ln()).abs() < 1e-6);
        }
        let parts = [unit.w, unit.x, unit.y, unit.z];
        for (a, b) in found.iter().zip(parts) {
            assert!((f64::from(*a) - b).abs() < 1e-6, "{found:?}");
        }
    }
}
