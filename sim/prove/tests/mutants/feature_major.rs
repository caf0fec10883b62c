//! Mutants of the feature-major unit, of the properties that are stated of it anew.

use crate::Mutant;

const GU: &str = "gathering_unit.v";
const FIFO: &str = "feature_fifo.v";
const MFT: &str = "mft.v";

pub(crate) const UNIT: [Mutant; 16] = [
    [
        "never_stuck",
        GU,
        "may_start = credit & mft_is_loaded",
        "may_start = 1'b0",
    ],
    [
        "round_serves",
        "bank_arbiter.v",
        "assign grants = wants & same_line",
        "assign grants = wants & ~same_line",
    ],
    [
        "lane_of_group[].lane[].gather_lane.asks",
        "gather_lane.v",
        "pending & (bank == 4'd0)",
        "1'b0",
    ],
    [
        "counters_saturate",
        GU,
        "(&stat_busy) ? stat_busy :",
        "(&stat_busy) ? ~stat_busy : ~stat_busy |",
    ],
    [
        "mft.half_of_words_held",
        MFT,
        "if (|read) half_of_words",
        "half_of_words",
    ],
    ["balance", GU, "if (beat_start ^ pop)", "if (beat_start)"],
    [
        "credit",
        GU,
        "BEATS_IN_FLIGHT = 3'd5",
        "BEATS_IN_FLIGHT = 3'd6",
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
        "no_cycle_lost",
        GU,
        "(fire & (~step_new))",
        "(fire & (~step_new) & (~pop))",
    ],
    [
        "entries_count",
        GU,
        "{12'd0, entries_of_group}",
        "{12'd0, ~entries_of_group}",
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
        "may_start = credit & mft_is_loaded",
        "may_start = credit",
    ],
    [
        "mft.halves_apart",
        MFT,
        "assign is_loaded = read_half ? loaded_1 : loaded_0",
        "assign is_loaded = 1'b1",
    ],
    [
        "mft.none_overwritten",
        MFT,
        "write_ready = ~(write_half ? loaded_1 : loaded_0)",
        "write_ready = 1'b1",
    ],
];
