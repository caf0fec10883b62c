//! Bus models of others at the ports of the top: cocotb with cocotbext-axi, in two simulators.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use potamoi_formats::config::Config;

use super::{Layout, lay, layout, run};

/// The fields of the words of all `.hex` files, as JSON.
fn json(layout: &Layout) -> String {
    let mut text = String::from("{");
    for (at, (name, file, fields)) in layout.iter().enumerate() {
        let fields: Vec<_> = fields
            .iter()
            .map(|(field, bits)| format!("[\"{field}\", {bits}]"))
            .collect();
        let _ = write!(
            text,
            "{}\n\"{name}\": {{\"file\": \"{file}\", \"fields\": [{}]}}",
            if at == 0 { "" } else { "," },
            fields.join(", ")
        );
    }
    text + "\n}\n"
}

/// Runs all tests of the foreign master: gaps in percent and seed of each run.
fn drive(simulator: &str, folder: &Path, runs: &[&str]) -> (bool, String) {
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/rtl/npu/cocotb");
    let mut command = Command::new("cocotb-python");
    command
        .arg(scripts.join("run.py"))
        .arg(simulator)
        .arg(folder)
        .arg(folder.join("layout.json"))
        .args(runs);
    let there = Command::new("cocotb-python").arg("--version").output();
    assert!(
        there.is_ok_and(|done| done.status.success()),
        "cocotb-python does not run; to get it: tools/setup cocotb, with .tools/bin in PATH"
    );
    run(&mut command)
}

fn prepared(config: &Config) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    lay(config, folder.path());
    std::fs::write(folder.path().join("layout.json"), json(&layout(config))).unwrap();
    folder
}

fn passes(simulator: &str, config: &Config, runs: &[&str]) {
    let folder = prepared(config);
    let (well, said) = drive(simulator, folder.path(), runs);
    let expected = format!("{} passed, 0 failed", 3 * runs.len());
    assert!(well && said.contains(&expected), "{said}");
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn a_foreign_master_passes_in_icarus() {
    passes(
        "icarus",
        &Config::preset("small").unwrap(),
        &["0:1", "30:2", "70:3"],
    );
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn a_foreign_master_passes_in_verilator() {
    passes(
        "verilator",
        &Config::preset("small").unwrap(),
        &["0:1", "30:2", "70:3"],
    );
    passes("verilator", &Config::default(), &["50:4"]);
}

/// The foreign master fails on a top that is wrong.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn a_foreign_master_finds_a_wrong_top() {
    let folder = prepared(&Config::preset("small").unwrap());
    for (file, from, to) in [
        (
            "npu_packet_gate.v",
            "m_tvalid = open & s_tvalid",
            "m_tvalid = s_tvalid",
        ),
        (
            "npu_axi_lite.v",
            "write_strobe <= s_axil_wstrb",
            "write_strobe <= 4'hf",
        ),
        ("npu_job.v", "(~(is_open | any_left)) & idle", "(~is_open)"),
    ] {
        let path = folder.path().join("potamoi_npu_ext").join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.matches(from).count(), 1, "{from}: {text}");
        std::fs::write(&path, text.replace(from, to)).unwrap();
        let (well, said) = drive("icarus", folder.path(), &["40:5"]);
        assert!(
            !well && said.contains("passed, ") && !said.contains(" 0 failed"),
            "{from}: {said}"
        );
        std::fs::write(&path, text).unwrap();
    }
}
