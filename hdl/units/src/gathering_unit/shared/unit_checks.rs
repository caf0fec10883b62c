//! Checks of the gathering unit in every organisation.

use potamoi_formats::config::Config;
use potamoi_netlist::ModuleBuilder;

/// What is assumed of the inputs.
pub(crate) fn environment(m: &mut ModuleBuilder, config: &Config) {
    m.assume(
        "settings_stay",
        "idle | settings == settings_before",
        "cfg_* change only while the unit is idle.",
    );
    m.assume(
        "segments_built",
        &format!(
            "idle & ~s_axis_rit_tvalid | cfg_segments > 0 & cfg_segments <= {}",
            config.gu.segments
        ),
        "The segments are as many as the unit is built for.",
    );
    m.assume(
        "regular",
        "~any(rit_errors)",
        "The RIT stream raises no flag.",
    );
}

/// AXI4-Stream: what is offered stays until it is taken.
pub(crate) fn stable_stream(m: &mut ModuleBuilder) {
    let waits = m.ghost_reg("waits", 1);
    m.ghost_next(waits, "1", "m_axis_feat_tvalid & ~m_axis_feat_tready");
    let fields = ["tdata", "tkeep", "tlast", "tuser"];
    let mut same = vec![];
    for field in fields {
        let port = format!("m_axis_feat_{field}");
        let width = m.named(&port).width();
        let past = m.ghost_reg(&format!("{field}_past"), width);
        m.ghost_next(past, "1", &port);
        m.same(&format!("{field}_stays"), &port, &format!("{field}_past"));
        same.push(format!("{field}_stays"));
    }
    m.assert(
        "valid_stays",
        "waits -> m_axis_feat_tvalid",
        "tvalid stays until tready.",
    );
    m.assert(
        "beat_stays",
        &format!("waits -> {}", same.join(" & ")),
        "tdata, tkeep, tlast and tuser stay until tready.",
    );
}
