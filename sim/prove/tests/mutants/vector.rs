//! Mutants of the vector unit.

use crate::Mutant;

const VU: &str = "vector_unit.v";
const VFIFO: &str = "result_fifo.v";

pub(crate) const VECTOR: [Mutant; 16] = [
    ["balance", VU, "if (accept ^ pop)", "if (accept)"],
    ["credit", VU, "in_flight < 5'd18", "in_flight < 5'd19"],
    [
        "idle_is_empty",
        VU,
        "in_flight <= accept ? (in_flight + 5'd1)",
        "in_flight <= accept ? in_flight",
    ],
    [
        "valid_stays",
        VFIFO,
        "assign valid = |count;",
        "assign valid = count[0];",
    ],
    [
        "beat_stays",
        VFIFO,
        "assign data = mem_out;",
        "assign data = push ? push_data : mem_out;",
    ],
    [
        "never_stuck",
        VU,
        "may_accept = room;",
        "may_accept = 1'b0;",
    ],
    [
        "vectors_count",
        VU,
        "(stat_vectors + 32'd1)",
        "(stat_vectors + 32'd2)",
    ],
    [
        "busy_count",
        VU,
        "if (cfg_clear | accept | moving) stat_busy",
        "if (cfg_clear | moving) stat_busy",
    ],
    [
        "stall_out_count",
        VU,
        "(s_axis_vec_tvalid & (~room))",
        "(s_axis_vec_tvalid & (~room) & (~m_axis_vec_tready))",
    ],
    [
        "fifo.has_room",
        VU,
        "in_flight < 5'd18",
        "in_flight < 5'd19",
    ],
    [
        "fifo.has_word",
        VU,
        "pop = fifo_valid & m_axis_vec_tready",
        "pop = m_axis_vec_tready",
    ],
    [
        "fifo.in_order",
        VFIFO,
        "mem[write_pointer] <= ",
        "mem[read_pointer] <= ",
    ],
    ["fifo.none_lost", VFIFO, "(count - 5'd1)", "(count - 5'd2)"],
    ["fifo.occupancy", VFIFO, "if (push ^ pop)", "if (push)"],
    [
        "fifo.head_stays",
        VFIFO,
        "assign data = mem_out;",
        "assign data = push ? push_data : mem_out;",
    ],
    [
        "fifo.written_by_pushes",
        VFIFO,
        "if (push) mem[write_pointer]",
        "mem[write_pointer]",
    ],
];
