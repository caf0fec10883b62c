//! Mutation score of a unit: how many small faults in its netlist the judges find.
//!
//! A mutant is one fault in one cell: an input or output bit is inverted, constant, or follows
//! another bit. Yosys draws them, evenly over the cells of each module. One build holds them all; an
//! input tells which is active.
//!
//! The judges are, in this order: the standalone bench; a miter of the module, which shows that a
//! mutant is equivalent; a miter of the unit, from the states that the proofs allow; the proofs; the
//! verification against the golden models. A mutant that none settles is alive.

mod all_operands;
mod bench;
mod case;
mod design;
mod equivalence;
mod error;
mod fate;
mod judge;
mod mutant;
mod proofs;
mod question;
mod record;
mod score;
mod tools;
mod unit_miter;

pub use design::{Design, Draw, chosen_modules};
pub use equivalence::Miter;
pub use error::MutateError;
pub use fate::Fate;
pub use judge::Judge;
pub use mutant::Mutant;
pub use record::Kept;
pub use score::{Judged, Options, Score, Verify, score};
pub use tools::Tools;
