//! Poses from quaternions and matrices.

use std::path::Path;

use glam::{DMat3, DQuat, DVec3};
use serde::Serialize;

use super::error::{TrajectoryError, Wrong};

/// Largest coordinate. Beyond it, poses lose their rotation to rounding.
pub(super) const FAR: f64 = 1e9;
/// Maximum deviation of a quaternion's length from 1: files hold few digits.
const UNIT_TOLERANCE: f64 = 1e-2;
/// Maximum deviation of a matrix from a rotation.
const ROUNDING: f64 = 1e-3;

/// A rigid transform from a camera to its world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pose {
    /// Rotation, a unit quaternion.
    pub rotation: DQuat,
    /// Position in the world.
    pub position: DVec3,
}

impl Pose {
    /// From `x y z w`, of a length near 1.
    pub(super) fn of_quaternion(position: DVec3, parts: [f64; 4]) -> Result<Self, Wrong> {
        let [x, y, z, w] = parts;
        let rotation = DQuat::from_xyzw(x, y, z, w);
        let length = rotation.length();
        // Not a number is in no range.
        let is_unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
        if !is_unit {
            let expected = format!("of length 1, to {UNIT_TOLERANCE}");
            let value = format!("x {x}, y {y}, z {z}, w {w}, of length {length:.4}");
            return Err(("the quaternion", value, expected));
        }
        Ok(Self {
            rotation: rotation.normalize(),
            position,
        })
    }

    /// From 12 or 16 numbers by rows.
    pub(super) fn of_matrix(rows: &[f64]) -> Result<Self, Wrong> {
        let column = |c: usize| DVec3::new(rows[c], rows[4 + c], rows[8 + c]);
        let last = rows.get(12..16).unwrap_or(&[0.0, 0.0, 0.0, 1.0]);
        let off = |(value, unit): (&f64, f64)| (value - unit).abs() > ROUNDING;
        if last.iter().zip([0.0, 0.0, 0.0, 1.0]).any(off) {
            let expected = "0 0 0 1".to_owned();
            return Err(("the last row", format!("{last:?}"), expected));
        }
        let matrix = DMat3::from_cols(column(0), column(1), column(2));
        let off = matrix * matrix.transpose() - DMat3::IDENTITY;
        let rigid = off.to_cols_array().iter().all(|v| v.abs() < ROUNDING);
        if !(rigid && matrix.determinant() > 0.0) {
            let shown = [0, 1, 2].map(|r| format!("{:?}", matrix.row(r).to_array()));
            let expected = "rows of length 1 at right angles, right-handed".to_owned();
            return Err(("the rotation", shown.join(" "), expected));
        }
        Ok(Self {
            // Rounding of the file is taken out.
            rotation: DQuat::from_mat3(&matrix).normalize(),
            position: column(3),
        })
    }

    /// This pose after `other`, which is in this one's frame.
    #[must_use]
    pub fn then(&self, other: &Self) -> Self {
        Self {
            rotation: (self.rotation * other.rotation).normalize(),
            position: self.position + self.rotation * other.position,
        }
    }

    /// `other` in the frame of this pose.
    #[must_use]
    pub fn relative(&self, other: &Self) -> Self {
        let back = self.rotation.conjugate();
        Self {
            rotation: (back * other.rotation).normalize(),
            position: back * (other.position - self.position),
        }
    }

    /// The pose at a share of the way to another: position along the line, rotation along the
    /// shortest arc at a constant rate.
    #[must_use]
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        Self {
            rotation: self.rotation.slerp(other.rotation, share).normalize(),
            position: self.position.lerp(other.position, share),
        }
    }
}

/// The camera in the frame of the file's poses.
pub(super) fn extrinsics(path: &Path, numbers: &[f64; 16]) -> Result<Pose, TrajectoryError> {
    let fits = numbers.iter().all(|v| v.abs() <= FAR);
    let pose = match fits {
        true => Pose::of_matrix(numbers),
        false => Err(("a number", format!("{numbers:?}"), "-1e9 to 1e9".to_owned())),
    };
    pose.map_err(|(field, value, expected)| {
        let found = format!("camera.t_bs: {field} is {value}");
        TrajectoryError::file(path, &found, &expected)
    })
}
