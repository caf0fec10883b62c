//! The operation `exp` in C and in Python against the reference unit, over all operands, and the reducer
//! in Python.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod c;
mod engines;
mod python;
mod reducer;
