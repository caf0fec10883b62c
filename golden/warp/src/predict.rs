//! Camera prediction: rotation by Bayesian ridge regression over the last poses, position by the
//! last velocity (paper, "Proactive Rendering Runtime").

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::ridge::BayesianRidge;
use potamoi_base::camera::Camera;

/// Number of poses in the regression of the rotation.
pub(super) const HISTORY: usize = 5;

/// Predicts the camera `ahead` frames after the last of `history`, whose poses are one frame
/// apart, oldest first. Size and lens are those of the last pose. `None` without a history. At
/// most the last five poses are used; a single pose is predicted to stand still.
///
/// Rotations are regressed in the tangent space of the last one: for each pose the rotation vector
/// from the last, axis times angle, each component over time. If a regression is not possible
/// (poses that are not finite), the last pose is kept.
#[must_use]
pub fn predict(history: &[Camera], ahead: f64) -> Option<Camera> {
    let last = *history.last()?;
    let recent = &history[history.len().saturating_sub(HISTORY)..];
    if recent.iter().all(|camera| *camera == last) {
        // To the last bit, so that nothing has to be warped.
        return Some(last);
    }
    let base = rotation(&last);
    let vectors: Vec<DVec3> = recent
        .iter()
        .map(|camera| rotation_vector(rotation(camera) * base.inverse()))
        .collect();
    let times: Vec<Vec<f64>> = (0..recent.len())
        .map(|k| vec![k as f64 - (recent.len() - 1) as f64])
        .collect();
    let component = |axis: usize| {
        let values: Vec<f64> = vectors.iter().map(|v| v[axis]).collect();
        let fit = BayesianRidge::default().fit(&times, &values);
        fit.map(|fit| fit.at(&[ahead]))
    };
    let turn = match [component(0), component(1), component(2)] {
        [Some(x), Some(y), Some(z)] => DQuat::from_scaled_axis(DVec3::new(x, y, z)),
        _ => DQuat::IDENTITY,
    };
    let velocity = match recent {
        [.., before, _] => last.position() - before.position(),
        _ => DVec3::ZERO,
    };
    let position = last.position() + velocity * ahead;
    let matrix = DMat3::from_quat((turn * base).normalize());
    let pose = DAffine3::from_mat3_translation(matrix, matrix * -position);
    Some(Camera {
        world_to_camera: if pose.is_finite() {
            pose
        } else {
            last.world_to_camera
        },
        ..last
    })
}

/// Axis times angle of the shorter rotation, at most half a turn: a quaternion and its negative
/// are the same rotation, but the angle of the other is up to a whole turn. Small angles are kept,
/// whereas the library's own function treats those below 2e-8 as none.
pub fn rotation_vector(rotation: DQuat) -> DVec3 {
    let short = if rotation.w < 0.0 {
        -rotation
    } else {
        rotation
    };
    let part = DVec3::new(short.x, short.y, short.z);
    let length = part.length();
    if length == 0.0 {
        return part * 2.0;
    }
    part * (2.0 * length.atan2(short.w) / length)
}

fn rotation(camera: &Camera) -> DQuat {
    DQuat::from_mat3(&camera.world_to_camera.matrix3).normalize()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn camera(pose: DAffine3) -> Camera {
        let eye = DVec3::new(0.0, 0.0, -3.0);
        let mut camera = Camera::look_at(eye, DVec3::ZERO, DVec3::NEG_Y, 0.9, 40, 30);
        camera.world_to_camera = pose;
        camera
    }

    /// Around the origin at a steady pace, in radians a frame.
    fn orbit(pace: f64, frame: f64) -> Camera {
        let angle = pace * frame;
        let eye = 4.0 * DVec3::new(angle.sin(), 0.25, angle.cos());
        Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.9, 40, 30)
    }

    fn apart(a: &Camera, b: &Camera) -> f64 {
        rotation(a).angle_between(rotation(b))
    }

    #[test]
    fn a_steady_orbit_is_predicted() {
        for pace in [0.002, 0.01, 0.02] {
            let history: Vec<Camera> = (0..9).map(|k| orbit(pace, f64::from(k))).collect();
            for ahead in [1.0, 8.0, 24.0] {
                let found = predict(&history, ahead).unwrap();
                let truth = orbit(pace, 8.0 + ahead);
                // Shrinkage takes up to a few hundredths of the turn.
                assert!(apart(&found, &truth) < 0.05 * pace * ahead + 1e-6);
                // A tangent leaves its circle by half the angle's square.
                let off = (found.position() - truth.position()).length();
                let arc = pace * (ahead + 1.0);
                assert!(off < 4.0 * arc * arc, "{pace} {ahead}: {off}");
            }
        }
    }

    #[test]
    fn short_and_still_histories_stand_or_go_straight() {
        assert!(predict(&[], 3.0).is_none());
        let one = orbit(0.1, 2.0);
        for history in [vec![one], vec![one; 2], vec![one; 7]] {
            let found = predict(&history, 24.0).unwrap();
            assert!(apart(&found, &one) < 1e-7);
            assert!((found.position() - one.position()).length() < 1e-12);
        }
        // Along a line: five places, one direction.
        let line: Vec<Camera> = (0..5)
            .map(|k| camera(DAffine3::from_translation(DVec3::X * -f64::from(k))))
            .collect();
        let found = predict(&line, 2.5).unwrap();
        assert!((found.position() - DVec3::X * 6.5).length() < 1e-12);
        let two = &line[..2];
        assert!((predict(two, 1.0).unwrap().position() - DVec3::X * 2.0).length() < 1e-12);
    }

    #[test]
    fn half_turns_jumps_and_broken_poses_give_a_pose() {
        let turned = |angle: f64| camera(DAffine3::from_rotation_y(angle));
        let pi = std::f64::consts::PI;
        let jumps = [
            turned(0.0),
            turned(pi),
            turned(0.0),
            turned(pi),
            turned(-pi),
        ];
        let far = camera(DAffine3::from_translation(DVec3::splat(1e9)));
        let broken = camera(DAffine3::from_translation(DVec3::NAN));
        for history in [
            &jumps[..],
            &[turned(0.0), far],
            &[far, turned(0.0), far, turned(1.0), far],
            &[broken, turned(0.0)],
        ] {
            let found = predict(history, 12.0).unwrap().world_to_camera;
            assert!(found.is_finite(), "{history:?}");
            let product = found.matrix3 * found.matrix3.transpose();
            assert!(product.abs_diff_eq(DMat3::IDENTITY, 1e-9));
        }
    }

    /// All around, at several tilts: wherever a quaternion changes its sign.
    #[test]
    fn a_whole_turn_is_predicted_as_well_as_its_beginning() {
        for lift in [-1.2f64, -0.4, 0.0, 0.3, 1.1] {
            let at = |frame: f64| {
                let (sin, cos) = (0.02 * frame).sin_cos();
                let eye = DVec3::new(sin * lift.cos(), lift.sin(), cos * lift.cos()) * 3.0;
                Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.9, 40, 30)
            };
            for k in 0..330 {
                let history: Vec<Camera> = (0..5).map(|j| at(f64::from(k + j))).collect();
                let found = predict(&history, 9.0).unwrap();
                let truth = at(f64::from(k) + 13.0);
                let off = apart(&found, &truth);
                assert!(off < 0.05 * 0.02 * 9.0, "{lift}, {k}: {off} rad");
            }
        }
    }

    proptest! {
        #[test]
        fn every_prediction_is_a_rigid_pose(
            angles in prop::collection::vec(prop::array::uniform3(-4.0f64..4.0), 1..8),
            places in prop::collection::vec(prop::array::uniform3(-50.0f64..50.0), 8),
            ahead in 0.0f64..50.0,
        ) {
            let history: Vec<Camera> = angles.iter().zip(&places).map(|(angle, place)| {
                let turn = DQuat::from_scaled_axis(DVec3::from(*angle));
                camera(DAffine3::from_rotation_translation(turn, DVec3::from(*place)))
            }).collect();
            let pose = predict(&history, ahead).unwrap().world_to_camera;
            prop_assert!(pose.is_finite());
            let product = pose.matrix3 * pose.matrix3.transpose();
            prop_assert!(product.abs_diff_eq(DMat3::IDENTITY, 1e-9));
            prop_assert!((pose.matrix3.determinant() - 1.0).abs() < 1e-9);
        }
    }
}
