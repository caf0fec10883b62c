//! The project's own comparison of speed: what it takes, beside a limit of the machine or a peer that
//! does the same work, measured in one run.
//!
//! Every figure is *processor time*: the computing time of all threads together. Unlike elapsed time it
//! is stable on a busy machine. The fastest of several runs counts. Figures of different machines, or of
//! different minutes of a busy one, say little; the ratio to what is measured beside says more.
//!
//! ```no_run
//! use potamoi_speed::{Options, Section, compare};
//!
//! let options = Options { sections: vec![Section::Splats], runs: 5, scene: None };
//! for row in compare(&options, &mut |what| eprintln!("{what}"))?.rows {
//!     println!("{}: {:?} {}, {:?}", row.what, row.measured, row.unit, row.ratio);
//! }
//! # Ok::<(), potamoi_speed::SpeedError>(())
//! ```

mod comparison;
mod error;
mod fields;
mod frame_name;
mod machine;
mod peak;
mod row;
mod sizes;
mod splats;
mod time;
mod units;
mod verification;

pub use comparison::{Comparison, Options, compare};
pub use error::SpeedError;
pub use machine::{Busy, Machine, TimeSource, Tool};
pub use row::{Beside, Count, Kind, Row, Section};
