//! The exponential by itself in its own bench: every operand, and faults that are found.

use std::path::Path;
use std::process::Command;

use potamoi_formats::config::{Config, ExpForm};
use potamoi_rtl::bench;
use potamoi_units::emit::emit_exponential;

fn lay(config: &Config, prefix: &str, folder: &Path) {
    let block = emit_exponential(config, prefix, "test").unwrap();
    let bench = bench::exponential(config, prefix).unwrap();
    let bench = bench
        .into_iter()
        .map(|(name, text)| (format!("sim/{name}"), text));
    for (path, text) in block.into_iter().chain(bench) {
        let path = folder.join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
}

/// Whether it passes, and what the simulator says.
fn simulate(folder: &Path, arguments: &[&str]) -> (bool, String) {
    let mut make = Command::new("make");
    make.arg("-C").arg(folder.join("sim")).args(arguments);
    let done = make.output().unwrap();
    let said = String::from_utf8([done.stdout, done.stderr].concat()).unwrap();
    (done.status.success(), said)
}

fn passes(folder: &Path, arguments: &[&str]) {
    let (well, said) = simulate(folder, arguments);
    assert!(well && said.matches("PASS: ").count() == 2, "{said}");
    assert!(!said.to_lowercase().contains("warning"), "{said}");
}

const RUNS: &str = "RUNS=0:1 40:3";

/// All 65,536 operands of every form, with Verilator.
#[test]
fn every_form_passes_its_bench() {
    for &form in ExpForm::ALL {
        let mut config = Config::default();
        config.vu.exp = form.plain();
        let folder = tempfile::tempdir().unwrap();
        lay(&config, "", folder.path());
        passes(folder.path(), &["SIM=verilator", RUNS]);
    }
}

fn small() -> Config {
    let text = "[vu.exp]\niterations = 8\ninput = \"U3.6\"\noutput_bits = 10\nearly_out = true";
    Config::from_toml(text, "test").unwrap()
}

/// Nine bits of operand are two checksums.
#[test]
fn a_small_block_passes_and_its_mutants_fail() {
    let folder = tempfile::tempdir().unwrap();
    lay(&small(), "npu_", folder.path());
    passes(folder.path(), &[RUNS]);
    for (file, from, to, said) in [
        (
            "npu_vector_lane.v",
            "sub0 <= remain_now",
            "sub0 < remain_now",
            "checksum",
        ),
        (
            "npu_vector_unit.v",
            "m_axis_vec_tvalid = fifo_valid",
            "m_axis_vec_tvalid = 1'b1",
            "FAIL",
        ),
        (
            "npu_vector_unit.v",
            "in_flight < 2'd3",
            "in_flight < 2'd1",
            "cycles, expected",
        ),
        ("npu_exponential.v", "y_data = ", "y_data = ~", "checksum"),
    ] {
        let path = folder.path().join("exponential").join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.matches(from).count(), 1, "{from}: {text}");
        std::fs::write(&path, text.replace(from, to)).unwrap();
        let (well, told) = simulate(folder.path(), &[RUNS]);
        assert!(
            !well && told.contains("FAIL") && told.contains(said),
            "{from}: {told}"
        );
        std::fs::write(&path, text).unwrap();
    }
    std::fs::remove_file(folder.path().join("sim/exponential_sums.hex")).unwrap();
    let (well, told) = simulate(folder.path(), &[RUNS]);
    assert!(
        !well && told.contains("exponential_sums.hex is missing"),
        "{told}"
    );
}

#[test]
fn operands_too_wide_to_run_through_are_refused() {
    let config =
        Config::from_toml("[vu.exp]\ninput = \"U3.24\"\nconstant_bits = 27", "test").unwrap();
    let refused = bench::exponential(&config, "").unwrap_err().to_string();
    assert!(
        refused.contains("vu.exp.input = U3.24: operands of 27 bits"),
        "{refused}"
    );
}
