//! Mutants of the SoC top.

use crate::Mutant;

const BUS: &str = "npu_axi_lite.v";
const REGISTERS: &str = "npu_registers.v";
const JOB: &str = "npu_job.v";
const GATE: &str = "npu_packet_gate.v";
const TOP_FILE: &str = "potamoi_npu_ext.v";

pub(crate) const TOP: [Mutant; 45] = [
    [
        "bus.write_response_stays",
        BUS,
        "(~(s_axil_bvalid & s_axil_bready))",
        "(~s_axil_bvalid)",
    ],
    [
        "bus.read_response_stays",
        BUS,
        "reads = s_axil_arvalid & can_read;",
        "reads = s_axil_arvalid;",
    ],
    [
        "bus.writes_answered",
        BUS,
        "~(has_data | s_axil_bvalid)",
        "~s_axil_bvalid",
    ],
    [
        "bus.reads_answered",
        BUS,
        "reads = s_axil_arvalid & can_read;",
        "reads = s_axil_arvalid;",
    ],
    [
        "bus.written_as_offered",
        BUS,
        "write_strobe <= s_axil_wstrb;",
        "write_strobe <= {s_axil_wstrb[3:1], 1'b1};",
    ],
    [
        "bus.answered_as_given",
        BUS,
        "write_error ? 2'd2",
        "write_error ? 2'd3",
    ],
    [
        "registers.read_as_written",
        REGISTERS,
        "(gu_mode_vertices & (~write_mask[1:0])) | written_ones[1:0];",
        "written_ones[1:0];",
    ],
    [
        "registers.none_lost",
        REGISTERS,
        "(irq_status_gu_done & (~(irq_status_written & written_ones[0]))) |\n          irq_status_gu_done_set;",
        "(irq_status_gu_done | irq_status_gu_done_set) & (~(irq_status_written & written_ones[0]));",
    ],
    [
        "registers.events_stay",
        REGISTERS,
        "(irq_status_gu_done & (~(irq_status_written & written_ones[0])))",
        "1'b0",
    ],
    [
        "registers.events_clear",
        REGISTERS,
        "(irq_status_gu_done & (~(irq_status_written & written_ones[0])))",
        "irq_status_gu_done",
    ],
    [
        "gu_job.packets_add_up",
        JOB,
        "(left - 32'd1)",
        "(left - 32'd2)",
    ],
    [
        "gu_job.done_is_complete",
        JOB,
        "(~(is_open | any_left))",
        "(~is_open)",
    ],
    ["gu_job.begins_at_rest", JOB, "(~running) & idle", "idle"],
    [
        "vu_job.packets_add_up",
        JOB,
        "(left - 32'd1)",
        "(left - 32'd2)",
    ],
    [
        "vu_job.done_is_complete",
        JOB,
        "(~(is_open | any_left))",
        "(~is_open)",
    ],
    ["vu_job.begins_at_rest", JOB, "(~running) & idle", "idle"],
    [
        "rit_gate.closed_passes_nothing",
        GATE,
        "m_tvalid = open & s_tvalid",
        "m_tvalid = s_tvalid",
    ],
    [
        "rit_gate.passes_at_both_sides",
        GATE,
        "m_tvalid = open & s_tvalid",
        "m_tvalid = s_tvalid",
    ],
    [
        "mft_gate.closed_passes_nothing",
        GATE,
        "m_tvalid = open & s_tvalid",
        "m_tvalid = s_tvalid",
    ],
    [
        "mft_gate.passes_at_both_sides",
        GATE,
        "m_tvalid = open & s_tvalid",
        "m_tvalid = s_tvalid",
    ],
    [
        "vec_gate.closed_passes_nothing",
        GATE,
        "m_tvalid = open & s_tvalid",
        "m_tvalid = s_tvalid",
    ],
    [
        "vec_gate.passes_at_both_sides",
        GATE,
        "m_tvalid = open & s_tvalid",
        "m_tvalid = s_tvalid",
    ],
    [
        "rit_gate.open_passes_all",
        GATE,
        "m_tvalid = open & s_tvalid",
        "m_tvalid = s_tvalid & (|left[30:0])",
    ],
    [
        "rit_gate.open_for_the_job",
        GATE,
        "start ? packets",
        "start ? {1'b0, packets[30:0]}",
    ],
    [
        "mft_gate.open_passes_all",
        GATE,
        "m_tvalid = open & s_tvalid",
        "m_tvalid = s_tvalid & (|left[30:0])",
    ],
    [
        "mft_gate.open_for_the_job",
        GATE,
        "start ? packets",
        "start ? {1'b0, packets[30:0]}",
    ],
    [
        "vec_gate.open_passes_all",
        GATE,
        "m_tvalid = open & s_tvalid",
        "m_tvalid = s_tvalid & (|left[30:0])",
    ],
    [
        "vec_gate.open_for_the_job",
        GATE,
        "start ? packets",
        "start ? {1'b0, packets[30:0]}",
    ],
    [
        "gu_job.begun_or_refused",
        JOB,
        "(|packets)",
        "(|packets[30:0])",
    ],
    [
        "vu_job.begun_or_refused",
        JOB,
        "(|packets)",
        "(|packets[30:0])",
    ],
    [
        "registers.read_as_it_is",
        REGISTERS,
        "({32{vu_busy_read}} & vu_busy)",
        "({32{vu_busy_read}} & {1'b0, vu_busy[30:0]})",
    ],
    [
        "gu_counters_of_snapshot",
        TOP_FILE,
        "gu_stall_mft_shown <= gu_stat_stall_mft;",
        "gu_stall_mft_shown <= gu_stat_stall_rit;",
    ],
    [
        "vu_counters_of_snapshot",
        TOP_FILE,
        "vu_busy_shown <= vu_stat_busy;",
        "vu_busy_shown <= vu_stat_vectors;",
    ],
    [
        "gu_done_is_closed",
        TOP_FILE,
        "(rit_gate_is_open | mft_gate_is_open)",
        "(rit_gate_is_open)",
    ],
    [
        "vu_done_is_closed",
        TOP_FILE,
        "(vec_gate_is_open),",
        "(1'b0),",
    ],
    [
        "gu_error_is_new",
        TOP_FILE,
        "gu_error_rises = |(gu_stat_errors &",
        "gu_error_rises = |(gu_stat_errors[7:0] &",
    ],
    [
        "vu_error_is_new",
        TOP_FILE,
        "vu_errors_before <= vu_stat_errors;",
        "vu_errors_before <= 3'd0;",
    ],
    [
        "gu_packets_as_ordered",
        TOP_FILE,
        ".gu_left                     (gu_job_packets_left)",
        ".gu_left                     (vu_job_packets_left)",
    ],
    [
        "vu_packets_as_ordered",
        TOP_FILE,
        ".vu_left                     (vu_job_packets_left)",
        ".vu_left                     (gu_job_packets_left)",
    ],
    [
        "gu_settings_as_ordered",
        TOP_FILE,
        "cfg_segments <= registers_gu_mode_segments;",
        "cfg_segments <= 7'd1;",
    ],
    [
        "gu_flags_as_raised",
        TOP_FILE,
        ".gu_errors_gap_in_beat       (gu_stat_errors[4])",
        ".gu_errors_gap_in_beat       (gu_stat_errors[3])",
    ],
    [
        "vu_flags_as_raised",
        TOP_FILE,
        ".vu_errors_torn_lane         (vu_stat_errors[2])",
        ".vu_errors_torn_lane         (vu_stat_errors[1])",
    ],
    [
        "irq_of_events",
        TOP_FILE,
        "(registers_irq_status_gu_error & registers_irq_enable_gu_error) |",
        "(registers_irq_status_gu_error & registers_irq_enable_gu_done) |",
    ],
    [
        "registers.refused_elsewhere",
        REGISTERS,
        "vu_stall_out_read = read_index == 10'd100;",
        "vu_stall_out_read = {read_index[9:1], 1'b0} == 10'd100;",
    ],
    [
        "rit_step_by_segments",
        TOP_FILE,
        "(s_axis_rit_tuser ? 7'd1 : cfg_segments)",
        "(s_axis_rit_tuser ? 7'd1 : {1'b0, cfg_segments[5:0]})",
    ],
];
