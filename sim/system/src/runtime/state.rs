//! What the dispatcher knows of each reference and of each frame.

use super::{Made, Nanos, Waits};

/// A reference; what has not happened has no time.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ReferenceState {
    /// The slot that it was given, and since when that was free.
    pub(super) slot: Option<(Nanos, usize)>,
    /// When the server was asked.
    pub(super) asked: Option<Nanos>,
    /// When it was rendered.
    pub(super) rendered: Option<Nanos>,
    /// When it was in its slot.
    pub(super) ready: Option<Nanos>,
    /// When it was given up.
    pub(super) lost: Option<Nanos>,
    /// Targets that have still to read it.
    pub(super) readers: usize,
}

/// A frame; what has not happened has no time.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FrameState {
    /// When its pose arrived.
    pub(super) pose: Option<Nanos>,
    /// When its angles were found to be too large.
    pub(super) refused: Option<Nanos>,
    /// What it waited for.
    pub(super) waits: Waits,
    /// When it was finished, and how.
    pub(super) finished: Option<(Nanos, Made)>,
    /// When it was shown.
    pub(super) shown: Option<Nanos>,
}

/// What has to be awaited, in this order, and when it came.
pub(super) type Gates = Vec<(Cause, Nanos)>;

/// What is waited for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Cause {
    Pose,
    Reference,
    Buffer,
    Link,
    Loss,
    Angle,
    Renderer,
}

/// Splits the time between two moments by what was awaited; what no gate
/// explains was spent on `rest`.
pub(super) fn split(from: Nanos, gates: &Gates, to: Nanos, rest: Cause) -> Waits {
    let mut waits = Waits::default();
    let mut at = from;
    for (cause, time) in gates.iter().copied().chain([(rest, to)]) {
        let until = time.clamp(at, to.max(at));
        *match cause {
            Cause::Pose => &mut waits.pose,
            Cause::Reference => &mut waits.reference,
            Cause::Buffer => &mut waits.buffer,
            Cause::Link => &mut waits.link,
            Cause::Loss => &mut waits.loss,
            Cause::Angle => &mut waits.angle,
            Cause::Renderer => &mut waits.renderer,
        } += until - at;
        at = until;
    }
    waits
}
