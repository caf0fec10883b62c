//! Cost of accuracy: every knob of a scene's frame on one scale, and a search over their settings.

mod bench;
mod front;
pub mod knobs;
mod likeness;
mod point;
mod price;
mod proof;
mod search;
mod seek;
mod sweep;
mod units;

pub use bench::Bench;
pub use front::{Place, front, knee};
pub use likeness::{Likeness, PixelError};
pub use point::Point;
pub use price::Price;
pub use proof::Proof;
pub use search::{Choice, Goal, Paths, search_by_ways_alone};
pub use seek::{Candidate, Search};
pub use sweep::{Found, Refused, Sweep};
pub use units::{UnitError, UnitErrors};
