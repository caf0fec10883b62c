//! Verilog of a netlist within rust-hdl's output.

use std::fmt::Write as _;
use std::sync::Arc;

use potamoi_netlist::{Header, Module, verilog};
use rust_hdl_core::ast::{Verilog, Wrapper};

use crate::BridgeError;

/// The emitted modules, and an instance with ports of the same names.
pub(crate) fn wrapper(module: &Arc<Module>, files: &[(String, String)]) -> Verilog {
    let mut ports = vec![];
    if module.is_clocked() {
        ports.push("clk".to_owned());
    }
    if module.has_reset() {
        ports.push("rst_n".to_owned());
    }
    ports.extend(module.ports().into_iter().map(|p| p.name));
    let ports: Vec<_> = ports.iter().map(|p| format!(".{p}({p})")).collect();
    let name = module.name();
    Verilog::Wrapper(Wrapper {
        code: format!("{name} the_{name} ({});", ports.join(", ")),
        cores: guarded(files),
    })
}

/// The files of a netlist.
pub(crate) fn files(module: &Arc<Module>) -> Result<Vec<(String, String)>, BridgeError> {
    let files: Vec<_> = verilog(module, &Header::default()).into_iter().collect();
    if files.iter().any(|(name, _)| name == "top.v") {
        return Err(BridgeError::NamedTop);
    }
    Ok(files)
}

/// rust-hdl prints these once per block, so that two blocks of one netlist would define them twice.
/// The guard covers the content: two different modules of one name remain an error.
fn guarded(files: &[(String, String)]) -> String {
    let mut all = String::new();
    for (_, text) in files {
        let guard = format!("POTAMOI_{:016X}", fingerprint(text));
        let _ = write!(all, "\n`ifndef {guard}\n`define {guard}\n{text}`endif\n");
    }
    all
}

/// 64-bit FNV-1a.
fn fingerprint(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |sum, byte| {
        (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
