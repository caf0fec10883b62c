//! What is known of each reference and of each frame.

use super::Made;

/// A reference; what has not happened has no moment.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ReferenceState<M> {
    /// The slot that it was given, and since when that was free.
    pub(super) slot: Option<(M, usize)>,
    /// When the server was asked.
    pub(super) asked: Option<M>,
    /// When it was rendered.
    pub(super) rendered: Option<M>,
    /// When it was in its slot.
    pub(super) ready: Option<M>,
    /// When it was given up.
    pub(super) lost: Option<M>,
    /// Targets that have still to read it.
    pub(super) readers: usize,
}

/// A frame; what has not happened has no moment.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FrameState<M> {
    /// When its pose arrived.
    pub(crate) pose: Option<M>,
    /// When its angles were found to be too large.
    pub(crate) refused: Option<M>,
    /// When it was finished, and how.
    pub(crate) finished: Option<(M, Made)>,
    /// When it was shown.
    pub(crate) shown: Option<M>,
}

/// What is waited for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cause {
    /// A pose.
    Pose,
    /// A reference, until it is rendered.
    Reference,
    /// A slot of the reference buffer.
    Buffer,
    /// Bytes on the link, or the link.
    Link,
    /// A reference that never came.
    Loss,
    /// Warping that found the angle too large.
    Angle,
    /// A renderer that was busy.
    Renderer,
}
