//! Invariants of the RIT buffer, with which its properties are inductive.

use potamoi_formats::rit::Vertices;
use potamoi_formats::timing::RitStage;
use potamoi_netlist::ModuleBuilder;

use super::by_index::by_index;
use crate::gathering_unit::shared::rit_reader::prefix;
use crate::gathering_unit::shared::rit_shape::Shape;

/// The positions of writer and reader, and the ends of the halves.
pub(super) fn positions(m: &mut ModuleBuilder, shape: &Shape) {
    let rows = shape.rows;
    for h in 0..2 {
        let writes_here = if h == 0 { "~write_half" } else { "write_half" };
        m.invariant(
            &format!("end_{h}_follows_writer"),
            &format!(
                "closed_{h} | if({writes_here}, end_row_{h} == write_row & end_group_{h} == \
                 groups_written, ~any(end_row_{h}) & ~any(end_group_{h}))"
            ),
            "",
        );
        m.invariant(
            &format!("end_{h}_in_range"),
            &format!(
                "(end_row_{h} < {rows} | end_row_{h} == {rows} & ~any(end_group_{h})) & end_group_{h} \
                 <= groups_a_row"
            ),
            "",
        );
        m.invariant(
            &format!("closed_{h}_has_groups"),
            &format!("closed_{h} -> any(end_row_{h}) | any(end_group_{h})"),
            "",
        );
        m.invariant(
            &format!("closed_{h}_is_full"),
            &format!(
                "closed_{h} & ~ends_mvoxel_{h} -> end_row_{h} == {rows} & ~any(end_group_{h}) & \
                 last_keep_{h} == {}",
                (1u32 << shape.ports) - 1
            ),
            "",
        );
    }
    m.invariant(
        "phase_in_range",
        &format!("write_phase < {}", shape.phases),
        "",
    );
    m.invariant("row_in_range", &format!("write_row < {rows}"), "");
    m.invariant("group_in_range", "read_group < groups_a_row", "");
    m.invariant(
        "waits_at_start",
        "write_ready | ~any(write_row) & ~any(write_phase) & closed_0 & closed_1",
        "",
    );
    m.ghost("read_end_row", "if(read_half, end_row_1, end_row_0)");
    m.ghost("read_end_group", "if(read_half, end_group_1, end_group_0)");
    m.invariant(
        "reader_up_to_end",
        "readable | read_row == read_end_row & read_group == read_end_group",
        "",
    );
    m.invariant(
        "written_up_to_end",
        &format!(
            "pick_is_group & pick_before_end -> pick_written | pick_closed & pick_ends & pick_keep != {}",
            (1u32 << shape.ports) - 1
        ),
        "",
    );
    m.invariant(
        "written_behind_writer",
        "pick_is_group & ~pick_closed -> pick_written == pick_behind_writer",
        "",
    );
    m.invariant(
        "unread_before_reader",
        "pick_read -> pick_behind_reader",
        "",
    );
    m.invariant(
        "unwritten_before_writer",
        "pick_written & ~pick_closed -> write_half == pick_half & (any(write_row) | any(write_phase))",
        "",
    );
}

/// Which half the reader is in, and why an earlier one is kept.
pub(super) fn ownership(m: &mut ModuleBuilder) {
    m.ghost("last_pass", "~(next_segment < cfg_segments)");
    m.ghost("amid_half", "any(write_row) | any(write_phase)");
    m.ghost(
        "oldest",
        "if(closed_0 & closed_1, write_half, if(closed_0, 0, if(closed_1, 1, write_half)))",
    );
    m.ghost(
        "oldest_goes_on",
        "if(oldest, closed_1 & ~ends_mvoxel_1 & ~streamed_1, closed_0 & ~ends_mvoxel_0 & ~streamed_0)",
    );
    m.ghost("read_in_empty", "~read_closed & ~amid_half");
    m.ghost(
        "read_streamed",
        "if(read_in_empty, write_user, if(read_half, streamed_1, streamed_0))",
    );
    m.ghost(
        "spans_both",
        "closed_0 & closed_1 & ~if(write_half, ends_mvoxel_1, ends_mvoxel_0)",
    );
    m.invariant(
        "reads_oldest",
        "read_half == oldest | read_start_half == oldest & oldest_goes_on & ~last_pass",
        "",
    );
    m.invariant(
        "start_of_mvoxel",
        "read_start_half == read_half | read_streamed | last_pass | read_start_half == oldest",
        "",
    );
    m.invariant(
        "start_before_writer",
        "read_start_half == read_half | ~read_in_empty | write_second",
        "",
    );
    m.invariant(
        "user_of_half",
        "amid_half -> write_user == if(write_half, streamed_1, streamed_0)",
        "",
    );
    m.invariant(
        "user_of_other_half",
        "write_second & if(write_half, closed_0, closed_1) -> write_user == if(write_half, streamed_0, \
         streamed_1)",
        "",
    );
    m.invariant("user_of_both", "spans_both -> streamed_0 == streamed_1", "");
    m.invariant(
        "both_suffice",
        "spans_both & ~streamed_0 & ~last_pass -> if(write_half, ends_mvoxel_0, ends_mvoxel_1)",
        "",
    );
    m.invariant(
        "second_follows",
        "if(write_half, closed_0, closed_1) -> write_second == ~if(write_half, ends_mvoxel_0, \
         ends_mvoxel_1)",
        "",
    );
    m.ghost(
        "whole_is_kept",
        "read_start_half == oldest & if(oldest, closed_1 & ~streamed_1 & (ends_mvoxel_1 | closed_0 & \
         ends_mvoxel_0), closed_0 & ~streamed_0 & (ends_mvoxel_0 | closed_1 & ends_mvoxel_1))",
    );
    m.ghost(
        "second_is_last",
        "last_pass & read_start_half != read_half & read_half == oldest & if(read_half, closed_1 & \
         ~streamed_1 & ends_mvoxel_1, closed_0 & ~streamed_0 & ends_mvoxel_0)",
    );
    m.invariant(
        "passes_over_kept",
        "~any(read_segment) | whole_is_kept | second_is_last",
        "",
    );
}

/// Vertices on their way from the banks to the issue.
pub(super) fn vertices(m: &mut ModuleBuilder, shape: &Shape) {
    let last = |v: &Vertices| (v.count() - 1).to_string();
    let fallback = shape.vertices.last().map_or_else(|| "0".to_owned(), last);
    let all: Vec<String> = Vertices::ALL
        .iter()
        .map(|v| {
            shape
                .vertices
                .iter()
                .find(|own| *own == v)
                .map_or(fallback.clone(), last)
        })
        .collect();
    m.ghost("last_vertex", &by_index("cfg_vertices", &all));
    let due = m.ghost_reg("due", 3);
    m.ghost_next(due, "p_take", "if(due == last_vertex, 0, due + 1)");
    m.assert(
        "vertices_in_order",
        "p_valid -> p_first == ~any(due) & p_last == (due == last_vertex)",
        "The vertices of a group are offered in order, from 0 to V - 1.",
    );
    m.invariant("due_in_range", "due <= last_vertex", "");
    m.invariant("vertex_of_group", "any(read_vertex) -> readable", "");
    // From the issue to the banks, each stage has the vertex after the one before it.
    let mut next = "if(p_valid, if(due == last_vertex, 0, due + 1), due)".to_owned();
    let stages: Vec<RitStage> = shape.pipeline.stages().collect();
    for stage in stages.into_iter().rev().skip(1) {
        let s = prefix(stage);
        m.ghost(&format!("{s}_due"), &next);
        m.invariant(
            &format!("{s}_in_order"),
            &format!(
                "{s}_valid -> {s}_vertex == {s}_due & {s}_first == ~any({s}_due) & {s}_last == \
                 ({s}_due == last_vertex)"
            ),
            "",
        );
        next = format!("if({s}_valid, if({s}_due == last_vertex, 0, {s}_due + 1), {s}_due)");
    }
    m.invariant("read_in_order", &format!("read_vertex == {next}"), "");
}
