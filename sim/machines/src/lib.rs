//! Machines beside one another: comparison, sweeps over any field, and the search for the best.
//!
//! | module | contents |
//! |---|---|
//! | [`machine`] | a machine and its file: configuration, system, render settings and path together |
//! | [`workload`] | what machines do on a scene, and how it is timed |
//! | [`workbench`] | figures of machines on scenes; what machines have in common is counted once |
//! | [`figures`], [`quality`], [`cells`] | those figures, the quality of the picture, and both as columns |
//! | [`space`] | spaces of machines: fields of the file, each with its values |
//! | [`sweep`] | every point of a plan, each once, resumable; fronts; two sweeps beside one another |
//! | [`search`] | the best machine of a space, within limits |
//! | [`comparison`] | machines side by side, with ratios |
//! | [`fair_bench`] | machines beside GPUs and published accelerators, on one counted trace of frozen inputs |

pub mod cells;
pub mod comparison;
pub mod fair_bench;
pub mod figures;
pub mod machine;
pub mod quality;
pub mod search;
pub mod space;
pub mod sweep;
#[cfg(test)]
mod tests;
pub mod workbench;
pub mod workload;

pub use comparison::{Comparison, Ratios, Row};
pub use fair_bench::FairBench;
pub use figures::Figures;
pub use machine::{Machine, MachineError};
pub use space::{Axis, Space, SpaceError};
pub use workbench::{WINDOW, Workbench};
pub use workload::{Fidelity, Workload};
