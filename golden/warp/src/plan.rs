//! Assignment of references to the targets of a path, and cameras of references.

use serde::Serialize;

use super::WarpError;
use super::predict::{HISTORY, predict, rotation_vector};
use potamoi_base::camera::Camera;

/// Maximum number of targets of a reference.
const MAX_WINDOW: u32 = 1 << 16;

/// The camera from which references are rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ReferenceFrom {
    /// The camera predicted for the middle of the window, off the path (the paper's).
    Predicted,
    /// The camera of the window's first frame, on the path.
    First,
    /// The camera of the frame nearest the window's middle, on the path: not known in time in live
    /// use, but available in image sequences.
    Centre,
}

/// Options of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct PlanOptions {
    /// Number of targets of a reference.
    pub window: u32,
    /// The camera of references.
    pub reference: ReferenceFrom,
    /// Number of frames before its window at which a predicted reference is started; by default
    /// the window's length. With 0, the paper's formula, it starts with its first target, which
    /// has to wait for it.
    pub lead: Option<u32>,
}

/// A frame that targets are warped from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceTask {
    /// Its camera.
    pub camera: Camera,
    /// The target with the same camera, if it is on the path.
    pub target: Option<usize>,
    /// The frame at whose time the camera is known and rendering may start.
    pub known: usize,
    /// For a predicted reference, the frame for which it is predicted; it may lie beyond the path.
    pub predicted_for: Option<usize>,
}

/// A frame of the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TargetTask {
    /// The reference from which it is warped, or which it equals.
    pub reference: usize,
}

/// References and targets of a path, in the order of windows.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// References.
    pub references: Vec<ReferenceTask>,
    /// Targets, one for each frame of the path.
    pub targets: Vec<TargetTask>,
}

impl Plan {
    /// Plans a path. The first window has no poses to predict from, so its first frame is its
    /// reference. A later reference is predicted `lead` frames before its window, but not before
    /// five poses are known, unless its window begins earlier.
    ///
    /// # Errors
    /// The window or the lead is out of range.
    pub fn new(path: &[Camera], options: &PlanOptions) -> Result<Self, WarpError> {
        let refuse = |field, value: u32, expected: String| {
            Err(WarpError::Option {
                field,
                value: value.to_string(),
                expected,
            })
        };
        let window = options.window;
        if !(1..=MAX_WINDOW).contains(&window) {
            return refuse("window", window, format!("1 to {MAX_WINDOW} frames"));
        }
        let lead = options.lead.unwrap_or(window);
        if lead > MAX_WINDOW {
            return refuse("lead", lead, format!("0 to {MAX_WINDOW} frames"));
        }
        let (window, lead) = (window as usize, lead as usize);
        let mut plan = Self {
            references: vec![],
            targets: vec![],
        };
        for first in (0..path.len()).step_by(window) {
            let last = (first + window).min(path.len()) - 1;
            let middle = (first + window / 2).min(last);
            let on_path = |target: usize| ReferenceTask {
                camera: path[target],
                target: Some(target),
                known: target,
                predicted_for: None,
            };
            let task = match options.reference {
                ReferenceFrom::First => on_path(first),
                ReferenceFrom::Centre => on_path(middle),
                ReferenceFrom::Predicted if first == 0 => on_path(0),
                ReferenceFrom::Predicted => {
                    let known = first.saturating_sub(lead).max((HISTORY - 1).min(first));
                    let aim = first + window / 2;
                    let ahead = (aim - known) as f64;
                    let camera = predict(&path[..=known], ahead).unwrap_or(path[known]);
                    ReferenceTask {
                        camera,
                        target: None,
                        known,
                        predicted_for: Some(aim),
                    }
                }
            };
            let reference = plan.references.len();
            plan.references.push(task);
            plan.targets
                .extend((first..=last).map(|_| TargetTask { reference }));
        }
        Ok(plan)
    }

    /// Rotation error in radians and distance of each predicted reference from the true camera at
    /// that frame, for frames within the path.
    #[must_use]
    pub fn prediction_errors(&self, path: &[Camera]) -> Vec<(f64, f64)> {
        let errors = self.references.iter().filter_map(|task| {
            let truth = path.get(task.predicted_for?)?;
            let between =
                task.camera.world_to_camera.matrix3 * truth.world_to_camera.matrix3.transpose();
            let turn = rotation_vector(glam::DQuat::from_mat3(&between));
            let away = task.camera.position() - truth.position();
            Some((turn.length(), away.length()))
        });
        errors.collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use glam::DVec3;

    fn path(frames: u32) -> Vec<Camera> {
        (0..frames)
            .map(|k| {
                let eye = DVec3::new(f64::from(k), 0.0, -50.0);
                Camera::look_at(eye, eye + DVec3::Z, DVec3::NEG_Y, 0.9, 8, 6)
            })
            .collect()
    }

    fn plan(frames: u32, window: u32, reference: ReferenceFrom, lead: Option<u32>) -> Plan {
        let options = PlanOptions {
            window,
            reference,
            lead,
        };
        Plan::new(&path(frames), &options).unwrap()
    }

    #[test]
    fn predicted_references_lie_in_the_middle_and_are_known_a_lead_before() {
        let plan = plan(20, 6, ReferenceFrom::Predicted, None);
        let known: Vec<usize> = plan.references.iter().map(|r| r.known).collect();
        // The second waits for five poses.
        assert_eq!(known, [0, 4, 6, 12]);
        let aims: Vec<Option<usize>> = plan.references.iter().map(|r| r.predicted_for).collect();
        assert_eq!(aims, [None, Some(9), Some(15), Some(21)]);
        for (reference, aim) in plan.references.iter().zip(aims).skip(1) {
            let expected = aim.unwrap() as f64;
            assert!((reference.camera.position().x - expected).abs() < 1e-9);
        }
        let served: Vec<usize> = plan.targets.iter().map(|t| t.reference).collect();
        let expected: Vec<usize> = (0..20).map(|k| k / 6).collect();
        assert_eq!(served, expected);
        // Of the last, whose frame is beyond the path, nothing is known.
        let errors = plan.prediction_errors(&path(20));
        assert_eq!(errors.len(), 2);
        assert!(
            errors
                .iter()
                .all(|(angle, away)| *angle < 1e-9 && *away < 1e-9)
        );
    }

    #[test]
    fn without_a_lead_a_reference_is_known_with_its_first_target() {
        let plan = plan(20, 4, ReferenceFrom::Predicted, Some(0));
        for (number, reference) in plan.references.iter().enumerate() {
            assert_eq!(reference.known, 4 * number);
        }
        // The paper's example: of T2 to T5, T4.
        assert_eq!(plan.references[1].predicted_for, Some(6));
    }

    #[test]
    fn on_the_path_a_reference_is_one_of_its_targets() {
        for (reference, expected) in [
            (ReferenceFrom::First, [0, 6, 12]),
            (ReferenceFrom::Centre, [3, 9, 13]),
        ] {
            let plan = plan(14, 6, reference, None);
            let shown: Vec<usize> = plan.references.iter().filter_map(|r| r.target).collect();
            assert_eq!(shown, expected);
        }
    }

    #[test]
    fn a_path_shorter_than_a_window_and_windows_of_one_are_plans() {
        let short = plan(3, 16, ReferenceFrom::Predicted, None);
        assert_eq!((short.references.len(), short.targets.len()), (1, 3));
        assert!(
            plan(0, 16, ReferenceFrom::Predicted, None)
                .targets
                .is_empty()
        );
        let each = plan(9, 1, ReferenceFrom::Predicted, None);
        assert_eq!(each.references.len(), 9);
        for (number, reference) in each.references.iter().enumerate().skip(1) {
            assert!(reference.known <= number && reference.predicted_for == Some(number));
        }
        let none = PlanOptions {
            window: 0,
            reference: ReferenceFrom::First,
            lead: None,
        };
        assert!(
            Plan::new(&path(2), &none)
                .unwrap_err()
                .to_string()
                .contains("window")
        );
    }
}
