//! The content of a splat file.

use glam::DVec3;

use super::axes::Axes;
use super::cloud::Cloud;
use potamoi_base::file_keys::Notes;

/// Gaussians of a file, with further information from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// The Gaussians in cloud axes: right, down, front.
    pub cloud: Cloud,
    /// Unused parts of the file, and assumptions.
    pub notes: Notes,
    /// Position of the cloud's origin in the file's world. It differs from zero if the centres are
    /// too far off for 32-bit floats.
    pub origin: DVec3,
    /// The vertical axis, if the file names one.
    pub up: Option<DVec3>,
}

/// The content of a file in its own axes.
#[derive(Debug)]
pub struct Raw {
    pub(super) cloud: Cloud,
    pub(super) notes: Notes,
    pub(super) origin: DVec3,
    pub(super) up: Option<DVec3>,
    /// The axes that the file names.
    pub(super) axes: Option<Axes>,
    /// The default axes of the format.
    pub usual: Axes,
}

impl Raw {
    /// For a format whose axes are those of a cloud.
    pub fn new(cloud: Cloud, notes: Notes) -> Self {
        Self {
            cloud,
            notes,
            origin: DVec3::ZERO,
            up: None,
            axes: None,
            usual: Axes::RIGHT_DOWN_FRONT,
        }
    }

    /// Converts to cloud axes from the `asked` ones, or else from those that the file names, or
    /// else from the format's default.
    pub fn turned(mut self, asked: Option<Axes>) -> Loaded {
        let axes = match (asked, self.axes) {
            (Some(asked), said) => {
                if said.is_some_and(|said| said != asked) {
                    self.notes
                        .list("its axes, in place of which others are given");
                }
                asked
            }
            (None, Some(said)) => said,
            (None, None) => {
                self.notes.assume(format!("axes {}", self.usual));
                self.usual
            }
        };
        let zero = |q: &&[f32; 4]| q.iter().all(|v| *v == 0.0);
        let turnless = self.cloud.rotations().iter().filter(zero).count();
        if turnless > 0 {
            self.notes.assume(format!(
                "no rotation where a quaternion is 0 ({turnless} of {} Gaussians)",
                self.cloud.len()
            ));
        }
        let vector = |v: DVec3| DVec3::from(axes.point(v.to_array()));
        Loaded {
            cloud: self.cloud.turned(axes),
            notes: self.notes,
            origin: vector(self.origin),
            up: self.up.map(vector),
        }
    }
}
