//! The bench of the top passes, and fails on small changes of the top.

use std::path::Path;
use std::process::Command;

use potamoi_formats::config::Config;

use super::{lay, run};

/// Changes of a file's text, which has `from` once, and what the bench says of it, in part.
const MUTANTS: &[[&str; 5]] = &[
    [
        "a gate that never closes",
        "npu_packet_gate.v",
        "wire open = |left;",
        "wire open = 1'b1;",
        "FAIL",
    ],
    [
        "a gate a packet too late",
        "npu_packet_gate.v",
        "step_wide) ? 32'd0",
        "step_wide) ? 32'd1",
        "FAIL",
    ],
    [
        "segments of the table not counted",
        "potamoi_npu_ext.v",
        "s_axis_rit_tuser ? 7'd1 : cfg_segments)",
        "7'd1)",
        "FAIL",
    ],
    [
        "tuser not counted",
        "potamoi_npu_ext.v",
        "s_axis_rit_tuser ? 7'd1 : cfg_segments)",
        "cfg_segments)",
        "FAIL",
    ],
    [
        "settings that follow software",
        "potamoi_npu_ext.v",
        "if (gu_job_begins) begin",
        "if (1'b1) begin",
        "FAIL",
    ],
    [
        "done before the unit is idle",
        "npu_job.v",
        "(~(is_open | any_left)) & idle",
        "(~is_open)",
        "FAIL",
    ],
    [
        "a start of no packets",
        "npu_job.v",
        "idle & (|packets)",
        "idle",
        "FAIL",
    ],
    [
        "an event that is not cleared",
        "npu_registers.v",
        "(irq_status_gu_done & (~(irq_status_written & written_ones[0])))",
        "irq_status_gu_done",
        "FAIL",
    ],
    [
        "strobes ignored",
        "npu_registers.v",
        "{{8{write_strobe[3]}}, {8{write_strobe[2]}}",
        "{{8{1'b1}}, {8{write_strobe[2]}}",
        "FAIL: register",
    ],
    [
        "a write to a status accepted",
        "npu_axi_lite.v",
        "write_error ? 2'd2 : 2'd0",
        "2'd0",
        "response 0, expected 2",
    ],
    [
        "a response taken back",
        "npu_axi_lite.v",
        "s_axil_rvalid <= (s_axil_rvalid & (~(s_axil_rvalid & s_axil_rready)))",
        "s_axil_rvalid <= 1'b0",
        "a further read could enter before",
    ],
    [
        "ready in reset",
        "potamoi_npu_ext.v",
        "s_axis_vec_tready = rst_n & ",
        "s_axis_vec_tready = 1'b1 | ",
        "s_axis_vec_tready is 1 in reset",
    ],
    [
        "no snapshot",
        "potamoi_npu_ext.v",
        "gu_entries_shown <= gu_stat_entries",
        "gu_entries_shown <= gu_entries_shown",
        "FAIL: register",
    ],
    [
        "counters that are not cleared",
        "potamoi_npu_ext.v",
        ".cfg_clear         (registers_control_clear)",
        ".cfg_clear         (1'b0)",
        "FAIL: register",
    ],
    [
        "an interrupt that is not enabled",
        "potamoi_npu_ext.v",
        "irq <= (registers_irq_status_gu_done & registers_irq_enable_gu_done)",
        "irq <= 1'b0",
        "no interrupt",
    ],
    [
        "a data bit of a write lost",
        "npu_axi_lite.v",
        "write_data <= s_axil_wdata",
        "write_data <= {1'b0, s_axil_wdata[30:0]}",
        "FAIL: register",
    ],
];

/// Runs the bench of the top: without gaps, and with many.
fn simulate(folder: &Path) -> (bool, String) {
    run(Command::new("make")
        .arg("-C")
        .arg(folder.join("sim"))
        .args(["UNITS=potamoi_npu_ext", "RUNS=0:1 60:3"]))
}

/// One of each file, and of each kind of check.
#[test]
fn the_bench_of_the_top_passes_and_fails_on_some_mutants() {
    fails_on(MUTANTS.iter().step_by(6));
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn the_bench_of_the_top_fails_on_all_its_mutants() {
    fails_on(MUTANTS.iter());
}

fn fails_on(mutants: impl Iterator<Item = &'static [&'static str; 5]>) {
    let folder = tempfile::tempdir().unwrap();
    lay(&Config::preset("small").unwrap(), folder.path());
    let (well, said) = simulate(folder.path());
    assert!(well && said.matches("PASS: ").count() == 2, "{said}");
    assert!(!said.to_lowercase().contains("warning"), "{said}");
    for [what, file, from, to, expected] in mutants {
        let path = folder.path().join("potamoi_npu_ext").join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.matches(from).count(), 1, "{what}: {from}: {text}");
        std::fs::write(&path, text.replace(from, to)).unwrap();
        let (well, said) = simulate(folder.path());
        assert!(
            !well && said.contains("FAIL") && said.contains(expected),
            "{what}: {said}"
        );
        std::fs::write(&path, text).unwrap();
    }
}
