//! The vector unit. Its interface and timing: `docs/reference/vector-unit.md`.

mod acceptance;
mod alu;
mod bound;
mod constants;
mod control;
mod early_out;
mod engine;
mod iterative;
mod kinds;
mod lane;
mod lanes;
mod logistic;
mod orders;
mod pieces;
mod radix4;
mod sequence;
mod tag;
mod timing;
mod top;
mod widths;

pub use bound::{Bound, error_bound};
pub use constants::{ln_one_plus, ln_two_times};
pub use top::vector_unit;
