//! Studies on the whole chain.

pub mod accuracy;
pub mod characterisation;
pub mod effects;
mod error;
pub mod exponential;
mod progress;
pub mod rendering;
mod setup;
pub mod system;
pub mod verification;
pub mod warping;

pub use error::ExploreError;
pub use progress::Progress;
pub use setup::{Chosen, Setup, store};
