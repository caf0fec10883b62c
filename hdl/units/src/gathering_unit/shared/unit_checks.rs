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
