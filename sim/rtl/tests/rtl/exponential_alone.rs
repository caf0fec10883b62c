//! The exponential by itself in its own bench, in C and in Python: every operand, and faults that are
//! found.

use std::path::Path;
use std::process::Command;

use potamoi_formats::config::{Config, ExpForm};
use potamoi_reference::exponential::c_header;
use potamoi_rtl::bench;
use potamoi_soc::emit::emit_exponential;

fn lay(config: &Config, prefix: &str, folder: &Path) {
    let block = emit_exponential(config, prefix, "test").unwrap();
    let bench = bench::exponential(config, prefix).unwrap();
    let bench = bench
        .into_iter()
        .map(|(name, text)| (format!("sim/{name}"), text));
    let header = ("potamoi_exp.h".to_owned(), c_header(&config.vu.exp, prefix));
    for (path, text) in block.into_iter().chain(bench).chain([header]) {
        let path = folder.join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
}

/// Whether it passes, and what the simulator says.
fn simulate(folder: &Path, arguments: &[&str]) -> (bool, String) {
    let mut make = Command::new("make");
    make.arg("-C").arg(folder.join("sim")).args(arguments);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    // The Python with NumPy, that of tools/setup first.
    let python = root.join(".tools/bin/python3-numpy");
    if python.exists() {
        make.env("PYTHON", python);
    }
    make.env("PYTHONPATH", root.join("python"));
    make.env("PYTHONDONTWRITEBYTECODE", "1");
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

#[test]
fn the_paper_s_form_passes_its_bench() {
    forms_pass(&[ExpForm::Restoring]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_form_passes_its_bench() {
    forms_pass(ExpForm::ALL);
}

/// All 65,536 operands of forms, with Verilator.
fn forms_pass(forms: &[ExpForm]) {
    for &form in forms {
        let mut config = Config::default();
        config.vu.exp = form.plain();
        let folder = tempfile::tempdir().unwrap();
        lay(&config, "", folder.path());
        passes(folder.path(), &["SIM=verilator", RUNS]);
    }
}

/// Whether the functions in C and Python pass.
fn functions_pass(config: &Config, prefix: &str) {
    let folder = tempfile::tempdir().unwrap();
    lay(config, prefix, folder.path());
    let (well, said) = simulate(folder.path(), &["c", "python"]);
    assert!(well && said.matches("PASS: ").count() == 2, "{said}");
    assert!(!said.to_lowercase().contains("warning"), "{said}");
}

/// All operands of every form, and of each format of operands and results.
#[test]
fn functions_in_c_and_python_have_the_checksums_of_the_bench() {
    for &form in ExpForm::ALL {
        let mut config = Config::default();
        config.vu.exp = form.plain();
        functions_pass(&config, "");
    }
    functions_pass(&small(), "npu_");
    let general = "vu.ops = [\"exp\"]\n[vu.exp]\noutput = \"general\"\ninput = \"S3.12\"";
    functions_pass(&Config::from_toml(general, "test").unwrap(), "");
}

/// The last bit of a constant in C, of a knob in Python, and a checksum of each.
#[test]
fn wrong_functions_are_found() {
    let folder = tempfile::tempdir().unwrap();
    lay(&small(), "npu_", folder.path());
    let change = |file: &str, from: &str, to: &str| {
        let path = folder.path().join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.matches(from).count(), 1, "{from}: {text}");
        std::fs::write(&path, text.replace(from, to)).unwrap();
        (path, text)
    };
    for (target, file, from, to, said) in [
        (
            "c",
            "potamoi_exp.h",
            "remain >= logs",
            "remain > logs",
            "checksum",
        ),
        (
            "python",
            "sim/potamoi_exp_test.py",
            "iterations=8",
            "iterations=7",
            "checksum",
        ),
        (
            "c",
            "sim/potamoi_exp_test.c",
            "< OPERANDS",
            "< OPERANDS / 2",
            "goes on",
        ),
        (
            "python",
            "sim/potamoi_exp_test.py",
            "arange(512)",
            "arange(256)",
            "has 2 checksums",
        ),
    ] {
        let (path, text) = change(file, from, to);
        let (well, told) = simulate(folder.path(), &[target]);
        let is_found = !well && told.contains("FAIL") && told.contains(said);
        assert!(is_found, "{file}: {from}: {told}");
        std::fs::write(path, text).unwrap();
    }
    let (well, said) = simulate(folder.path(), &["c", "python"]);
    assert!(well, "{said}");
    std::fs::remove_file(folder.path().join("sim/exponential_sums.hex")).unwrap();
    for target in ["c", "python"] {
        let (well, told) = simulate(folder.path(), &[target]);
        assert!(
            !well && told.contains("exponential_sums.hex is missing"),
            "{told}"
        );
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
            "room = in_flight < 2'd3",
            "room = in_flight < 2'd1",
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
