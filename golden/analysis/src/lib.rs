//! Analysis of the effects that a scene and a camera path need.
//!
//! [`Analysis`] determines from the data, without rendering, whether each
//! [`Effect`](potamoi_base::effects::Effect) is needed, with evidence. [`Hardware`] is a
//! configuration without the parts that no frame of the scene can use.
//!
//! ```
//! use potamoi_analysis::{Analysis, Surroundings};
//! use potamoi_base::effects::Effect;
//! use potamoi_formats::config::Config;
//! use potamoi_scene::Scene;
//!
//! let mut scene = Scene::open("garden")?;
//! scene.set_size(Some(16), Some(12))?;
//! let path = [*scene.camera()];
//! let found = Analysis::of(&scene, &path, &Config::paper(), Surroundings::default())?;
//! println!("{}", found.evidence(Effect::Sorting));
//! # Ok::<(), potamoi_scene::SceneError>(())
//! ```

mod evidence;
mod findings;
pub mod hard_cases;
mod hardware;
mod holes;
mod path_visibility;
mod surroundings;
#[cfg(test)]
mod tests;

pub use findings::{Analysis, Finding};
pub use hardware::{Hardware, HardwareError, LeftOut};
pub use holes::Holes;
pub use path_visibility::{PathVisibility, is_still};
pub use surroundings::Surroundings;
