//! Whether the unit is idle, so that its settings may change, and the flag of settings that change
//! otherwise.

use potamoi_netlist::{Instance, ModuleBuilder, Signal};

/// Whether nothing is received, loaded, in flight or waits for the sink. `busy` has further signs of
/// work.
pub(crate) fn idle(
    m: &mut ModuleBuilder,
    in_flight: Signal,
    [rit, table]: [Instance; 2],
    busy: &[Signal],
) -> Signal {
    let flying = m.any(in_flight);
    let empty = [rit, table].map(|below| m.out(below, "is_empty"));
    let empty = m.and(empty[0], empty[1]);
    let holds = m.not(empty);
    let mut all = vec![flying, holds];
    all.extend(busy);
    let busy = m.any_of(&all);
    let idle = m.not(busy);
    m.name(idle, "idle")
}

/// Whether a setting differs from its value one clock before while the unit is not idle.
pub(crate) fn setting_moved(m: &mut ModuleBuilder, settings: &[Signal], idle: Signal) -> Signal {
    let settings: Vec<_> = settings.iter().rev().copied().collect();
    let settings = m.cat(&settings);
    let settings = m.name(settings, "settings");
    let before = m.data_reg("settings_before", settings.ty());
    m.set_next(before, settings);
    let moved = m.ne(settings, before);
    let busy = m.not(idle);
    m.and(moved, busy)
}
