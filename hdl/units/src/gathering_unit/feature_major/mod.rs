//! The feature-major organisation, the paper's counter-example: every bank holds whole feature
//! vectors, each of R lanes processes one ray sample, and lanes that need different vectors of one
//! bank have bank conflicts (paper, Sec. "Bank Conflict-Free Interleaving"). See
//! `docs/explanation/organisations.md`.

mod arbiter;
mod checks;
mod lane;
mod loader;
mod passes;
mod sequencer;
mod shape;
mod table;
mod top;

pub(super) use top::feature_major;
