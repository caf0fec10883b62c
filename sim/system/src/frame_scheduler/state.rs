//! State of each reference and of each frame.

use super::FrameOrigin;

/// State of a reference. An event that has not happened has no moment.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ReferenceState<M> {
    /// The slot it was given, and since when that was free.
    pub(super) slot: Option<(M, usize)>,
    /// Request at the server.
    pub(super) asked: Option<M>,
    /// Rendering done.
    pub(super) rendered: Option<M>,
    /// Arrival in its slot.
    pub(super) ready: Option<M>,
    /// Given up.
    pub(super) lost: Option<M>,
    /// Targets that have still to read it.
    pub(super) readers: usize,
}

/// State of a frame. An event that has not happened has no moment.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FrameState<M> {
    /// Arrival of its pose.
    pub(crate) pose: Option<M>,
    /// Its angles were found to be too large.
    pub(crate) refused: Option<M>,
    /// Finished, and how it was produced.
    pub(crate) finished: Option<(M, FrameOrigin)>,
    /// Shown.
    pub(crate) shown: Option<M>,
}

/// Cause of a wait.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cause {
    Pose,
    /// Rendering of the reference.
    Reference,
    /// A slot of the reference buffer.
    Buffer,
    /// The link, busy or transferring.
    Link,
    /// A reference that was lost.
    Loss,
    /// Warping that found the angle too large.
    Angle,
    /// A busy renderer.
    Renderer,
}
