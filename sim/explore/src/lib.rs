//! Studies on the whole chain.

mod error;
mod progress;
mod setup;
pub mod system;

pub use error::ExploreError;
pub use progress::Progress;
pub use setup::{Chosen, Setup, store};
