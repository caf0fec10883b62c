//! Whole scenes through hardware, and what is counted of them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod effects;
mod units;
