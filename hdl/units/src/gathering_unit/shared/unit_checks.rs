//! Checks of the gathering unit in every organisation.

use potamoi_formats::config::Config;
use potamoi_netlist::{Instance, ModuleBuilder};

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

/// `all_ready`: both sources are valid and the sink is ready. Of the RIT buffer, what moves in it:
/// `rit_read_fire` and `fills_issue`.
pub(crate) fn all_ready(m: &mut ModuleBuilder, rit: Instance) {
    for name in ["read_fire", "p_free", "q_valid"] {
        m.inside(rit, name);
    }
    m.ghost(
        "all_ready",
        "m_axis_feat_tready & s_axis_rit_tvalid & any(s_axis_rit_tkeep) & s_axis_mft_tvalid",
    );
    m.ghost("fills_issue", "rit_p_free & rit_q_valid");
}
