//! Work of frames, counted while they are rendered. No ratio is assumed.

mod cache;
mod frame;
mod path;
mod path_cameras;
mod path_events;
mod path_pictures;
mod path_reads;
mod pixel_runs;
mod replay;
#[cfg(test)]
mod tests;

pub use cache::{WorkCache, WorkCacheError};
pub use frame::{Counted, FrameWork, PixelPairs, Reads, UnitCycles};
pub use path::{Classes, PathError, PathOptions, PathParts, PathWork, Quality, TargetWork};
pub use replay::{PathReplay, Replay, Replayed};

/// Whether a value is its default, which is then not serialised.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
