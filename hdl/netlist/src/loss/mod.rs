//! How far the values of a netlist can be off because bits are dropped: a static
//! analysis, cycle by cycle, over all inputs of a set at once.
//!
//! Every node has an interval of values and an interval of what it is off from
//! the same netlist in which sums, products, shifts and roundings keep all bits,
//! and in which every decision (multiplexers, table entries, shift amounts) is the
//! one that was made. A low part of a value by itself counts as cut off, unless the
//! value is said to be read in parts. Where no bound is found, as where a sum may
//! wrap, there is none.
//!
//! Interval arithmetic forgets that values are related; a multiplexer's condition
//! is the exception: each side is looked at with what the condition says of the
//! values that it compares, as a remainder that is what was left after a
//! subtraction that did not become negative.

mod branch;
mod interval_interpreter;
mod off;
#[cfg(test)]
mod tests;
mod transfer;

pub use interval_interpreter::IntervalInterpreter;
