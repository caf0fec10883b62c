//! A FIFO, and its checks: order and data of a symbolic word.

use std::sync::Arc;

use potamoi_netlist::{IrErrors, MemId, Module, ModuleBuilder, Ty};

use crate::circuits::{bits_for, wrapping};

/// A FIFO that offers its oldest word while it holds one. The writer keeps track of the free space.
///
/// # Errors
/// The netlist's own checks.
pub(crate) fn fifo(name: &str, depth: u32, width: u32) -> Result<Arc<Module>, IrErrors> {
    let mut m = ModuleBuilder::new(name);
    m.doc(&format!(
        "FIFO of {depth} words of {width} bits. The writer sees to it that there is room."
    ));
    let push = m.input("push", Ty::bit(), "takes push_data at the clock edge");
    let push_data = m.input("push_data", Ty::u(width), "");
    let pop = m.input("pop", Ty::bit(), "drops the word that is offered");
    let pointer = Ty::u(bits_for(depth - 1));
    let mem = m.memory("mem", depth, width, "");
    let write_pointer = m.reg("write_pointer", pointer, 0);
    let read_pointer = m.reg("read_pointer", pointer, 0);
    let count = m.reg("count", Ty::u(bits_for(depth)), 0);
    m.mem_write(mem, push, write_pointer, push_data);
    let end = m.param("LAST_WORD", depth - 1, pointer, "");
    let next = wrapping(&mut m, write_pointer, end);
    m.set_next_if(write_pointer, push, next);
    let next = wrapping(&mut m, read_pointer, end);
    m.set_next_if(read_pointer, pop, next);
    let one = m.lit(1, count.ty());
    let more = m.add(count, one);
    let less = m.sub(count, one);
    let changes = m.xor(push, pop);
    let changed = m.mux(push, more, less);
    m.set_next_if(count, changes, changed);
    let data = m.mem_read_async(mem, read_pointer);
    let valid = m.any(count);
    m.output("valid", valid, "data holds a word");
    m.output("data", data, "");
    fifo_checks(&mut m, mem, depth, width);
    m.finish()
}

/// Checks of a FIFO of `depth` words in `mem`.
fn fifo_checks(m: &mut ModuleBuilder, mem: MemId, depth: u32, width: u32) {
    m.begin_checks();
    m.assume(
        "has_room",
        &format!("push -> count < {depth}"),
        "A word is pushed only if there is room.",
    );
    m.assume(
        "has_word",
        "pop -> any(count)",
        "A word is taken only if there is one.",
    );
    let numbers = bits_for(depth) + 1;
    m.free("pick", numbers);
    let pushes = m.ghost_reg("pushes", numbers);
    m.ghost_next(pushes, "push", "pushes + 1");
    let pops = m.ghost_reg("pops", numbers);
    m.ghost_next(pops, "pop", "pops + 1");
    let tracked = m.ghost_reg("tracked", 1);
    let ahead = m.ghost_reg("ahead", bits_for(depth));
    let word = m.ghost_reg("word", width);
    let slot = m.ghost_reg("slot", bits_for(depth - 1));
    m.ghost("enters", "push & pushes == pick & ~tracked");
    m.ghost("leaves", "pop & tracked & ahead == 0");
    m.ghost_next(tracked, "enters | leaves", "enters");
    m.ghost_next(ahead, "enters | pop", "if(enters, count - pop, ahead - 1)");
    m.ghost_next(word, "enters", "push_data");
    m.ghost_next(slot, "enters", "write_pointer");
    let waits = m.ghost_reg("waits", 1);
    m.ghost_next(waits, "1", "any(count) & ~pop");
    let head = m.ghost_reg("head", width);
    m.ghost_next(head, "1", "data");

    m.same("data_is_word", "data", "word");
    m.same("data_is_head", "data", "head");
    m.assert(
        "in_order",
        "tracked & ahead == 0 -> data_is_word",
        "The n-th word pushed is the n-th taken, unchanged, for every n.",
    );
    m.assert(
        "none_lost",
        "tracked -> ahead < count",
        "A word that is pushed stays until it is taken.",
    );
    m.assert(
        "occupancy",
        &format!("count == pushes - pops & count <= {depth}"),
        "It holds what is pushed and not taken: none is lost, and none is taken twice.",
    );
    m.assert(
        "head_stays",
        "waits -> any(count) & data_is_head",
        "The word that is offered stays until it is taken.",
    );
    m.invariant(
        "ring",
        &format!(
            "read_pointer < {depth} & write_pointer < {depth} & (read_pointer + count == \
             write_pointer | read_pointer + count == write_pointer + {depth})"
        ),
        "",
    );
    m.invariant(
        "place",
        &format!(
            "tracked -> slot < {depth} & (read_pointer + ahead == slot | read_pointer + ahead == \
             slot + {depth})"
        ),
        "",
    );
    let slot = m.named("slot");
    let kept = m.mem_read_async(mem, slot);
    m.name(kept, "kept_word");
    m.same("kept_is_word", "kept_word", "word");
    m.invariant("kept", "tracked -> kept_is_word", "");
    written_by_pushes(m, mem, depth, width);
    m.cover("fills", &format!("count == {depth}"), "The FIFO is full.");
    m.cover("passes", "leaves & ahead == 0", "A symbolic word passes.");
}

/// What a word of a memory is changed by.
fn written_by_pushes(m: &mut ModuleBuilder, mem: MemId, depth: u32, width: u32) {
    m.free("any_slot", bits_for(depth - 1));
    let slot = m.named("any_slot");
    let stored = m.mem_read_async(mem, slot);
    m.name(stored, "stored");
    let was_stored = m.ghost_reg("was_stored", width);
    m.ghost_next(was_stored, "1", "stored");
    let was_pushed = m.ghost_reg("was_pushed", 1);
    m.ghost_next(was_pushed, "1", "push & write_pointer == any_slot");
    let seen = m.ghost_reg("seen", 1);
    m.ghost_next(seen, "1", "1");
    m.same_or_x("stored_is_same", "stored", "was_stored");
    m.assert(
        "written_by_pushes",
        &format!("seen & any_slot < {depth} & ~was_pushed -> stored_is_same"),
        "A word of the memory changes when one is pushed to its place, and at no other time.",
    );
}
