//! Checks of registers of data, which have no reset.

use potamoi_netlist::ModuleBuilder;

/// A register, and the input without which it keeps its value.
pub(crate) struct Held<'a> {
    pub(crate) register: String,
    pub(crate) enable: &'a str,
}

/// States of each register that it changes with its enable alone: the clock of a register that has
/// no new value may be gated, and what it holds stays to be read.
pub(crate) fn held_without_enable(m: &mut ModuleBuilder, all: &[Held<'_>]) {
    m.begin_checks();
    for Held { register, enable } in all {
        let width = m.named(register).width();
        let past_enable = m.ghost_data_reg(&format!("{register}_took"), 1);
        m.ghost_next(past_enable, "1", enable);
        let past = m.ghost_data_reg(&format!("{register}_past"), width);
        m.ghost_next(past, "1", register);
        let same = format!("{register}_is_same");
        m.same_in_all_bits(&same, register, &format!("{register}_past"));
        m.assert(
            &format!("{register}_held"),
            &format!("{register}_took | {same}"),
            &format!("`{register}` changes with `{enable}` alone."),
        );
    }
}
