//! When references and targets are rendered (paper, "Proactive Rendering
//! Runtime").
//!
//! A [`Plan`](potamoi_warp::Plan) says what is rendered, and which pose
//! each reference is known by. One dispatcher decides what begins: it is a
//! state machine without a clock of its own, and keeps the paper's two
//! properties, that no target begins before its reference is there, and that a
//! target seen from too different an angle is rendered in full. [`schedule`]
//! drives it by events, each with a time that a [`Clock`] gives; [`live`] by two
//! threads that really render. Both give a [`Schedule`], which
//! [`chrome_trace`] writes for Perfetto.
//!
//! What is dispatched, and in what order:
//!
//! - References are begun in order, each once its pose is known and the buffer
//!   has a slot for it. It holds the slot until its last target is rendered;
//!   with two slots, one is written while the other is read.
//! - Of what is ready for a resource, that begins which a frame needs soonest.
//!   Nothing that has begun is interrupted.
//! - A remote reference is asked for over the link, rendered by the server, and
//!   sent back over the same link. One that is not there when its time is over
//!   is given up, and its targets are rendered in full, as soon as they come.
//! - Frames are shown in order.
//!
//! Times are whole nanoseconds since the start, not cycles: accelerator, GPU,
//! link and camera run on clocks of their own, and at 1 GHz a nanosecond is a
//! cycle.

mod clock;
mod dispatch;
mod error;
mod finish;
mod live;
mod options;
mod record;
mod simulate;
mod trace;
mod waits;
mod windows;

#[cfg(test)]
mod tests;

pub use crate::frame_scheduler::{Job, Made};
pub use clock::{Clock, FixedClock, Nanos, PixelClock};
pub use error::RuntimeError;
pub use live::{References, live};
pub use options::{Link, Options, Poses, Remote};
pub use record::{FrameTime, Held, LinkUse, Resource, ResourceUse, Schedule, Task, Totals, Waits};
pub use simulate::schedule;
pub use trace::chrome_trace;
