//! The life of a job of one unit: begun, refused, done.

use std::sync::Arc;

use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Ty};

use super::checks::job_checks;
use super::registers::WORD_BITS;

/// Builds `npu_job`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn job() -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("npu_job");
    let m = &mut builder;
    m.doc(
        "a job of a unit: it begins while the unit is idle, and is done when all packets have come, \
         all of theirs were taken and the unit is idle again.",
    );
    let bit = Ty::bit();
    let start = m.input("start", bit, "command of software");
    let packets = m.input("packets", Ty::u(WORD_BITS), "packets of the next job");
    let idle = m.input("idle", bit, "of the unit");
    let open = m.input("is_open", bit, "an input still has packets to come");
    let beat = m.input("taken", bit, "the sink takes a beat of the unit");
    let last = m.input("taken_last", bit, "which ends a packet");
    let running = m.reg("running", bit, 0);
    let left = m.reg("left", packets.ty(), 0);
    let some = m.any(packets);
    let stopped = m.not(running);
    let can = m.all_of(&[stopped, idle, some]);
    let can = m.name(can, "can_begin");
    let begins = m.and(start, can);
    let begins = m.name(begins, "begins_now");
    let cannot = m.not(can);
    let refused = m.and(start, cannot);
    let refused = m.name(refused, "refused");
    let owes = m.any(left);
    let ends = m.all_of(&[beat, last, owes]);
    let ends = m.name(ends, "ends");
    let one = m.lit(1, left.ty());
    let fewer = m.sub(left, one);
    let next = m.mux(begins, packets, fewer);
    let changes = m.or(begins, ends);
    m.set_next_if(left, changes, next);
    let comes = m.or(open, owes);
    let complete = m.not(comes);
    let done = m.all_of(&[running, complete, idle]);
    let done = m.name(done, "is_done");
    let goes_on = m.not(done);
    let goes_on = m.and(running, goes_on);
    let next = m.or(goes_on, begins);
    m.set_next(running, next);
    m.output("begins", begins, "the job begins at the clock edge");
    m.output("refused", refused, "the command has no effect");
    m.output("is_running", running, "");
    m.output("done", done, "for one clock");
    m.output("packets_left", left, "packets that are still to be taken");
    job_checks(m);
    builder.finish()
}
