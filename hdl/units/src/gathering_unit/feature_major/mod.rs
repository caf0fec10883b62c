//! The feature-major organisation, which the paper argues against: every bank
//! holds whole feature vectors, R lanes each work on one ray sample, and lanes
//! that want different vectors of one bank wait for one another (paper, Sec.
//! "Bank Conflict-Free Interleaving"). `docs/explanation/organisations.md`.

mod arbiter;
mod lane;
mod loader;
mod passes;
mod sequencer;
mod shape;
mod table;
mod top;

pub(super) use top::feature_major;
