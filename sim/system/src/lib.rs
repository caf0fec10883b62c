//! Model of the system around the units, and the scheduler of warped paths.
//!
//! [`system_model`] counts a frame's work with the meters of `potamoi_cycles`, and computes its
//! time and energy on the accelerator, a GPU, the memory and a link. [`path_schedule`] schedules
//! the references and targets of a warped sequence. [`call_digest`] is a digest of a frame's unit
//! calls. This crate runs no Verilog.
//!
//! # Example
//!
//! A frame entirely on the GPU, in its unlimited mode and in one of 15 W. Each time has two
//! bounds, and less power makes the frame slower at both.
//!
//! ```
//! use potamoi_formats::config::Config;
//! use potamoi_scene::Scene;
//! use potamoi_system::system_model::work::FrameWork;
//! use potamoi_gpu::Device;
//! use potamoi_system::system_model::{System, gpu_only};
//!
//! let (config, system) = (Config::paper(), System::default());
//! let mut scene = Scene::open("garden")?;
//! scene.set_size(Some(16), Some(16))?;
//! let (array, cache) = (system.array(), system.gpu.cache_bytes());
//! let work = FrameWork::count(&scene, &config, array, cache, None)?;
//! assert!(work.gaussians > 0 && work.total().vector_cycles > 0);
//!
//! let fast = gpu_only(&system.gpu.device, &work);
//! let slow = gpu_only(&Device::builtin("xavier-15w")?, &work);
//! assert!(fast.max <= fast.sum && fast.max < slow.max && fast.sum < slow.sum);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod call_digest;
mod frame_scheduler;
pub mod link;
pub mod path_schedule;
pub mod system_model;
mod trace_events;
