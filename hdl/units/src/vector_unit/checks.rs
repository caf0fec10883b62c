//! Checks of the vector unit: vectors in flight and the result stream.

use potamoi_netlist::{Instance, ModuleBuilder};

use super::result_control::{LAG_STAGES, VALID_STAGES};
use crate::stream_checks::stable_stream;

/// Width of the counters in bits.
const COUNTER: u32 = 32;

/// Checks of the unit.
pub(crate) fn vector_unit_checks(m: &mut ModuleBuilder, fifo: Instance, depth: u32, longest: u32) {
    m.begin_checks();
    m.inside(fifo, "count");
    let mut all = vec!["fifo_count".to_owned(), "result_valid".to_owned()];
    // The engine holds a vector for as long as its phases last, or one in each stage.
    if m.has("phase") {
        let last = match m.has("end_phase") {
            true => "end_phase".to_owned(),
            false => (longest - 1).to_string(),
        };
        m.invariant("phase_in_range", &format!("phase <= {last}"), "");
        m.ghost("engine_has_vector", "any(phase)");
        all.push("engine_has_vector".to_owned());
    }
    if m.has(VALID_STAGES) {
        all.push(format!("ones({VALID_STAGES})"));
    }
    if m.has(LAG_STAGES) {
        all.push(format!("ones({LAG_STAGES})"));
    }
    m.assert(
        "balance",
        &format!("in_flight == {}", all.join(" + ")),
        "Every vector in flight is in the engine or in the FIFO: none is lost, none is there twice.",
    );
    m.assert(
        "credit",
        &format!("accept -> in_flight < {depth}"),
        "A vector enters only if fewer are in flight than there is room for.",
    );
    m.invariant("in_flight_fits", &format!("in_flight <= {depth}"), "");
    m.assert(
        "idle_is_empty",
        "idle -> ~(result_valid | m_axis_vec_tvalid)",
        "An idle unit has nothing in flight.",
    );
    stable_stream(m, "m_axis_vec", &["tdata", "tkeep", "tlast"]);
    m.assert(
        "never_stuck",
        &format!(
            "s_axis_vec_tvalid & m_axis_vec_tready -> s_axis_vec_tready | {}",
            all.iter()
                .map(|a| format!("any({a})"))
                .collect::<Vec<_>>()
                .join(" | ")
        ),
        "With the source valid and the sink ready, a vector moves in every cycle.",
    );
    counter_checks(m, depth);
    m.cover(
        "full",
        &format!("in_flight == {depth}"),
        "All credit is used.",
    );
    m.cover("delivers", "pop", "A vector leaves.");
}

/// Each counter is what is seen of its event at the ports and in the engine.
fn counter_checks(m: &mut ModuleBuilder, depth: u32) {
    let enters = "s_axis_vec_tvalid & s_axis_vec_tready";
    let (steps, free) = match (m.has("phase"), m.has(VALID_STAGES)) {
        (true, _) => ("any(phase)".to_owned(), "~any(phase)"),
        (false, true) => (format!("any({VALID_STAGES})"), "1"),
        (false, false) => ("0".to_owned(), "1"),
    };
    let waits = format!("s_axis_vec_tvalid & {free} & in_flight == {depth}");
    for (name, event, doc) in [
        (
            "vectors",
            enters.to_owned(),
            "Every vector that enters counts.",
        ),
        (
            "busy",
            format!("{enters} | {steps}"),
            "Every cycle counts in which a vector enters or is in the engine.",
        ),
        (
            "stall_out",
            waits,
            "Every cycle counts in which a vector waits for nothing but room.",
        ),
    ] {
        let again = format!("{name}_again");
        let ghost = m.ghost_reg(&again, COUNTER);
        let full = u32::MAX;
        m.ghost_next(
            ghost,
            &format!("cfg_clear | {event}"),
            &format!("if(cfg_clear, 0, if({again} == {full}, {full}, {again} + 1))"),
        );
        m.assert(
            &format!("{name}_count"),
            &format!("stat_{name} == {again}"),
            doc,
        );
    }
}
