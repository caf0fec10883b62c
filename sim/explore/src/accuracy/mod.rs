//! Cost of accuracy: every knob of a scene's frame on one scale, and a search over their settings.

mod bench;
mod image_quality;
pub mod knobs;
mod local_search;
mod pareto_front;
mod point;
mod price;
mod pricing;
mod proof;
mod references;
mod settings_search;
mod sweep;
mod units;

pub use bench::Bench;
pub use image_quality::{ImageQuality, PixelError};
pub use local_search::{Choice, Goal, Paths, search_by_ways_alone};
pub use pareto_front::{CostQuality, front, knee};
pub use point::Point;
pub use price::Price;
pub use proof::Proof;
pub use references::{Convergence, Reference, ReferenceKind, References};
pub use settings_search::{Candidate, Search};
pub use sweep::{Refused, SearchResult, Sweep};
pub use units::{UnitError, UnitErrors};
