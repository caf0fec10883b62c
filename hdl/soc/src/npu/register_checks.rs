//! Checks of the registers: reads and writes of software, and events.

use potamoi_netlist::{ModuleBuilder, Signal};

use super::field_placement::placed;
use super::registers::{Access, INDEX_BITS, Register, WORD_BITS};

/// A register and its value.
pub(super) struct Word<'a> {
    pub(super) own: &'a Register,
    pub(super) value: Signal,
    /// The inputs of its fields.
    pub(super) set: Vec<Option<Signal>>,
}

/// Checks of `npu_registers`.
pub(super) fn register_checks(m: &mut ModuleBuilder, words: &[Word<'_>]) {
    m.begin_checks();
    kept(m, words);
    shown(m, words);
    refused(m, words);
    events(m, words);
}

/// Accesses to addresses without a register that allows them.
fn refused(m: &mut ModuleBuilder, words: &[Word<'_>]) {
    for (kind, index) in [("read", "read_index"), ("write", "write_index")] {
        let own = words.iter().map(|word| word.own);
        let allowed = own.filter(|own| kind == "read" || own.access.is_written());
        let index = m.named(index);
        let there: Vec<_> = allowed
            .map(|own| {
                let at = m.lit(own.offset / 4, index.ty());
                m.eq(index, at)
            })
            .collect();
        let there = m.any_of(&there);
        let there = m.not(there);
        let none = m.name(there, &format!("no_{kind}"));
        let error = m.named(&format!("{kind}_error"));
        let same = m.eq(error, none);
        m.name(same, &format!("{kind}_error_is_right"));
    }
    m.assert(
        "refused_elsewhere",
        "read_error_is_right & write_error_is_right",
        "An access is refused where no register allows it, and nowhere else.",
    );
}

/// A read gives the value of the register.
fn shown(m: &mut ModuleBuilder, words: &[Word<'_>]) {
    let [read, index] = ["read_data", "read_index"].map(|name| m.named(name));
    let mut right = vec![];
    for word in words.iter().filter(|w| w.own.access != Access::Pulse) {
        let at = m.lit(word.own.offset / 4, index.ty());
        let elsewhere = m.ne(index, at);
        let same = m.eq(read, word.value);
        right.push(m.or(elsewhere, same));
    }
    let right = m.all_of(&right);
    m.name(right, "reads_are_values");
    m.assert(
        "read_as_it_is",
        "reads_are_values",
        "A read of a register gives its value.",
    );
}

/// Bits of a register that have a field.
fn implemented(m: &mut ModuleBuilder, own: &Register) -> Signal {
    let bits = own.fields.iter().fold(0u64, |all, field| {
        all | ((1u64 << field.width) - 1) << field.low
    });
    m.lit(bits, potamoi_netlist::Ty::u(WORD_BITS))
}

/// What software writes it reads back, of a register that is any of those that it can write.
fn kept(m: &mut ModuleBuilder, words: &[Word<'_>]) {
    let any = m.free("any_register", INDEX_BITS);
    m.ghost("any_written", "write & write_index == any_register");
    let value = m.ghost_reg("value_written", WORD_BITS);
    let known = m.ghost_reg("bits_written", WORD_BITS);
    let [mask, ones, written] = ["write_mask", "written_ones", "any_written"].map(|n| m.named(n));
    let stays = m.not(mask);
    let stays = m.and(value, stays);
    let next = m.or(stays, ones);
    m.set_next_if(value, written, next);
    let next = m.or(known, mask);
    m.set_next_if(known, written, next);

    let mut of_any = vec![];
    for word in words.iter().filter(|w| w.own.access == Access::ReadWrite) {
        let name = word.own.name.to_ascii_lowercase();
        let bits = implemented(m, word.own);
        let at = m.lit(word.own.offset / 4, any.ty());
        let here = m.eq(any, at);
        m.name(here, &format!("any_is_{name}"));
        let here = m.repeat(here, WORD_BITS);
        let bits = m.and(here, bits);
        let bits = m.name(bits, &format!("any_{name}_bits"));
        of_any.push(bits);
        let wrong = differs(m, word.value, [value, known, bits]);
        m.name(wrong, &format!("{name}_differs"));
        m.invariant(&format!("{name}_kept"), &format!("~{name}_differs"), "");
    }
    let none = m.lit(0, value.ty());
    let of_any = of_any.into_iter().reduce(|a, b| m.or(a, b)).unwrap_or(none);
    let read = m.named("read_data");
    let wrong = differs(m, read, [value, known, of_any]);
    m.name(wrong, "read_differs");
    m.assert(
        "read_as_written",
        "read_index == any_register -> ~read_differs",
        "A read of a register that software writes gives what was written last, byte by byte.",
    );
}

/// Whether a word differs from a value in bits that are known and there.
fn differs(m: &mut ModuleBuilder, word: Signal, [value, known, bits]: [Signal; 3]) -> Signal {
    let other = m.xor(word, value);
    let other = m.and(other, known);
    let other = m.and(other, bits);
    m.any(other)
}

/// Bits that the hardware sets and software clears.
fn events(m: &mut ModuleBuilder, words: &[Word<'_>]) {
    let events = words.iter();
    for word in events.filter(|w| w.own.access == Access::WriteOneToClear) {
        let name = word.own.name.to_ascii_lowercase();
        let sets: Vec<Signal> = word.set.iter().flatten().copied().collect();
        let sets = placed(m, word.own, &sets);
        let written = m.named(&format!("{name}_written"));
        let written = m.repeat(written, WORD_BITS);
        let ones = m.named("written_ones");
        let clears = m.and(written, ones);
        let [was_set, was_cleared, before] = [
            ("was_set", sets),
            ("was_cleared", clears),
            ("before", word.value),
        ]
        .map(|(suffix, value)| {
            let reg = m.ghost_reg(&format!("{name}_{suffix}"), WORD_BITS);
            m.set_next(reg, value);
            reg
        });
        let bits = implemented(m, word.own);
        let [gone, left, unset] = [word.value, was_cleared, was_set].map(|s| m.not(s));
        for (parts, name, doc) in [
            (
                [was_set, gone, bits],
                "none_lost",
                "An event sets its bit even at the edge at which software clears it.",
            ),
            (
                [before, left, gone],
                "events_stay",
                "The bit of an event stays until software writes 1 to it.",
            ),
            (
                [was_cleared, unset, word.value],
                "events_clear",
                "Writing 1 clears the bit of an event.",
            ),
        ] {
            let [a, b, c] = parts;
            let wrong = m.and(a, b);
            let wrong = m.and(wrong, c);
            let wrong = m.any(wrong);
            let holds = m.not(wrong);
            m.name(holds, &format!("{name}_now"));
            m.assert(name, &format!("{name}_now"), doc);
        }
    }
}
