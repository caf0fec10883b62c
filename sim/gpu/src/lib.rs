//! Frame times on GPUs.

mod device;
mod frame;
mod kernel;
mod operations;
pub mod programs;
pub mod rows;

pub use device::{Better, Device, DeviceError, FIELDS, Field, Origin};
pub use frame::{Bounds, Frame, Launch, Overlap, Time};
pub use kernel::{Kernel, Term};
