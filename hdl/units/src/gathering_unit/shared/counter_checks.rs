//! Checks of the counters: no cycle between the first and the last issue is lost, and no entry.

use potamoi_netlist::ModuleBuilder;

/// What the counters of a unit count.
pub(crate) struct Counted<'a> {
    /// Causes of stalls that count once something is issued after them.
    pub(crate) running: &'a [&'a str],
    /// Causes of stalls that count at once.
    pub(crate) at_once: &'a [&'a str],
    /// When the entries of a group count.
    pub(crate) groups: &'a str,
}

/// Each cycle after the first issue counts once, under one cause.
pub(crate) fn counter_checks(m: &mut ModuleBuilder, bits: u32, counted: &Counted<'_>) {
    let full = (0..bits).fold(0u64, |all, bit| all | 1 << bit);
    let next = format!("if(cfg_clear, 0, if(elapsed == {full}, {full}, elapsed + 1))");
    let elapsed = m.ghost_reg("elapsed", bits);
    m.ghost_next(elapsed, "cfg_clear | fire | begun", &next);
    let shown = m.ghost_reg("elapsed_shown", bits);
    m.ghost_next(shown, "cfg_clear | fire", &next);
    let sum = |prefix: &str| {
        let running = counted.running.iter().map(|c| format!("{prefix}_{c}"));
        let at_once = counted.at_once.iter().map(|c| format!("stat_stall_{c}"));
        let all: Vec<String> = running.chain(at_once).collect();
        all.join(" + ")
    };
    m.invariant(
        "running_sum",
        &format!(
            "elapsed < {full} -> stat_busy + {} == elapsed & begun == any(elapsed)",
            sum("running")
        ),
        "",
    );
    m.assert(
        "no_cycle_lost",
        &format!(
            "elapsed_shown < {full} -> stat_busy + {} == elapsed_shown",
            sum("stat_stall")
        ),
        "Busy cycles and stalls are all cycles from the first issue to the last, until they saturate.",
    );
    saturation(m, full, counted);
    let entries = m.ghost_reg("entries_again", bits);
    let more = "entries_again + entries_of_group";
    m.ghost_next(
        entries,
        &format!("cfg_clear | {}", counted.groups),
        &format!("if(cfg_clear, 0, if({more} > {full}, {full}, {more}))"),
    );
    m.assert(
        "entries_count",
        "stat_entries == entries_again",
        "Every entry of a group that is issued counts.",
    );
}

/// A counter that is full neither wraps nor falls before it is cleared.
fn saturation(m: &mut ModuleBuilder, full: u64, counted: &Counted<'_>) {
    let running = counted
        .running
        .iter()
        .map(|cause| format!("running_{cause}"));
    let at_once = counted.at_once.iter();
    let at_once = at_once.map(|cause| format!("stat_stall_{cause}"));
    let counters = std::iter::once("stat_busy".to_owned()).chain(running);
    let stay = counters.chain(at_once).map(|counter| {
        let was_full = m.ghost_reg(&format!("{counter}_was_full"), 1);
        m.ghost_next(was_full, "1", &format!("{counter} == {full} & ~cfg_clear"));
        format!("({counter}_was_full -> {counter} == {full})")
    });
    let stay: Vec<String> = stay.collect();
    m.assert(
        "counters_saturate",
        &stay.join(" & "),
        "A counter that is full stays so until it is cleared.",
    );
}
