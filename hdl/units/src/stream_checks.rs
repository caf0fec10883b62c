//! Checks of AXI4-Stream, for the outputs of both units.

use potamoi_netlist::ModuleBuilder;

/// What the stream offers stays until it is taken. `fields` are its payload, such as `tdata`.
pub(crate) fn stable_stream(m: &mut ModuleBuilder, stream: &str, fields: &[&str]) {
    let waits = m.ghost_reg("waits", 1);
    m.ghost_next(waits, "1", &format!("{stream}_tvalid & ~{stream}_tready"));
    let mut same = vec![];
    for field in fields {
        let port = format!("{stream}_{field}");
        let width = m.named(&port).width();
        let past = m.ghost_reg(&format!("{field}_past"), width);
        m.ghost_next(past, "1", &port);
        m.same(&format!("{field}_stays"), &port, &format!("{field}_past"));
        same.push(format!("{field}_stays"));
    }
    m.assert(
        "valid_stays",
        &format!("waits -> {stream}_tvalid"),
        "tvalid stays until tready.",
    );
    let (last, others) = fields.split_last().unwrap_or((&"", &[]));
    m.assert(
        "beat_stays",
        &format!("waits -> {}", same.join(" & ")),
        &format!("{} and {last} stay until tready.", others.join(", ")),
    );
}
