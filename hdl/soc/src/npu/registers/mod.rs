//! The registers of the SoC top: one table, and the texts that come of it.

mod c_header;
mod json;
mod markdown;
mod model;
mod rdl;
mod table;

pub use c_header::c_header;
pub use json::json;
pub use markdown::{markdown, tables};
pub use model::{
    ADDRESS_BITS, Access, Field, INDEX_BITS, Register, RegisterMap, WORD_BITS, WORD_BYTES,
};
pub use rdl::system_rdl;
pub use table::{IDENTIFIER, VERSION, register_map};
pub(in crate::npu) use table::{counted, settings};

#[cfg(test)]
mod tests;
