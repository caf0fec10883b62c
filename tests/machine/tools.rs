//! Tools that do not do what they should, first in `PATH`.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::time::Instant;

use super::expect;

const ANSWERS: &str = "case \"$1\" in --version) echo 'Verilator 5.006 x';; \
     --getenv) exec REAL --getenv VERILATOR_ROOT;; *) ";

/// A tool of that name, before the others in `PATH`.
fn fake(folder: &Path, name: &str, script: &str) {
    let path = folder.join("bin").join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
}

fn verify(code: i32, script: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let real = std::env::var_os("VERILATOR").unwrap_or("verilator".into());
    let found = std::env::split_paths(&std::env::var_os("PATH").unwrap())
        .map(|folder| folder.join(&real))
        .find(|path| path.is_file())
        .expect("this test needs Verilator 5");
    let root = "unset VERILATOR VERILATOR_ROOT POTAMOI_TOOLS;";
    fake(
        at,
        "verilator",
        &script.replace("REAL", &found.display().to_string()),
    );
    let begin = Instant::now();
    let run = format!(
        "{root} PATH=$PWD/bin:$PATH POTAMOI_TOOL_SECONDS=2 $P --config small verify --scene garden --width 8"
    );
    let said = expect(at, code, &run);
    assert!(begin.elapsed().as_secs() < 20, "{script}");
    said
}

#[test]
fn a_verilator_that_does_not_work_is_a_fault_of_the_machine() {
    let working = |script: &str| format!("{ANSWERS} {script};; esac");
    for (script, words) in [
        ("exit 0".to_owned(), "it prints nothing"),
        ("exec sleep 300".to_owned(), "no result within 2 s"),
        (
            "head -c 3000 /dev/urandom".to_owned(),
            "its output is not text",
        ),
        ("kill -9 $$".to_owned(), "signal 9 ended it"),
        (working("exit 0"), "left no readable"),
        (working("exec sleep 300"), "no result within 2 s"),
        (working("mkdir -p obj; : > obj/Vm.h"), "left no C++"),
        (
            working("mkdir -p obj; echo 'VL_IN8(&clk,999999999,0);' > obj/Vm.h"),
            "declares no port so",
        ),
    ] {
        let said = verify(3, &script);
        assert!(
            said.contains(words) || script.contains("urandom"),
            "{script}: {said}"
        );
        assert!(
            said.contains("doctor") || said.contains("Install it"),
            "{said}"
        );
    }
}

/// One that truly refuses the Verilog is heard, however much it says.
#[test]
fn a_verilator_that_refuses_is_heard() {
    let much = "yes '%Error: lots' | head -c 100000000 >&2; exit 1";
    let said = verify(1, &format!("{ANSWERS} {much};; esac"));
    assert!(said.contains("%Error: lots") && said.len() < 20_000);
}

/// Yosys that says nothing of itself, and Yosys that ends well and leaves nothing.
#[test]
fn a_yosys_that_does_nothing_is_a_fault_of_the_machine() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let library = concat!(env!("CARGO_MANIFEST_DIR"), "/sim/synth/cells/handful.lib");
    let synth = format!(
        "PATH=$PWD/bin:$PATH $P --config small synth --unit vu --activity none --liberty {library}"
    );
    fake(at, "sta", "echo 2.4.0");
    for (script, words) in [
        (
            "exit 0",
            "yosys does not work (its version): it succeeds but prints nothing",
        ),
        (
            "case \"$1\" in --version|-V) echo 'Yosys 0.23';; esac",
            "yosys does not work (vector_unit): it succeeds but leaves no netlist",
        ),
    ] {
        for name in ["yosys", "pyosys"] {
            fake(at, name, script);
        }
        let said = expect(at, 3, &synth);
        assert!(said.contains(words), "{script}: {said}");
    }
}

#[test]
fn other_tools_have_limits_too() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for name in ["iverilog", "yosys", "pyosys"] {
        fake(at, name, "exec sleep 300");
    }
    let run = |code, command: &str| {
        let begin = Instant::now();
        let path = "PATH=$PWD/bin:$PATH POTAMOI_TOOL_SECONDS=2";
        let said = expect(at, code, &format!("{path} $P {command}"));
        assert!(begin.elapsed().as_secs() < 20, "{command}");
        assert!(said.contains("no result within 2 s"), "{said}");
    };
    run(
        3,
        "--config small verify --engine icarus --scene garden --width 8",
    );
    run(3, "doctor");
}
