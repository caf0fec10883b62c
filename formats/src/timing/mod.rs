//! Named pipeline stages of the units, in order.
//!
//! The generator places registers by these names, the cycle models count the stages, and a rule
//! of the configuration asks for the length. Which stages a unit has is decided here once; when a
//! stage moves, what it holds and what it computes is not.
//!
//! ```
//! use potamoi_formats::config::Config;
//! use potamoi_formats::timing::{GatherStage, ReducerStage};
//!
//! let plain = Config::default().gather_pipeline();
//! assert_eq!(plain.cycles(), 3);
//! // The features of the rows that were read are there a cycle after the issue.
//! assert_eq!(plain.cycle(GatherStage::Features), Some(1));
//! assert_eq!(plain.cycle(GatherStage::Reducer(ReducerStage::Product)), None);
//! ```

mod crossbar;
mod element;
mod gather;
mod passes;
mod pipeline;
mod power;
mod rit;

pub use crossbar::CrossbarStage;
pub use element::ElementStage;
pub use gather::{GatherStage, ReducerStage};
pub use passes::{Pass, Passes};
pub use pipeline::Pipeline;
pub use power::{AGREEMENT, PowerRegister, PowerStage};
pub use rit::RitStage;
