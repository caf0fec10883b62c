//! The vector unit. Its interface and timing: `docs/reference/vector-unit.md`.

mod acceptance;
mod addends;
mod alu;
mod bound;
mod checks;
mod exponential;
mod lane;
mod lane_control;
mod lanes;
mod operation_kinds;
mod result_control;
mod sequence;
mod timing;
mod top;

pub use bound::{Bound, error_bound};
pub use exponential::constants::{ln_one_plus, ln_two_times};
pub(crate) use timing::depth;
pub use top::vector_unit;
