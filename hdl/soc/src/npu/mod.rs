//! The SoC top `potamoi_npu_ext`: both units with AXI4-Stream data, AXI4-Lite registers and an
//! interrupt.
//!
//! [`registers`] has the one table of registers. The hardware that decodes them, SystemRDL, JSON,
//! Markdown, the C header and the tests are made of it.

mod axi_lite;
mod checks;
mod field_placement;
mod job;
mod packet_gate;
mod register_checks;
mod register_file;
pub mod registers;
mod side_checks;
mod top;
mod unit_side;

/// Folder of the texts of the register map beside the Verilog.
pub const REGISTERS: &str = "registers";

pub use top::{npu_ext, registers as register_map_of};
