//! Studies over the whole chain, from a scene and a configuration to results.
//!
//! | module | question |
//! |---|---|
//! | [`accuracy`] | how much time, energy and area each setting of each knob costs, and which settings are cheapest at a quality |
//! | [`exponential`] | the error of the exponential, and the cost of other methods |
//! | [`system`] | the speed-up of the whole system over a GPU with an array, and its sensitivity to assumptions |
//! | [`warping`] | the quality of warped frames, their share of rendered pixels, and their schedule |
//! | [`effects`] | the effects that a scene calls for, and the cost of each |
//! | [`characterisation`] | reads, cache misses and bank conflicts |
//! | [`organisations`] | the cycles of a frame's gathers in each organisation of the banks |
//! | [`synthesis`] | area, clock and power of units |
//! | [`inspection`] | what a file of a model says and holds, and what its format costs beside another |
//! | [`rendering`], [`verification`] | a picture by any arithmetic; workloads for the verification of hardware |
//!
//! A [`Setup`] is a scene with the configuration that renders it and the system around that. A
//! [`Progress`] receives the progress of a study; nothing here prints. Results serialise in the
//! format of the command line's reports.
//!
//! # Example
//!
//! The exponential in 8 iterations is compared with the default on one frame. It is faster and has
//! a larger error against the converged picture. Neither dominates the other, so both are on the front.
//!
//! ```
//! use potamoi_explore::accuracy::{Bench, CostQuality, Paths, Price, front, knobs};
//! use potamoi_explore::{ConfigChoice, Setup};
//! use potamoi_system::system_model::System;
//! use potamoi_scene::Scene;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut scene = Scene::open("garden")?;
//! scene.set_size(Some(16), None)?;
//! let setup = Setup::new(ConfigChoice::for_scene(&scene)?, &System::default(), scene, None)?;
//! let knobs = knobs::named(knobs::of(&setup.scene), &["iterations".to_owned()])?;
//! let bench = Bench::new(setup, 2)?;
//! let mut places: Vec<CostQuality> = vec![];
//! for settings in [vec![], vec![&knobs[0].settings[0]]] {
//!     places.extend(bench.place(&settings, Paths::Counted, Price::Time)?);
//! }
//! assert!(places[1].cost < places[0].cost && places[1].quality < places[0].quality);
//! assert_eq!(front(&places), [1, 0]);
//! # Ok(())
//! # }
//! ```

pub mod accuracy;
mod cause;
pub mod characterisation;
pub mod effects;
mod error;
pub mod exponential;
pub mod inspection;
pub mod organisations;
mod progress;
pub mod rendering;
mod setup;
pub mod splat_unit_run;
mod syntheses;
pub mod synthesis;
pub mod system;
mod unit_parameters;
pub mod verification;
pub mod warping;

pub use cause::Cause;
pub use error::ExploreError;
pub use progress::Progress;
pub use setup::{ConfigChoice, Setup, Shared, store};
pub use syntheses::Syntheses;
