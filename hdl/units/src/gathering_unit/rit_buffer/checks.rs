//! Checks of the RIT buffer: a symbolic group is written once, read once a pass and in order, and not
//! overwritten before.

use potamoi_formats::rit::Vertices;
use potamoi_netlist::ModuleBuilder;

use super::by_index::by_index;
use super::invariants::{ownership, positions, vertices};
use crate::gathering_unit::shared::rit_shape::Shape;

/// Checks of the buffer, for streams that raise no flag.
pub(crate) fn rit_buffer_checks(m: &mut ModuleBuilder, shape: &Shape, segments: u32) {
    m.begin_checks();
    environment(m, segments);
    tables(m, shape);
    symbolic_group(m, shape);
    properties(m, shape);
    positions(m, shape);
    ownership(m);
    if !shape.whole_cells {
        vertices(m, shape);
    }
    covers(m, shape);
}

fn environment(m: &mut ModuleBuilder, segments: u32) {
    let vertices_past = m.ghost_reg("vertices_past", 2);
    m.ghost_next(vertices_past, "1", "cfg_vertices");
    let segments_past = m.ghost_reg("segments_past", 7);
    m.ghost_next(segments_past, "1", "cfg_segments");
    m.assume(
        "regular",
        "~any(errors)",
        "The stream raises no flag: full beats, whole entries, halves that suffice.",
    );
    m.assume(
        "settings_stay",
        "is_empty | cfg_vertices == vertices_past & cfg_segments == segments_past",
        "Settings change only while the buffer is empty.",
    );
    m.assume(
        "segments_built",
        &format!("is_empty & ~s_axis_rit_tvalid | cfg_segments > 0 & cfg_segments <= {segments}"),
        "The segments are as many as the unit is built for.",
    );
    m.assume(
        "takes_offered",
        "p_take -> p_valid",
        "A vertex is taken only if there is one.",
    );
}

/// For each entry size: values that the text has as tables.
fn tables(m: &mut ModuleBuilder, shape: &Shape) {
    let by_size = |value: &dyn Fn(Vertices) -> String| {
        let fallback = shape.vertices.last();
        let of = |v: &Vertices| shape.vertices.iter().find(|own| *own == v).or(fallback);
        let all: Vec<String> = Vertices::ALL
            .iter()
            .map(|v| of(v).map_or_else(|| "0".to_owned(), |v| value(*v)))
            .collect();
        by_index("cfg_vertices", &all)
    };
    let size = |v: Vertices| shape.ports * shape.entry_halfwords(v);
    let groups = by_size(&|v| shape.groups(v).to_string());
    m.ghost("groups_a_row", &groups);
    // Full groups of a row before each beat.
    let before_beat = by_size(&|v| {
        let all: Vec<String> = (0..shape.phases)
            .map(|beat| (beat * shape.lanes / size(v)).to_string())
            .collect();
        by_index("write_phase", &all)
    });
    m.ghost("groups_written", &before_beat);
    // Beats of the picked group.
    for (name, last) in [("pick_from", 0), ("pick_to", 1)] {
        let beat = by_size(&|v| {
            let all: Vec<String> = (0..shape.groups(v))
                .map(|group| (((group + last) * size(v) - last) / shape.lanes).to_string())
                .collect();
            by_index("pick_group", &all)
        });
        if name == "pick_from" {
            m.free("pick_half", 1);
            m.free("pick_row", shape.row_index_bits());
            m.free("pick_group", shape.group_ty().width);
        }
        m.ghost(name, &beat);
    }
}

/// Whether the picked group is written, and whether it is read in this pass.
fn symbolic_group(m: &mut ModuleBuilder, shape: &Shape) {
    let step = if shape.whole_cells {
        "read_fire"
    } else {
        "read_step"
    };
    m.ghost("pick_is_group", "pick_group < groups_a_row");
    m.ghost(
        "at_pick",
        "read_half == pick_half & read_row == pick_row & read_group == pick_group",
    );
    m.ghost("pick_closed", "if(pick_half, closed_1, closed_0)");
    m.ghost("pick_end_row", "if(pick_half, end_row_1, end_row_0)");
    m.ghost("pick_end_group", "if(pick_half, end_group_1, end_group_0)");
    m.ghost("pick_keep", "if(pick_half, last_keep_1, last_keep_0)");
    m.ghost("pick_freed", "if(pick_half, release_1, release_0)");
    m.ghost(
        "pick_ends",
        "pick_row == pick_end_row & pick_group + 1 == pick_end_group",
    );
    m.ghost(
        "pick_before_end",
        "pick_row < pick_end_row | pick_row == pick_end_row & pick_group < pick_end_group",
    );
    m.ghost(
        "write_in_pick",
        "write_accept & some_bytes & write_half == pick_half & write_row == pick_row",
    );
    m.ghost(
        "pick_behind_reader",
        "read_half == pick_half & (pick_row < read_row | pick_row == read_row & pick_group < \
         read_group)",
    );
    m.ghost(
        "pick_behind_writer",
        "write_half == pick_half & (pick_row < write_row | pick_row == write_row & pick_to < \
         write_phase)",
    );
    m.ghost("read_closed", "if(read_half, closed_1, closed_0)");
    m.ghost(
        "read_ends_now",
        "if(read_half, closed_1, closed_0) & ~more_groups",
    );
    let written = m.ghost_reg("pick_written", 1);
    m.ghost("pick_completes", "write_in_pick & write_phase == pick_to");
    m.ghost_next(written, "pick_completes | pick_freed", "~pick_freed");
    let read = m.ghost_reg("pick_read", 1);
    let passed = "read_leave_half & read_half == pick_half";
    let reads = format!("{step} & at_pick");
    m.ghost_next(
        read,
        &format!("{passed} | {reads}"),
        &format!("~({passed})"),
    );
}

fn properties(m: &mut ModuleBuilder, shape: &Shape) {
    m.assert(
        "groups_in_order",
        "pick_is_group -> pick_read == pick_behind_reader",
        "In each pass over a half, every group is read once, and in order.",
    );
    m.assert(
        "reads_written",
        &format!(
            "{} & at_pick & pick_is_group -> pick_written | pick_closed & pick_ends & pick_keep != {}",
            "read_fire",
            (1u32 << shape.ports) - 1
        ),
        "A group is read only after all its beats are written, but for entries past the end.",
    );
    m.assert(
        "none_overwritten",
        "write_in_pick & pick_is_group & pick_from <= write_phase & write_phase <= pick_to -> \
         ~pick_written",
        "A group is not overwritten before its half is freed.",
    );
    m.assert(
        "never_stuck",
        "read_closed -> readable",
        "A closed half always has a group to read, until it is freed.",
    );
    m.assert(
        "segment_in_range",
        "is_empty | read_segment < cfg_segments",
        "A half is read once for every segment at most.",
    );
}

fn covers(m: &mut ModuleBuilder, shape: &Shape) {
    m.cover("begins", "read_fire", "A group is read.");
    m.cover(
        "reads_open_half",
        "read_fire & ~read_closed",
        "A group is read from the half that is being written.",
    );
    m.cover(
        "picked_group_read",
        "pick_read",
        "The symbolic group is read.",
    );
    m.cover(
        "second_pass",
        "any(read_segment) & read_fire",
        "A half is read again for another segment.",
    );
    if !shape.whole_cells && shape.vertices.contains(&Vertices::Eight) {
        m.cover(
            "last_of_eight",
            "p_valid & due == 7",
            "The eighth vertex is offered.",
        );
    }
}
