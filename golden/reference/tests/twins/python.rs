//! The Python package `python/potamoi`.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::engines::{ENGINES, assert_equal, folder, grid, operands, read};

/// Bodies of `[vu.exp]` that are refused.
const WRONG: [&str; 41] = [
    "bnks = 3",
    "iterations = \"x\"",
    "iterations = -1",
    "iterations = 1.5",
    "iterations = true",
    "iterations = 5000000000",
    "input = \"3.13\"",
    "input = \"S0.64\"",
    "input = 3",
    "form = \"x\"",
    "form = 3",
    "output = \"x\"",
    "base = \"x\"",
    "tail = 1",
    "offset = 99999999999",
    "accumulator_bits = \"a\"",
    "iterations = 32",
    "iterations = 1.0",
    "output_bits = 25",
    "one_minus_frac_bits = 30",
    "input = \"S3.12\"",
    "input = \"U3.25\"",
    "output = \"general\"",
    "output = \"general\"\ninput = \"S7.12\"\noutput_bits = 24",
    "form = \"literal\"",
    "form = \"literal\"\ninput = \"S0.15\"\ntail = true\nearly_out = true",
    "iterations_per_clock = 21",
    "iterations_per_clock = 0\naccumulator_bits = 15\nconstant_bits = 12\noffset = 17",
    "accumulator_bits = 41\nconstant_bits = 41\noffset = -17",
    "form = \"radix-4\"",
    "form = \"radix-4\"\niterations = 4\noutput = \"general\"\ninput = \"S3.12\"",
    "form = \"radix-4\"\niterations = 4\nearly_out = true",
    "base = \"two\"\npieces = 3",
    "form = \"piecewise\"\npieces = 48\npipelined = true",
    "form = \"piecewise\"\npieces = 0",
    "form = \"piecewise\"\npipelined = true\noutput_bits = 17\niterations = 5",
    "form = \"piecewise\"\npipelined = true\ntail = true\noffset = 1\nearly_out = true",
    "form = \"piecewise\"\npipelined = true\niterations_per_clock = 2",
    "form = \"piecewise\"\npipelined = true\ninput = \"U3.8\"\nconstant_bits = 9",
    "early_out = true\ntail = true\npipelined = true",
    "early_out = true\niterations_per_clock = 10",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A Python with NumPy, that of `tools/setup` first.
pub(crate) fn python() -> Command {
    let own = root().join(".tools/bin/python3-numpy");
    let has_numpy = |program: &&PathBuf| {
        let asked = Command::new(program).args(["-c", "import numpy"]).output();
        asked.is_ok_and(|output| output.status.success())
    };
    let all = [own, PathBuf::from("python3")];
    let found = all.iter().find(has_numpy);
    let mut command = Command::new(found.expect("no python3 with numpy: tools/setup test"));
    command
        .current_dir(root().join("python"))
        .env("PYTHONPATH", root().join("python"))
        .env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

pub(crate) fn run(command: &mut Command) {
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {said}");
}

/// Writes what `python/tests/compute.py` reads of an engine, named by a number.
fn ask(folder: &Path, i: usize, body: &str, operands: &[i32]) {
    let bytes: Vec<u8> = operands.iter().flat_map(|a| a.to_le_bytes()).collect();
    std::fs::write(folder.join(format!("{i}.operands")), bytes).unwrap();
    std::fs::write(folder.join(format!("{i}.knobs")), body).unwrap();
}

/// An empty folder.
pub(crate) fn empty(name: &str) -> PathBuf {
    let folder = folder(name);
    std::fs::remove_dir_all(&folder).unwrap();
    crate::engines::folder(name)
}

fn compare(bodies: &[String], name: &str) {
    let folder = empty(name);
    for (i, body) in bodies.iter().enumerate() {
        ask(&folder, i, body, &operands(&read(body).unwrap()));
    }
    run(python().arg("tests/compute.py").arg(&folder));
    for (i, body) in bodies.iter().enumerate() {
        let found = std::fs::read(folder.join(format!("{i}.results")));
        let found = found.unwrap_or_else(|error| panic!("{body}: {error}"));
        assert_equal(&read(body).unwrap(), &found, "Python");
    }
}

#[test]
fn python_results_are_those_of_the_reference_unit() {
    compare(&ENGINES.map(str::to_owned), "python");
}

#[test]
#[ignore = "hundreds of engines; run with make test-full"]
fn python_results_of_a_grid_are_those_of_the_reference_unit() {
    compare(&grid(), "python-grid");
}

#[test]
fn python_refuses_with_the_same_words() {
    let folder = empty("python-wrong");
    for (i, body) in WRONG.iter().enumerate() {
        ask(&folder, i, body, &[]);
    }
    run(python().arg("tests/compute.py").arg(&folder));
    for (i, body) in WRONG.iter().enumerate() {
        let found = std::fs::read_to_string(folder.join(format!("{i}.error")));
        let found = found.unwrap_or_else(|_| panic!("accepted: {body}"));
        assert_eq!(read(body).unwrap_err(), format!("test: {found}"), "{body}");
    }
}

/// One unit of the mantissa's last bit is seen.
#[test]
fn a_wrong_offset_is_found() {
    let (folder, config) = (empty("python-offset"), read("").unwrap());
    let offset = config.engine().offset + 1;
    ask(
        &folder,
        0,
        &format!("offset = {offset}"),
        &operands(&config),
    );
    run(python().arg("tests/compute.py").arg(&folder));
    let found = std::fs::read(folder.join("0.results")).unwrap();
    let compared = std::panic::catch_unwind(|| assert_equal(&config, &found, "Python"));
    assert!(compared.is_err());
}

#[test]
fn the_tests_of_the_package_pass() {
    run(python().args(["-m", "unittest", "discover", "-s", "tests"]));
}
