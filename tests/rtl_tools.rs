//! The emitted Verilog and its package with the tools of others, which `tools/setup linters` and
//! `tools/setup synth` install.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::rtl_out::{emit, presets, root};

/// Rules of Verible that the Verilog does not keep: docs/how-to/use-the-verilog.md says why.
const NOT_KEPT: &str = "--rules=-always-comb,-explicit-parameter-storage-type,\
-generate-label-prefix,-unpacked-dimensions-range-ordering,\
parameter-name-style=localparam_style:ALL_CAPS";

/// Top modules, with the folders that each consists of.
const TOPS: [(&str, &[&str]); 3] = [
    ("gathering_unit", &["gathering_unit"]),
    ("vector_unit", &["vector_unit"]),
    (
        "potamoi_npu_ext",
        &["gathering_unit", "vector_unit", "potamoi_npu_ext"],
    ),
];

/// A program below `.tools`.
fn tool(path: &str) -> PathBuf {
    let found = root().join(".tools").join(path);
    assert!(
        found.exists(),
        "{} is missing; get it: tools/setup synth; tools/setup linters",
        found.display()
    );
    found
}

/// Runs a command and returns what it says, its status first.
fn run(command: &mut Command) -> (bool, String) {
    let done = command.output().unwrap();
    let said = String::from_utf8([done.stdout, done.stderr].concat()).unwrap();
    (done.status.success(), said)
}

/// For every preset and top, its files.
fn each(mut judge: impl FnMut(&str, &[PathBuf])) {
    for preset in presets() {
        let folder = tempfile::tempdir().unwrap();
        emit(&preset, folder.path());
        for (top, parts) in TOPS {
            let files = parts.iter().flat_map(|part| {
                let files = std::fs::read_dir(folder.path().join(part)).unwrap();
                files.map(|file| file.unwrap().path())
            });
            let mut files: Vec<PathBuf> = files.collect();
            files.sort();
            judge(top, &files);
        }
    }
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn slang_finds_nothing_with_every_warning() {
    let slang = tool("bin/slang");
    each(|top, files| {
        let args = ["-Weverything", "--top", top];
        let (good, said) = run(Command::new(&slang).args(args).args(files));
        assert!(good, "{top}:\n{said}");
    });
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn verible_finds_what_is_named_alone() {
    let verible = tool("bin/verible-verilog-lint");
    each(|top, files| {
        let (good, said) = run(Command::new(&verible).arg(NOT_KEPT).args(files));
        assert!(good && said.is_empty(), "{top}:\n{said}");
    });
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn the_newest_verilator_and_yosys_find_nothing() {
    let (verilator, yosys) = (tool("cocotb/verilator"), tool("bin/pyosys"));
    let verilator = format!("VERILATOR={}", verilator.display());
    for preset in presets() {
        let folder = tempfile::tempdir().unwrap();
        emit(&preset, folder.path());
        for checks in ["CHECKS=", "CHECKS=1"] {
            let mut make = Command::new("make");
            let make = make.arg("-C").arg(folder.path());
            let (good, said) = run(make.args(["lint-verilator", &verilator, checks]));
            assert!(good && !said.contains('%'), "{preset}, {checks}:\n{said}");
        }
    }
    each(|top, files| {
        let list: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
        let script = tempfile::NamedTempFile::new().unwrap();
        let text = format!(
            "read_verilog {}\nhierarchy -check -top {top}\nproc\ncheck -assert\n",
            list.join(" ")
        );
        std::fs::write(script.path(), text).unwrap();
        let (good, said) = run(Command::new(&yosys).arg(script.path()));
        assert!(good && !said.contains("Warning"), "{top}:\n{said}");
    });
}

/// Memories become block RAM of an FPGA alone: no flip-flop holds a word that is read while it is written, and
/// no comparator looks for that. A LUT may invert an enable.
#[test]
fn memories_of_the_paper_need_no_collision_logic_on_an_fpga() {
    let folder = root().join("rtl_out/paper/gathering_unit");
    for (memory, blocks) in [("mft_bank", 1), ("rit_bank", 4)] {
        let file = folder.join(format!("{memory}.v"));
        let script = format!(
            "read_verilog {}; synth_ecp5 -top {memory}; stat",
            file.display()
        );
        let (good, said) = run(Command::new("yosys").args(["-p", &script]));
        assert!(good, "{said}");
        let (_, cells) = said.rsplit_once("Number of cells:").unwrap();
        let count = |cell: &str| {
            let line = cells.lines().find(|line| line.contains(cell));
            let number = line.and_then(|line| line.split_whitespace().last());
            number.map_or(0, |number| number.parse::<u32>().unwrap())
        };
        assert_eq!(count("DP16KD"), blocks, "{memory}:\n{cells}");
        assert_eq!(count("TRELLIS_FF"), 0, "{memory}:\n{cells}");
        assert!(count("LUT4") <= 1, "{memory}:\n{cells}");
    }
}

/// Runs a target of the package in a folder, as someone does who has nothing else of FuseSoC.
fn fusesoc(rtl: &Path, folder: &Path, target: &str, options: &[&str]) -> String {
    let mut command = Command::new(tool("bin/fusesoc"));
    for home in ["HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME"] {
        command.env(home, folder);
    }
    command.arg("--cores-root").arg(rtl).arg("run");
    command.arg("--build-root").arg(folder.join("build"));
    command.arg(format!("--target={target}"));
    let (good, said) = run(command.arg("potamoi::units").args(options));
    assert!(good && !said.contains("WARNING"), "{target}:\n{said}");
    said
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn fusesoc_lints_and_simulates_the_package() {
    let (rtl, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    emit("small", rtl.path());
    for (top, _) in TOPS {
        fusesoc(rtl.path(), folder.path(), &format!("lint_{top}"), &[]);
        let said = fusesoc(
            rtl.path(),
            folder.path(),
            &format!("sim_{top}"),
            &["--gaps=40", "--seed=3"],
        );
        assert!(said.contains(&format!("PASS: {top}")), "{said}");
        assert!(said.contains("+gaps=40 +seed=3"), "{said}");
    }
    let other = fusesoc(
        rtl.path(),
        folder.path(),
        "sim_vector_unit",
        &["--tool=verilator"],
    );
    assert!(other.contains("PASS: vector_unit"), "{other}");
}
