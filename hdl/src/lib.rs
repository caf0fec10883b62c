//! Run-time netlist, Verilog printer and Potamoi's hardware units.

pub mod emit;
pub mod gu;
pub mod ir;
pub mod parts;
pub mod vu;
