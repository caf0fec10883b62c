//! What a splat file holds.

use glam::DVec3;

use super::axes::Axes;
use super::cloud::Cloud;
use potamoi_base::record::Notes;

/// Gaussians of a file, and what else the file says of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// In the axes of a cloud: right, down, front.
    pub cloud: Cloud,
    /// What of the file is not used, and what had to be assumed.
    pub notes: Notes,
    /// Where in the file's world the cloud's origin lies: not in its own origin where centres are
    /// so far off that floats of 32 bits do not hold them.
    pub origin: DVec3,
    /// The vertical axis, where the file says which it is.
    pub up: Option<DVec3>,
}

/// The same in the axes of the file.
#[derive(Debug)]
pub struct Raw {
    pub(super) cloud: Cloud,
    pub(super) notes: Notes,
    pub(super) origin: DVec3,
    pub(super) up: Option<DVec3>,
    /// What the file says of its axes.
    pub(super) axes: Option<Axes>,
    /// What they are in files of its format that say nothing.
    pub usual: Axes,
}

impl Raw {
    /// Of a format whose files lie as a cloud does.
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

    /// Turns it into a cloud's axes from those `asked` for, or else from those that the file says.
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
