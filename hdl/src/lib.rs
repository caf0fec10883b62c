//! Run-time netlist, Verilog printer and Potamoi's hardware units.

pub mod ir;
