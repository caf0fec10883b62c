//! Frame times of published rendering programs on GPUs, kernel by kernel.
//!
//! A frame is the sum of the operations that a program launches. What an operation asks for follows
//! from counts of the frame and from the program's source; what a device delivers follows from
//! data sheets and microbenchmarks. No share is calibrated, and no constant belongs to a program or
//! to a class of programs.
//!
//! # Example
//!
//! ```
//! use potamoi_gpu::{Device, Term};
//! use potamoi_gpu::programs::{Host, Program, Splatting};
//!
//! # fn main() -> Result<(), potamoi_gpu::DeviceError> {
//! // A scene of 2.5 million Gaussians, as the 3DGS paper's viewer renders it.
//! let splats = Splatting {
//!     gaussians: 2.5e6,
//!     visible: 1.1e6,
//!     pairs: 5.0e6,
//!     width: 979.0,
//!     height: 546.0,
//!     walked: 0.6,
//!     blending: 0.2,
//!     longest: 6.7,
//!     ..Splatting::blank(Host::Viewer)
//! };
//! let device = Device::builtin("agx-orin")?;
//! let bounds = splats.frame(&device).bounds(&device);
//!
//! // 22 to 39 ms: 26 to 46 frames a second, likely 35.
//! let frames_s = [bounds.max.seconds, bounds.mid(), bounds.sum.seconds].map(|s| 1.0 / s);
//! assert_eq!(frames_s.map(f64::round), [46.0, 35.0, 26.0]);
//! // Instructions bound it, at either end.
//! assert_eq!(bounds.max.largest()[0].0, Term::Issue);
//! assert_eq!(bounds.sum.largest()[0].0, Term::Issue);
//! # Ok(())
//! # }
//! ```
//!
//! `cargo run -p potamoi-gpu --example rows` prints predictions beside measured frame rates.
//!
//! # Method
//!
//! - **Kernel.** Seven demands: instructions on the busiest pipe, lines of L1, bytes of L2, bytes
//!   of the memory with intermediate tensors, operations of tensor cores, chains of requests that
//!   wait for each other, copies to the host ([`Kernel`]). Each divided by the device's rate is a
//!   time.
//! - **Bounds.** A kernel takes its largest demand if all overlap ("max"), and their sum if none
//!   does ("sum"). The prediction ("mid") is the geometric mean of the frame's two bounds. It is a
//!   convention, not a finding; **a speed-up over a GPU is to be given at both bounds, and a
//!   conclusion that differs between them is none.**
//! - **Frame.** Each operation adds its start and end on the device, and the host's time to launch
//!   it. Host and device overlap between waits; a wait adds its own time ([`Frame`]).
//! - **Programs.** [`programs`] has a file a program. Each takes a structure of documented counts
//!   and gives the list of operations, with the function of the public code that each stands for.
//! - **Devices.** [`Device`] is a file of `sim/gpu/devices/`, one a power mode: every figure has a
//!   source, or says why it is assumed. [`Device::from_file`] takes one's own.
//!
//! Constants for all devices stand in `kernel.rs`: four schedulers an SM, one line of L1 a clock,
//! 80 % of a pipe, half of the tensor peak for layers of 64 outputs.
//!
//! # How far to trust it
//!
//! Counts of 16 judged rows were written down before frame rates were compared. Most of the rates
//! had been known before; those of the five scenes on the A100 had not, but for their geometric
//! mean. The likely prediction is within twice on 15 of 16, the measurement within the full range
//! (both bounds, all counts) on 15. The geometric mean error is 1.37. Predictions are 1.32 times
//! too fast; about that bias, 1.23 remain.
//!
//! - **Too fast is expected.** Imbalance among SMs, bank conflicts, partial waves and clocks below
//!   boost are left out.
//! - **Counts decide.** Twice the pairs of a splat scene take 1.6 to 1.9 times as long; ranges of
//!   counts are wider than the bounds. A count that is measured is worth more than a term.
//! - **Not reached:** 3DGS on NeRF Synthetic, 3.3 times too fast. In frames of 1.3 ms the viewer's
//!   own time may show, which no term has; four times the pairs would do as well.
//! - **Terms that decide** (error without them): instructions 1.99, memory 1.89, L1 1.47, L2 1.44.
//!   Host and waits decide little on judged rows, and a quarter of DirectVoxGO on a Xavier.
//! - **Not tested:** Jetson devices and DirectVoxGO, TensoRF and eager hash grids have no row with
//!   a documented version, timed region, power mode and counts. Those that were found stand beside.

mod device;
mod frame;
mod kernel;
mod operations;
pub mod programs;
pub mod rows;
pub mod validate;

pub use device::{Better, Device, DeviceError, FIELDS, Field, Origin};
pub use frame::{Bounds, Frame, Launch, Overlap, Time};
pub use kernel::{Kernel, Term};
