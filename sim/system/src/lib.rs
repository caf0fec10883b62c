//! The system around the units, and when it renders what.
//!
//! [`soc`] counts a frame's work by the cycle models, and gives time and energy of it on the
//! accelerator, a GPU, its memory and a link. [`runtime`] decides when references and targets of
//! a warped sequence are rendered. [`effects`] says which cycles of a frame are for what. No
//! Verilog is run for any of it.

pub mod effects;
mod frame_scheduler;
pub mod link;
pub mod runtime;
pub mod soc;
mod trace_events;
