//! Model of the system around the units, and the scheduler of warped paths.
//!
//! [`soc`] counts a frame's work by the cycle models, and gives time and energy of it on the
//! accelerator, a GPU, its memory and a link. [`runtime`] decides when references and targets of
//! a warped sequence are rendered. [`effects`] says which cycles of a frame are for what. No
//! Verilog is run for any of it.
//!
//! # Example
//!
//! A frame on a GPU that does everything, with the paper's memory and with half of its channels: the
//! fewer, the longer.
//!
//! ```
//! use potamoi_formats::config::Config;
//! use potamoi_scene::Scene;
//! use potamoi_system::soc::work::FrameWork;
//! use potamoi_system::soc::{Memory, System, gpu_only};
//!
//! let (config, system) = (Config::paper(), System::default());
//! let mut scene = Scene::open("garden")?;
//! scene.set_size(Some(16), Some(16))?;
//! let (array, cache) = (system.array(), system.gpu.cache_bytes);
//! let work = FrameWork::count(&scene, &config, array, cache, None)?;
//! assert!(work.gaussians > 0 && work.total().vector_cycles > 0);
//!
//! let time = |channels: u32| {
//!     let memory = Memory::lpddr3(channels);
//!     gpu_only(&system.gpu, &system.instructions, &memory, &work).total_ns()
//! };
//! assert!(time(system.memory_channels) <= time(system.memory_channels / 2));
//! # Ok::<(), potamoi_scene::SceneError>(())
//! ```

pub mod effects;
mod frame_scheduler;
pub mod link;
pub mod runtime;
pub mod soc;
mod trace_events;
