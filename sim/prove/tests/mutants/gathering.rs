//! Mutants of the gathering unit.

use crate::Mutant;

const GU: &str = "gathering_unit.v";
const MFT: &str = "mft.v";
const RIT: &str = "rit_buffer.v";
const FIFO: &str = "feature_fifo.v";

pub(crate) const GATHERING: [Mutant; 36] = [
    [
        "counters_saturate",
        GU,
        "(&stat_busy) ? stat_busy :",
        "(&stat_busy) ? ~stat_busy : ~stat_busy |",
    ],
    [
        "s2_end_held",
        GU,
        "if (completes) begin",
        "s2_end <= s1_end;\n    if (completes) begin",
    ],
    [
        "s2_keep_held",
        GU,
        "if (completes) begin",
        "s2_keep <= s1_keep;\n    if (completes) begin",
    ],
    [
        "s2_slot_held",
        GU,
        "if (completes) begin",
        "s2_slot <= s1_slot;\n    if (completes) begin",
    ],
    [
        "weight_total0_held",
        GU,
        "if (s1_valid) weight_total0",
        "weight_total0",
    ],
    [
        "mft.half_of_words_held",
        MFT,
        "if (read) half_of_words",
        "half_of_words",
    ],
    [
        "mft.reads_asked",
        MFT,
        "read & read_keep & row0_in_range",
        "read & row0_in_range",
    ],
    ["balance", GU, "if (group_start ^ pop)", "if (group_start)"],
    [
        "credit",
        GU,
        "GROUPS_IN_FLIGHT = 3'd4",
        "GROUPS_IN_FLIGHT = 3'd5",
    ],
    [
        "idle_is_empty",
        GU,
        "assign idle = ~((|in_flight) | ",
        "assign idle = ~(",
    ],
    [
        "valid_stays",
        FIFO,
        "assign valid = |count;",
        "assign valid = count[0];",
    ],
    [
        "beat_stays",
        FIFO,
        "assign data = mem_out;",
        "assign data = push ? push_data : mem_out;",
    ],
    [
        "never_stuck",
        GU,
        "may_start = credit & mft_is_loaded",
        "may_start = 1'b0",
    ],
    [
        "no_cycle_lost",
        GU,
        "(stalled & credit & (~mft_is_loaded))",
        "(stalled & credit & (~mft_is_loaded) & (~m_axis_feat_tready))",
    ],
    [
        "entries_count",
        GU,
        "{16'd0, entries_of_group}",
        "{16'd0, ~entries_of_group}",
    ],
    [
        "rit.settings_stay",
        GU,
        "(cfg_vertices),",
        "(cfg_vertices ^ {1'b0, fire}),",
    ],
    [
        "rit.segments_built",
        GU,
        "(cfg_segments),",
        "(cfg_segments + 7'd1),",
    ],
    [
        "rit.takes_offered",
        GU,
        "(fire),",
        "(fire | mft_is_loaded),",
    ],
    [
        "rit.groups_in_order",
        RIT,
        "(read_group + 4'd1);",
        "(read_group + 4'd2);",
    ],
    [
        "rit.reads_written",
        RIT,
        "readable = (read_row_now < end_row)",
        "readable = (read_row_now <= end_row)",
    ],
    [
        "rit.none_overwritten",
        RIT,
        "write_ready = ~(write_half ? closed_1 : closed_0);",
        "write_ready = 1'b1;",
    ],
    [
        "rit.never_stuck",
        RIT,
        "some_bytes ? all_groups : (full_groups + 4'd1)",
        "some_bytes ? all_groups : full_groups",
    ],
    [
        "rit.segment_in_range",
        RIT,
        "(next_segment < cfg_segments)",
        "(next_segment <= cfg_segments)",
    ],
    [
        "rit.vertices_in_order",
        RIT,
        "q_first <= read_first;",
        "q_first <= read_last;",
    ],
    [
        "mft.reads_loaded",
        GU,
        "may_start = credit & mft_is_loaded",
        "may_start = credit",
    ],
    [
        "mft.frees_loaded",
        GU,
        "release_table = fire & rit_p_last",
        "release_table = rit_p_last",
    ],
    [
        "mft.halves_apart",
        "mft.v",
        "write_ready = ~(write_half ? loaded_1 : loaded_0);",
        "write_ready = 1'b1;",
    ],
    [
        "mft.none_overwritten",
        "mft.v",
        "write_ready = ~(write_half ? loaded_1 : loaded_0);",
        "write_ready = 1'b1;",
    ],
    [
        "results.has_room",
        GU,
        "GROUPS_IN_FLIGHT = 3'd4",
        "GROUPS_IN_FLIGHT = 3'd5",
    ],
    [
        "results.has_word",
        GU,
        "pop = results_valid & m_axis_feat_tready",
        "pop = m_axis_feat_tready",
    ],
    [
        "results.in_order",
        FIFO,
        "mem[write_pointer] <= ",
        "mem[read_pointer] <= ",
    ],
    [
        "results.none_lost",
        FIFO,
        "(count - 3'd1)",
        "(count - 3'd2)",
    ],
    ["results.occupancy", FIFO, "if (push ^ pop)", "if (push)"],
    [
        "results.head_stays",
        FIFO,
        "assign data = mem_out;",
        "assign data = push ? push_data : mem_out;",
    ],
    [
        "results.written_by_pushes",
        FIFO,
        "if (push) mem[write_pointer]",
        "mem[write_pointer]",
    ],
    // The unit assumes what the buffer says of its stream: only the assumption itself can be left out.
    [
        "rit.regular",
        GU,
        "potamoi_assume check_regular",
        "potamoi_cover check_regular",
    ],
];
