//! Netlists are refused, printed and run as they should be.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod choices;
mod errors;
mod printed;
mod random;
mod shifts;
