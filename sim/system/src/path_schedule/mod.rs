//! The schedule of a warped path: when references and targets are rendered (paper, "Proactive
//! Rendering Runtime").
//!
//! A [`Plan`](potamoi_warp::Plan) lists the frames to render, and the pose that each reference
//! depends on. One dispatcher decides which job begins. It is a state machine without a clock, and
//! keeps the paper's two properties: no target begins before its reference is rendered, and a
//! target seen from too different an angle is rendered in full. [`schedule`] drives it by events
//! with times from a [`Clock`]; [`live`] drives it by two threads that render. Both return a
//! [`Schedule`], which [`chrome_trace`] writes for Perfetto.
//!
//! Order of dispatch:
//!
//! - References begin in order, each once its pose is known and the buffer has a free slot. A
//!   reference holds its slot until its last target is rendered. With two slots, one is written
//!   while the other is read.
//! - Of the jobs ready for a resource, the one needed by the earliest frame begins. Nothing that
//!   has begun is interrupted.
//! - A remote reference is requested over the link, rendered by the server, and sent back over the
//!   same link. One that has not arrived at its timeout is given up, and its targets are rendered
//!   in full as they come.
//! - Frames are shown in order.
//!
//! Times are whole nanoseconds since the start, not cycles: accelerator, GPU, link and camera have
//! clocks of their own. At 1 GHz a nanosecond is a cycle.

mod chrome_trace;
mod clock;
mod dispatch;
mod error;
mod finish;
mod live;
mod options;
mod schedule;
mod simulate;
mod waits;
mod windows;

#[cfg(test)]
mod tests;

pub use crate::frame_scheduler::{FrameOrigin, Job};
pub use chrome_trace::chrome_trace;
pub use clock::{Clock, FixedClock, Nanos, PixelClock};
pub use error::ScheduleError;
pub use live::{References, live};
pub use options::{Link, Options, Poses, Remote};
pub use schedule::{
    FrameTime, LinkUse, Resource, ResourceUse, Schedule, SlotHold, Task, Totals, Waits,
};
pub use simulate::schedule;
