//! What stored rotations and opacities stand for.

use glam::{DMat3, DQuat};

/// The rotation of a quaternion `w, x, y, z` of any length; identity for zero.
#[must_use]
pub fn rotation(quaternion: [f32; 4]) -> DMat3 {
    let [w, x, y, z] = quaternion.map(f64::from);
    let length = (w * w + x * x + y * y + z * z).sqrt();
    if length == 0.0 {
        return DMat3::IDENTITY;
    }
    DMat3::from_quat(DQuat::from_xyzw(
        x / length,
        y / length,
        z / length,
        w / length,
    ))
}

/// `1 / (1 + exp(-x))`, exact at both infinities.
#[must_use]
pub fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quaternions_of_any_length_and_zero() {
        let unit = rotation([0.5, 0.5, -0.5, 0.5]);
        // In f32 the squared length of these is infinite, or zero.
        for s in [1e30f32, 1e-30] {
            assert!(
                (rotation([s, s, -s, s]) - unit)
                    .to_cols_array()
                    .iter()
                    .all(|v| v.abs() < 1e-12)
            );
            assert!((s * s).is_infinite() || s * s == 0.0);
        }
        assert_eq!(rotation([0.0; 4]), DMat3::IDENTITY);
    }

    #[test]
    fn sigmoid_reaches_its_limits() {
        assert_eq!(sigmoid(f64::INFINITY), 1.0);
        assert_eq!(sigmoid(f64::NEG_INFINITY), 0.0);
        assert_eq!(sigmoid(0.0), 0.5);
        assert!(sigmoid(-800.0) == 0.0 && sigmoid(-40.0) > 0.0);
    }
}
