//! Static error analysis of dropped bits, cycle by cycle, over whole sets of inputs.
//!
//! Every node has an interval of values and an interval of errors. The error is the difference from
//! the same netlist with exact sums, products, shifts and roundings, where every decision
//! (multiplexers, table entries, shift amounts) is the actual one. The low part of a value used
//! alone counts as dropped, unless the value is declared as read in parts. The error is unbounded
//! where no bound is found, for example where a sum may wrap.
//!
//! Interval arithmetic ignores correlations. Multiplexer conditions are the exception: each side is
//! evaluated with the facts that the condition implies for the compared values. A remainder is thus
//! known to be non-negative after a subtraction.

mod branch;
mod interval_interpreter;
mod node_error;
#[cfg(test)]
mod tests;
mod transfer;

pub use interval_interpreter::IntervalInterpreter;
