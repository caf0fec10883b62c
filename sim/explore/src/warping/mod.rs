//! Sparse radiance warping (SpaRW) along a path: quality of frames, share of rendered pixels, and
//! schedules.

mod method;
mod quality;
mod rates;
mod source;
mod study;
mod timetable;
mod variant;

pub use method::{Method, MethodSettings};
pub use quality::{Footage, FrameQuality, ImageQuality, Measured, Part, Truth};
pub use rates::{Pace, PredictionError, RateRow, Rates};
pub use source::{Depth, Source};
pub use study::{PlannedMethod, Study};
pub use timetable::{GivenTimes, Times, Timetable, Timing};
pub use variant::{Prediction, Variant, Warping};
