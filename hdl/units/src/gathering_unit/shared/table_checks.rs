//! Checks of the halves of the MVoxel feature table.

use potamoi_netlist::ModuleBuilder;

use crate::data_checks::{Held, held_without_enable};

/// Checks of a table that is written by `write` and read where the formula `read` holds, and whose
/// half `done` frees.
pub(crate) fn table_checks(m: &mut ModuleBuilder, read: &str) {
    let register = "half_of_words".to_owned();
    held_without_enable(
        m,
        &[Held {
            register,
            enable: read,
        }],
    );
    m.assume(
        "reads_loaded",
        &format!("{read} -> is_loaded"),
        "Rows are read only of a half that is loaded.",
    );
    m.assume(
        "frees_loaded",
        "done -> is_loaded",
        "Only a loaded half is freed.",
    );
    m.assert(
        "halves_apart",
        &format!("write & {read} -> write_half != read_half"),
        "No half is written while it is read.",
    );
    m.assert(
        "none_overwritten",
        "write -> if(write_half, ~loaded_1, ~loaded_0)",
        "A loaded half is not written until it is freed.",
    );
    m.invariant(
        "halves_in_turn",
        "(loaded_0 != loaded_1) == (read_half != write_half)",
        "",
    );
    m.invariant("read_half_is_first", "loaded_0 | loaded_1 -> is_loaded", "");
    m.cover(
        "both_loaded",
        "loaded_0 & loaded_1",
        "Both halves are loaded.",
    );
    m.cover(
        "written_and_read",
        &format!("write & {read}"),
        "A half is written while the other one is read.",
    );
}
