//! The motion of a trajectory, placed in a scene.

use glam::DAffine3;
use potamoi_base::camera::Camera;
use serde::Serialize;

use super::pose::Pose;
use super::table::Trajectory;

/// The last frame may be this share of a step after the last pose, for rounding.
const ROUNDING: f64 = 1e-6;

/// Where and how large a motion is placed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Placement {
    /// World-to-camera transform at the begin of the motion, rigid.
    pub anchor: DAffine3,
    /// Scene units a unit of the file, above 0.
    pub scale: f64,
}

/// The part of a trajectory that is used, in seconds since its first sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Span {
    /// Time of the first frame.
    pub(crate) from: f64,
    /// No frame is after it.
    pub(crate) to: f64,
    /// Whether a frame may be at its end, which is where the trajectory ends.
    pub(crate) closed: bool,
}

/// The motion of a trajectory in a scene: its poses relative to the first, which is the anchor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Motion {
    trajectory: Trajectory,
    span: Span,
    placement: Placement,
    rate_hz: Option<f64>,
    first: Pose,
}

impl Motion {
    /// `None` if the span begins outside the trajectory.
    pub(crate) fn new(
        trajectory: Trajectory,
        span: Span,
        placement: Placement,
        rate_hz: Option<f64>,
    ) -> Option<Self> {
        Some(Self {
            first: trajectory.pose(span.from)?,
            trajectory,
            span,
            placement,
            rate_hz,
        })
    }

    /// Frames a second, if they are fixed.
    #[must_use]
    pub const fn rate_hz(&self) -> Option<f64> {
        self.rate_hz
    }

    /// Number of frames at a rate in frames a second, at least 1.
    #[must_use]
    pub fn frames(&self, hz: f64) -> u32 {
        let steps = (self.span.to - self.span.from) * hz;
        let frames = match self.span.closed {
            true => (steps + ROUNDING).floor() + 1.0,
            false => (steps - ROUNDING).ceil().max(1.0),
        };
        // Beyond the limit of paths all are refused.
        frames.min(f64::from(u32::MAX)) as u32
    }

    /// The camera of a frame at a rate in frames a second, with the size and lens of `lens`. A frame
    /// beyond the last has its camera.
    #[must_use]
    pub fn camera(&self, frame: u32, hz: f64, lens: &Camera) -> Camera {
        let seconds = (self.span.from + f64::from(frame) / hz).min(self.trajectory.seconds());
        let pose = self.trajectory.pose(seconds).unwrap_or(self.first);
        let Placement { anchor, scale } = self.placement;
        let moved = self.first.relative(&pose);
        let back = moved.rotation.conjugate();
        let from_anchor =
            DAffine3::from_rotation_translation(back, back * (moved.position * -scale));
        // Exactly the anchor at the begin.
        let world_to_camera = match pose == self.first {
            true => anchor,
            false => from_anchor * anchor,
        };
        Camera {
            world_to_camera,
            ..*lens
        }
    }
}

#[cfg(test)]
#[allow(clippy::expect_used)]
impl Motion {
    /// A quarter of a circle within a second, from a camera on.
    pub(crate) fn of_a_circle(camera: &Camera) -> Self {
        let trajectory = super::tests::circle(1.0, std::f64::consts::FRAC_PI_2, 11, 0.1);
        let span = Span {
            from: 0.0,
            to: 1.0,
            closed: true,
        };
        let placement = Placement {
            anchor: camera.world_to_camera,
            scale: 1.0,
        };
        Self::new(trajectory, span, placement, None).expect("a span within it")
    }
}
