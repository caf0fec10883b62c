//! A gate in an AXI4-Stream that lets the packets of a job pass, and no more.

use std::sync::Arc;

use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Ty};

use super::checks::gate_checks;
use super::registers::WORD_BITS;

/// Bits of a step: those of `cfg_segments`.
pub(super) const STEP_BITS: u32 = 7;

/// Builds `npu_packet_gate`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn packet_gate() -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("npu_packet_gate");
    let m = &mut builder;
    m.doc(
        "lets the packets of a job pass from a stream to a unit. Beats of the next job wait in front \
         of it.",
    );
    let bit = Ty::bit();
    let start = m.input("start", bit, "opens the gate, which is closed");
    let packets = m.input("packets", Ty::u(WORD_BITS), "packets of the job");
    let step = m.input(
        "step",
        Ty::u(STEP_BITS),
        "packets that the end of this one stands for",
    );
    let valid = m.input("s_tvalid", bit, "from the master");
    let last = m.input("s_tlast", bit, "");
    let ready = m.input(
        "m_tready",
        bit,
        "from the unit; does not depend on m_tvalid",
    );
    let left = m.reg("left", packets.ty(), 0);
    let open = m.any(left);
    let open = m.name(open, "open");
    let passes = m.and(open, ready);
    let passes = m.name(passes, "s_tready");
    let ends = m.all_of(&[valid, passes, last]);
    let ends = m.name(ends, "ends");
    let step = m.extend(step, WORD_BITS);
    let fewer = m.sub(left, step);
    let zero = m.lit(0, left.ty());
    let none = m.le(left, step);
    let fewer = m.mux(none, zero, fewer);
    let next = m.mux(start, packets, fewer);
    let changes = m.or(start, ends);
    m.set_next_if(left, changes, next);
    let shown = m.and(open, valid);
    let shown = m.name(shown, "m_tvalid");
    m.output("m_tvalid", shown, "to the unit");
    m.output("s_tready", passes, "to the master");
    m.output("is_open", open, "packets are still to come");
    gate_checks(m);
    builder.finish()
}
