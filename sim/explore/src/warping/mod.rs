//! Sparse radiance warping (SpaRW) along a path: quality of frames, share of rendered pixels, and
//! schedules.

mod quality;
mod source;
mod study;
mod timetable;
mod variant;
mod way;

pub use quality::{Footage, FrameQuality, Likeness, Measured, Part, Truth};
pub use source::{Depth, Source};
pub use study::{PlannedWay, Study};
pub use timetable::{GivenTimes, Times, Timetable, Timing};
pub use variant::{Prediction, Variant, Warping};
pub use way::{Method, Way};
