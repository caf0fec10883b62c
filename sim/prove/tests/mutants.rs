//! Every property can fail: each is shown to on a mutant of the preset `small`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::collections::BTreeSet;

use potamoi_formats::config::{Config, PRESETS};
use potamoi_netlist::CheckKind;
use potamoi_prove::{Outcome, Tools, Unit, units};

/// Cycles of the runs. A mutant that fails later is found by induction.
const CYCLES: u32 = 12;
const GU: &str = "gathering_unit.v";
const RIT: &str = "rit_buffer.v";
const FIFO: &str = "feature_fifo.v";
const VU: &str = "vector_unit.v";
const VFIFO: &str = "result_fifo.v";
const BUS: &str = "npu_axi_lite.v";
const REGISTERS: &str = "npu_registers.v";
const JOB: &str = "npu_job.v";
const GATE: &str = "npu_packet_gate.v";

/// A property, the file that a mutant edits, and what it replaces.
type Mutant = [&'static str; 4];

const GATHERING: [Mutant; 29] = [
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

const VECTOR: [Mutant; 16] = [
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

/// Modules that are proven alone.
const BANK: [Mutant; 1] = [[
    "holds",
    "mft_bank.v",
    "if (re) word <= mem[addr];",
    "word <= mem[addr];",
]];
const RIT_BANK: [Mutant; 1] = [[
    "holds",
    "rit_bank.v",
    "if (re) word <= mem[raddr];",
    "word <= mem[raddr];",
]];
const REDUCER: [Mutant; 1] = [["acc_held", "reducer.v", "if (valid) acc", "acc"]];
const LANE: [Mutant; 1] = [["exact_held", "vector_lane.v", "if (accept) exact", "exact"]];
const HALVES: [Mutant; 4] = [
    [
        "low_written",
        "mft_halves.v",
        "loaded[0] ? raddr : waddr",
        "loaded[0] ? raddr : (waddr ^ 9'd1)",
    ],
    [
        "low_read",
        "mft_halves.v",
        "loaded[0] ? raddr : waddr",
        "loaded[0] ? (raddr ^ 9'd1) : waddr",
    ],
    [
        "high_written",
        "mft_halves.v",
        "loaded[1] ? raddr : waddr",
        "loaded[1] ? raddr : (waddr ^ 9'd1)",
    ],
    [
        "high_read",
        "mft_halves.v",
        "loaded[1] ? raddr : waddr",
        "loaded[1] ? (raddr ^ 9'd1) : waddr",
    ],
];

const TOP: [Mutant; 22] = [
    [
        "bus.write_response_stays",
        BUS,
        "(~(s_axil_bvalid & s_axil_bready))",
        "(~s_axil_bvalid)",
    ],
    [
        "bus.read_response_stays",
        BUS,
        "reads = s_axil_arvalid & not_s_axil_rvalid;",
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
        "reads = s_axil_arvalid & not_s_axil_rvalid;",
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
];

fn small() -> Vec<Unit> {
    let (_, text) = PRESETS.iter().find(|(name, _)| *name == "small").unwrap();
    units(&Config::from_toml(text, "small").unwrap()).unwrap()
}

fn sets() -> Vec<(Unit, &'static [Mutant])> {
    let of = |unit: Unit| {
        let mutants: &[Mutant] = match unit.name.as_str() {
            "gathering_unit" => &GATHERING,
            "mft_bank" => &BANK,
            "mft_halves" => &HALVES,
            "reducer" => &REDUCER,
            "rit_bank" => &RIT_BANK,
            "vector_unit" => &VECTOR,
            "vector_lane" => &LANE,
            "potamoi_npu_ext" => &TOP,
            other => panic!("{other} has no mutants"),
        };
        (unit, mutants)
    };
    small().into_iter().map(of).collect()
}

#[test]
fn every_property_has_a_mutant() {
    for (unit, mutants) in sets() {
        let all = unit.checks();
        let properties = all.iter().filter(|c| c.kind == CheckKind::Assert);
        let properties: BTreeSet<&str> = properties.map(|c| c.path.as_str()).collect();
        let shown: BTreeSet<&str> = mutants.iter().map(|[name, ..]| *name).collect();
        assert_eq!(properties, shown, "{}", unit.name);
    }
}

fn dies(tools: &Tools, unit: &Unit, [property, file, from, to]: Mutant) -> Outcome {
    let mut mutant = unit.clone();
    mutant.edits.push([file, from, to].map(str::to_owned));
    let found = mutant.look(tools, property, CYCLES);
    let found = found.unwrap_or_else(|e| panic!("{property}: {e}"));
    assert_ne!(
        found,
        Outcome::Proven,
        "{property} holds of `{to}` in {file}"
    );
    found
}

#[test]
fn some_mutants_fail() {
    let tools = Tools::find().unwrap_or_else(|e| panic!("{e}"));
    let (gathering, of_gathering) = sets().swap_remove(0);
    for mutant in of_gathering
        .iter()
        .filter(|m| ["mft.halves_apart", "rit.never_stuck"].contains(&m[0]))
    {
        let found = dies(&tools, &gathering, *mutant);
        assert!(matches!(found, Outcome::Failed(_)), "{mutant:?}: {found:?}");
    }
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_property_fails_on_its_mutant() {
    let tools = Tools::find().unwrap_or_else(|e| panic!("{e}"));
    for (unit, mutants) in sets() {
        for mutant in mutants {
            let found = dies(&tools, &unit, *mutant);
            println!("{} {}: {found:?}", unit.name, mutant[0]);
        }
    }
}
