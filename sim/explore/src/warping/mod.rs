//! Sparse radiance warping along a path: how good frames are, how many pixels are rendered, and
//! when.

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
