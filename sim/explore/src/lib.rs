//! Studies on the whole chain, from a scene and a configuration to figures.
//!
//! | module | question |
//! |---|---|
//! | [`accuracy`] | which settings of which knobs cost how much time, energy and area, and which are the cheapest that hold a quality |
//! | [`exponential`] | how far off the exponential is, and what other ways to find it take |
//! | [`system`] | how many times faster the whole system is than a GPU with an array, and what that rests on |
//! | [`warping`] | how good warped frames are, how many of their pixels are rendered, and when |
//! | [`effects`] | what a scene calls for, and what each effect takes |
//! | [`characterisation`] | what is read, what misses a buffer and what conflicts on banks |
//! | [`synthesis`] | area, clock and power of units, many at once |
//! | [`rendering`], [`verification`] | a picture by any arithmetic; the work that hardware is verified with |
//!
//! A [`Setup`] is a scene with the configuration that renders it and the system around that. How far
//! a study has come is told to a [`Progress`]; nothing here prints. Results serialise as the command
//! line's reports have them.
//!
//! # Example
//!
//! Two settings of the exponential's iterations against the default, on one frame: of 8 iterations
//! the frame takes less time and is farther from the model.
//!
//! ```
//! use potamoi_explore::accuracy::{Bench, knobs};
//! use potamoi_explore::{Chosen, Setup};
//! use potamoi_scene::Scene;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut scene = Scene::open("garden")?;
//! scene.set_size(Some(16), None)?;
//! let setup = Setup::of_times(Chosen::for_scene(&scene)?, scene, None)?;
//! let knobs = knobs::named(knobs::of(&setup.scene), &["iterations".to_owned()])?;
//! let bench = Bench::new(setup, 2)?;
//! let default = bench.point("default", "", &[])?;
//! let fewer = bench.point("iterations", "8", &[&knobs[0].settings[0]])?;
//! assert!(fewer.frame_ns < default.frame_ns);
//! assert!(fewer.model.db < default.model.db);
//! # Ok(())
//! # }
//! ```

pub mod accuracy;
pub mod characterisation;
pub mod effects;
mod error;
pub mod exponential;
mod progress;
pub mod rendering;
mod setup;
pub mod synthesis;
pub mod system;
pub mod verification;
pub mod warping;

pub use error::ExploreError;
pub use progress::Progress;
pub use setup::{Chosen, Setup, store};
