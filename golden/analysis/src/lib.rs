//! Which effects a scene and a camera path call for.
//!
//! [`Analysis`] finds every [`Effect`](potamoi_base::effects::Effect) from the data, with evidence;
//! nothing is rendered. [`Hardware`] is a configuration without what no frame of the scene can
//! use.

mod evidence;
mod findings;
#[cfg(test)]
mod hard_cases;
mod hardware;
mod holes;
mod path;
mod surroundings;
#[cfg(test)]
mod tests;

pub use findings::{Analysis, Finding};
pub use hardware::{Hardware, HardwareError, LeftOut};
pub use holes::Holes;
pub use path::{Seen, is_still};
pub use surroundings::Surroundings;
