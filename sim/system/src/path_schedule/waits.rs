//! Splits waiting time by cause.

use super::{Nanos, Waits};
use crate::frame_scheduler::Cause;

/// Splits the time between two moments by cause. `gates` are causes in order with the moment each
/// ended; time that no gate explains counts as `rest`.
pub(super) fn split(from: Nanos, gates: &[(Cause, Nanos)], to: Nanos, rest: Cause) -> Waits {
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
