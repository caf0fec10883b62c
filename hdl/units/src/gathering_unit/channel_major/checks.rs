//! Checks of the gathering unit as a whole: groups in flight, the feature stream, progress, counters.

use potamoi_formats::config::Config;
use potamoi_formats::timing::GatherStage;
use potamoi_netlist::{Instance, ModuleBuilder};

use crate::data_checks::{Held, held_without_enable};
use crate::gathering_unit::shared::counter_checks::{Counted, counter_checks};
use crate::gathering_unit::shared::reducer::stage_name;
use crate::gathering_unit::shared::unit_checks::{all_ready, environment};
use crate::stream_checks::stable_stream;

/// Instances whose state the checks see.
pub(crate) struct Parts {
    pub(crate) rit: Instance,
    pub(crate) fifo: Instance,
}

/// Checks of the channel-major and the parity organisation.
pub(crate) fn gathering_unit_checks(m: &mut ModuleBuilder, config: &Config, parts: &Parts) {
    m.begin_checks();
    let whole_cells = config.is_parity();
    environment(m, config);
    m.inside(parts.fifo, "count");
    let registered = config.gather_pipeline().has(GatherStage::Output);
    let open = if whole_cells {
        String::new()
    } else {
        m.inside(parts.rit, "due");
        m.ghost("group_open", "any(rit_due)");
        " + group_open".to_owned()
    };
    let last = |stage: &str| match whole_cells {
        true => format!("{stage}_valid"),
        false => format!("({stage}_valid & {stage}_last)"),
    };
    let mut stages = vec!["s1".to_owned()];
    stages.extend(
        config
            .reducer_pipeline()
            .stages()
            .skip(1)
            .map(|s| stage_name(s).to_owned()),
    );
    let inner: Vec<String> = stages.iter().map(|s| last(s)).collect();
    let out = if registered { " + out_valid" } else { "" };
    m.assert(
        "balance",
        &format!(
            "in_flight == results_count{out} + s2_push + {}{open}",
            inner.join(" + ")
        ),
        "Every group in flight is open, in the pipeline or in the FIFO: none is lost, none is there twice.",
    );
    m.assert(
        "credit",
        &format!("in_flight <= {}", config.feature_fifo_depth()),
        "No more groups are in flight than the FIFO has words.",
    );
    if registered {
        m.invariant(
            "one_word_outside",
            "in_flight > results_count + out_valid | ~s2_push",
            "",
        );
    }
    if !whole_cells {
        m.invariant("open_has_rows", "group_open -> mft_is_loaded", "");
        // What follows a vertex of a group that is not its last: a younger last one, or more to issue.
        let mut follows = "group_open".to_owned();
        for stage in &stages {
            let formula = format!("{stage}_valid & ~{stage}_last -> {follows}");
            m.invariant(&format!("{stage}_is_followed"), &formula, "");
            follows = format!("{follows} | {}", last(stage));
        }
    }
    idle(m, &stages);
    let held = |register: String, enable| Held { register, enable };
    let registers = ["s2_end", "s2_keep", "s2_slot"].map(str::to_owned);
    let mut all: Vec<_> = registers.map(|own| held(own, "completes")).into();
    let totals = (0..config.gu.ports).map(|port| format!("weight_total{port}"));
    let totals: Vec<String> = totals.filter(|own| m.has(own)).collect();
    all.extend(totals.into_iter().map(|own| held(own, "s1_valid")));
    held_without_enable(m, &all);
    if m.has("single_ids") && m.has("s1_first") && m.has("s1_weight_of_port0") {
        let one = 1 << config.gu.weight_bits;
        let whole = |p| format!("(s1_keep[{p}] -> s1_weight_of_port{p} == {one})");
        let all: Vec<String> = (0..config.gu.ports).map(whole).collect();
        m.invariant(
            "single_ids_weigh_one",
            &format!("single_ids & s1_valid -> s1_first & {}", all.join(" & ")),
            "A single id is the one vertex of its entry, of weight 1.",
        );
    }
    stable_stream(m, "m_axis_feat", &["tdata", "tkeep", "tlast", "tuser"]);
    progress(m, config, parts.rit, &stages);
    if config.table_parts() == 1 {
        let counted = Counted {
            running: &["fifo", "mft", "rit"],
            at_once: &[],
            groups: "group_done",
        };
        counter_checks(m, config.gu.counter_bits, &counted);
    }
    m.cover(
        "full",
        &format!("in_flight == {}", config.feature_fifo_depth()),
        "All credit is used.",
    );
    m.cover("delivers", "pop", "A feature vector leaves.");
    m.cover(
        "delivers_last",
        "pop & m_axis_feat_tlast",
        "The last one of an MVoxel leaves.",
    );
}

fn idle(m: &mut ModuleBuilder, stages: &[String]) {
    let busy: Vec<String> = stages.iter().map(|s| format!("{s}_valid")).collect();
    m.assert(
        "idle_is_empty",
        &format!(
            "idle -> ~({} | s2_push | rit_p_valid | m_axis_feat_tvalid)",
            busy.join(" | ")
        ),
        "An idle unit has nothing in flight.",
    );
}

/// With both sources valid and the sink ready, something moves in every cycle.
fn progress(m: &mut ModuleBuilder, config: &Config, rit: Instance, stages: &[String]) {
    let busy: Vec<String> = stages.iter().map(|s| format!("{s}_valid")).collect();
    let grants = if config.table_parts() > 1 {
        " | asks"
    } else {
        ""
    };
    all_ready(m, rit);
    m.assert(
        "never_stuck",
        &format!(
            "all_ready -> s_axis_rit_tready | s_axis_mft_tready | fire{grants} | pop | {} | s2_push | \
             any(results_count) | rit_read_fire | fills_issue",
            busy.join(" | ")
        ),
        "With both sources valid and the sink ready, a beat or a vertex moves in every cycle.",
    );
}
