//! Hard cases in pictures, in Verilog and in the system. Each is a small scene made of one case:
//! rendered by the obvious form, in floats, in the hardware's formats by the twins and by the
//! simulated Verilog, and modelled as frames of a path. The same cases at the unit, against
//! numbers of 256 bits, are in golden/analysis/src/hard_cases.

mod command;
mod fields;
mod files;
mod fog;
mod levels;
mod modelled;
mod obvious;
mod pictures;
mod sampled;
mod scenes;
mod sheet;
mod system;
mod table;
mod units;
mod voxels;
mod warped;
