//! What a frame asks of the hardware, counted on frames that are really rendered: nothing here
//! is a ratio that somebody assumed.

mod cache;
mod frame;
mod meter;
mod path;
mod replay;
#[cfg(test)]
mod tests;

pub use cache::{WorkCache, WorkCacheError};
pub use frame::{Counted, FrameWork, Reads};
pub use meter::{Batch, Meter, Sums};
pub use path::{Classes, PathError, PathOptions, PathWork, Quality, TargetWork};
pub use replay::{PathReplay, Replay, Replayed};

/// Of a value that is only written down where it is not the usual one.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
