//! Checks of the feature-major unit as a whole: beats in flight, the feature stream, counters.

use potamoi_formats::config::Config;
use potamoi_formats::timing::GatherStage;
use potamoi_netlist::{Instance, ModuleBuilder};

use crate::gathering_unit::shared::counter_checks::{Counted, counter_checks};
use crate::gathering_unit::shared::unit_checks::{all_ready, environment};
use crate::stream_checks::stable_stream;

/// Checks of the unit; `rit` is its RIT buffer, and `fifo` holds the results.
pub(super) fn unit_checks(m: &mut ModuleBuilder, config: &Config, rit: Instance, fifo: Instance) {
    m.begin_checks();
    environment(m, config);
    m.inside(fifo, "count");
    let depth = config.feature_fifo_depth();
    // A beat is open from the first round of its first vertex to the last round of its last one.
    let open = m.ghost_reg("beat_open", 1);
    m.ghost_next(open, "1", "(beat_open | beat_start) & ~completes");
    let registered = config.gather_pipeline().has(GatherStage::Output);
    let out = if registered { " + out_valid" } else { "" };
    m.assert(
        "balance",
        &format!(
            "in_flight == results_count{out} + s_push + x_completes + d_completes + beat_open"
        ),
        "Every beat in flight is open, in the pipeline or in the FIFO: none is lost, none is there twice.",
    );
    m.assert(
        "credit",
        &format!("in_flight <= {depth}"),
        "No more beats are in flight than the FIFO has words.",
    );
    m.assert(
        "idle_is_empty",
        "idle -> ~(step_valid | beat_open | d_completes | x_completes | s_push | rit_p_valid | \
         m_axis_feat_tvalid)",
        "An idle unit has nothing in flight.",
    );
    if registered {
        m.invariant(
            "one_word_outside",
            "in_flight > results_count + out_valid | ~s_push",
            "",
        );
    }
    steps(m);
    progress(m, rit);
    stable_stream(m, "m_axis_feat", &["tdata", "tkeep", "tlast", "tuser"]);
    let counted = Counted {
        running: &["fifo", "mft", "rit"],
        at_once: &["bank"],
        groups: "step_done & step_ends_entries",
    };
    counter_checks(m, config.gu.counter_bits, &counted);
    m.cover(
        "full",
        &format!("in_flight == {depth}"),
        "All credit is used.",
    );
    m.cover("delivers", "pop", "A beat of features leaves.");
}

/// With both sources valid and the sink ready, something moves in every cycle; the rounds of a step
/// end, since each serves a lane.
fn progress(m: &mut ModuleBuilder, rit: Instance) {
    m.assert(
        "round_serves",
        "fire -> ~any(lane_is_pending) | any(granted)",
        "In every round of a step a lane is served, if one is left.",
    );
    all_ready(m, rit);
    m.invariant(
        "lanes_in_turn",
        "(lanes_full_0 != lanes_full_1) == (fill_half != next_half)",
        "The halves of the lanes are filled and read in turn.",
    );
    m.invariant(
        "next_lanes_are_first",
        "lanes_full_0 | lanes_full_1 -> if(next_half, lanes_full_1, lanes_full_0)",
        "",
    );
    m.assert(
        "never_stuck",
        "all_ready -> s_axis_rit_tready | s_axis_mft_tready | fire | pop | d_completes | x_completes | \
         s_push | any(results_count) | take | read_step | rit_read_fire | fills_issue",
        "With both sources valid and the sink ready, a beat or a vertex moves in every cycle.",
    );
}

/// Whether a beat is open follows from the step, and from the vertex that is read next.
fn steps(m: &mut ModuleBuilder) {
    for (name, formula) in [
        (
            "first_round_opens",
            "step_valid -> beat_open == ~begins_channel",
        ),
        (
            "next_begins_after_last",
            "next_vertex == 0 -> if(step_valid, step_last, ~beat_open)",
        ),
        (
            "next_goes_on",
            "next_vertex != 0 -> if(step_valid, ~step_last, beat_open)",
        ),
        ("vertex_in_range", "next_vertex <= top_vertex"),
        (
            "pass_ends_with_beat",
            "step_valid & step_ends_pass -> step_last",
        ),
        ("open_has_rows", "beat_open -> mft_is_loaded"),
    ] {
        m.invariant(name, formula, "");
    }
}
