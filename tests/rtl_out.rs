//! The checked-in Verilog is what the generator makes, and tools accept it
//! without a waiver.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use potamoi_rtl::bench::RUNS;

pub(crate) fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Presets by name: what lies in `configs`.
pub(crate) fn presets() -> Vec<String> {
    let files = std::fs::read_dir(root().join("configs")).unwrap();
    let mut names: Vec<String> = files
        .map(|f| f.unwrap().path().file_stem().unwrap().display().to_string())
        .collect();
    names.sort();
    assert!(names.len() >= 2);
    names
}

pub(crate) fn emit(preset: &str, out: &Path) {
    let done = Command::new(env!("CARGO_BIN_EXE_potamoi"))
        .args(["--config", preset, "emit", "--out-dir"])
        .arg(out)
        .output()
        .unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
}

fn read(folder: &Path) -> BTreeMap<String, String> {
    let mut names = vec![];
    below(folder, folder, &mut names);
    let files = names.into_iter().map(|name| {
        let text = std::fs::read_to_string(folder.join(&name)).unwrap();
        (name, text)
    });
    files.collect()
}

/// Presets whose Verilog is checked in whole, to be read: the paper's units, each other organisation
/// of the gathering unit, and the smallest pair. Of the others a manifest with the hash of every
/// file is.
const TO_READ: [&str; 4] = ["feature-major", "paper", "parity", "small"];
const MANIFEST: &str = "manifest.json";

/// What is checked in of a preset that was emitted into a folder, by path below `rtl_out`.
fn checked_in(preset: &str, made: &Path) -> BTreeMap<String, String> {
    let mut files = read(made);
    if !TO_READ.contains(&preset) {
        files.retain(|name, _| name == MANIFEST);
    }
    let within = |(name, text)| (format!("{preset}/{name}"), text);
    files.into_iter().map(within).collect()
}

#[test]
fn the_checked_in_verilog_is_current() {
    let mut made = BTreeMap::new();
    for preset in presets() {
        let folder = tempfile::tempdir().unwrap();
        emit(&preset, folder.path());
        made.extend(checked_in(&preset, folder.path()));
    }
    let kept = root().join("rtl_out");
    if std::env::var_os("POTAMOI_REFRESH").is_some() {
        std::fs::remove_dir_all(&kept).unwrap();
        for (name, text) in &made {
            let path = kept.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
    }
    for (name, text) in &made {
        assert!(
            std::fs::read_to_string(kept.join(name)).ok().as_ref() == Some(text),
            "rtl_out/{name} is not what the generator makes; refresh it and review the change: \
             POTAMOI_REFRESH=1 cargo test --test end_to_end the_checked_in_verilog"
        );
    }
    let mut names = vec![];
    below(&kept, &kept, &mut names);
    names.retain(|name| !made.contains_key(name));
    assert_eq!(names, [""; 0], "rtl_out holds files that are not made");
    let is_preset = |name: &&str| presets().iter().any(|p| p == name);
    assert!(TO_READ.iter().all(is_preset));
}

/// Paths of all files in a folder, from `root` on.
fn below(root: &Path, folder: &Path, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        // What `make -C rtl_out/PRESET/sim` builds.
        if path.ends_with("sim/build") {
            continue;
        }
        if path.is_dir() {
            below(root, &path, found);
        } else {
            let name = path.strip_prefix(root).unwrap();
            found.push(name.display().to_string());
        }
    }
}

#[test]
fn what_was_emitted_is_listed() {
    let made = tempfile::tempdir().unwrap();
    let report = made.path().join("r.json");
    let done = Command::new(env!("CARGO_BIN_EXE_potamoi"))
        .args(["emit", "--out-dir"])
        .arg(made.path().join("rtl"))
        .arg("--json")
        .arg(&report)
        .output()
        .unwrap();
    assert!(done.status.success());
    let text = std::fs::read_to_string(&report).unwrap();
    let r: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(r["format_version"], 1);
    let mut files = read(&made.path().join("rtl"));
    files.remove(MANIFEST);
    let listed = r["files"].as_object().unwrap();
    assert_eq!(listed.len(), files.len());
    for (name, text) in &files {
        assert_eq!(listed[name], text.lines().count(), "{name}");
    }
}

/// Runs the benches beside emitted units, with gaps in the streams and without; `more` are further
/// variables of the Makefile.
fn simulates(folder: &Path, runs: &str, more: &[&str]) {
    let build = tempfile::tempdir().unwrap();
    let done = Command::new("make")
        .arg("-C")
        .arg(folder.join("sim"))
        .arg(format!("BUILD={}", build.path().display()))
        .arg(format!("RUNS={runs}"))
        .args(more)
        .output()
        .unwrap();
    let said = String::from_utf8([done.stdout, done.stderr].concat()).unwrap();
    assert!(done.status.success(), "{said}");
    let passed = said.matches("PASS: ").count();
    assert_eq!(passed, 3 * runs.split(' ').count(), "{said}");
}

/// Lints emitted units as their Makefile does, without the checks in the text and with them.
pub(crate) fn lints(folder: &Path) {
    for more in ["CHECKS=", "CHECKS=1"] {
        let done = Command::new("make")
            .arg("-C")
            .arg(folder)
            .args(["lint", more])
            .output()
            .unwrap();
        let said = String::from_utf8([done.stdout, done.stderr].concat()).unwrap();
        assert!(
            done.status.success(),
            "{}, {more}: {said}",
            folder.display()
        );
    }
}

#[test]
fn both_modes_of_the_checked_in_verilog_lint() {
    lints(&root().join("rtl_out/small"));
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn both_modes_of_all_presets_lint() {
    for preset in presets() {
        let folder = tempfile::tempdir().unwrap();
        emit(&preset, folder.path());
        lints(folder.path());
    }
}

/// Two configurations, one with a prefix, in one design: all files of both are read together.
#[test]
fn two_configurations_meet_in_one_design() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let mut files = vec![];
    for (folder, options) in folders.iter().zip([
        ["--config", "small", "--prefix", "a_"],
        ["--config", "parity", "--prefix", "b_"],
    ]) {
        let done = Command::new(env!("CARGO_BIN_EXE_potamoi"))
            .args(["emit", "--out-dir"])
            .arg(folder.path())
            .args(options)
            .output()
            .unwrap();
        assert!(done.status.success(), "{done:?}");
        for (name, text) in read(folder.path()) {
            let path = folder.path().join(&name);
            if name.ends_with(".v") && !name.starts_with("sim/") {
                files.push(path.clone());
            }
            if name.ends_with(".rdl") {
                assert!(
                    text.contains(&format!("addrmap {}potamoi_npu", options[3])),
                    "{text}"
                );
            }
        }
    }
    let both = folders[0].path().join("both.v");
    let top = "module both; a_potamoi_npu_ext a (); b_potamoi_npu_ext b (); endmodule\n";
    std::fs::write(&both, top).unwrap();
    files.push(both);
    for macros in [&[][..], &["-DPOTAMOI_CHECKS"]] {
        let done = Command::new("iverilog")
            .args(["-g2005", "-tnull", "-s", "both"])
            .args(macros)
            .args(&files)
            .output()
            .unwrap();
        assert!(done.status.success(), "{macros:?}: {done:?}");
    }
    // Both headers in one program.
    let headers = folders.each_ref().map(|folder| {
        let path = folder.path().join("registers/potamoi_npu.h");
        format!("#include \"{}\"\n", path.display())
    });
    let program = headers.concat()
        + "int main(void) { return A_POTAMOI_NPU_CONFIG_LOW_RESET == B_POTAMOI_NPU_CONFIG_LOW_RESET; }\n";
    let source = folders[0].path().join("both.c");
    std::fs::write(&source, program).unwrap();
    let done = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-o"])
        .arg(folders[0].path().join("both"))
        .arg(&source)
        .output()
        .unwrap();
    assert!(done.status.success(), "{done:?}");
    let differ = Command::new(folders[0].path().join("both"))
        .status()
        .unwrap();
    assert!(differ.success());
}

#[test]
fn the_benches_of_the_checked_in_verilog_pass() {
    simulates(&root().join("rtl_out/small"), "40:1", &["CHECKS=1"]);
}

/// Runs the bench of the vector unit in `folder`; whether it passed, and what was said.
fn simulated(folder: &Path, more: &[&str]) -> (bool, String) {
    let done = Command::new("make")
        .arg("-C")
        .arg(folder.join("sim"))
        .args(["UNITS=vector_unit", "RUNS=0:1"])
        .args(more)
        .output()
        .unwrap();
    let said = String::from_utf8([done.stdout, done.stderr].concat()).unwrap();
    (done.status.success(), said)
}

/// The command in the head of every bench is the one that runs it.
#[test]
fn the_command_in_the_head_of_a_bench_runs_it() {
    let folder = tempfile::tempdir().unwrap();
    emit("small", folder.path());
    for unit in ["gathering_unit", "vector_unit", "potamoi_npu_ext"] {
        let bench = folder.path().join(format!("sim/{unit}_tb.v"));
        let text = std::fs::read_to_string(bench).unwrap();
        let head = text.lines().take_while(|line| line.starts_with("//"));
        let lines: Vec<&str> = head.filter_map(|line| line.strip_prefix("//   ")).collect();
        assert_eq!(lines[0], "make");
        let done = Command::new("sh")
            .args(["-c", &lines[1..].join("\n")])
            .current_dir(folder.path().join("sim"))
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&done.stdout);
        let last = said.lines().last().unwrap_or_default();
        assert!(last.starts_with(&format!("PASS: {unit}")), "{done:?}");
    }
}

/// A build is used again only with the same files and options, whatever their age.
#[test]
fn a_bench_is_built_again_for_other_files_and_options() {
    is_built_again("SIM=icarus");
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn a_bench_for_verilator_is_built_again_for_other_files_and_options() {
    is_built_again("SIM=verilator");
}

fn is_built_again(simulator: &str) {
    let [folder, other] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let tiny = folder.path().join("tiny.toml");
    std::fs::write(&tiny, "[vu]\nlanes = 1\nops = [\"relu\"]\n").unwrap();
    for at in [&folder, &other] {
        emit(tiny.to_str().unwrap(), at.path());
    }
    let lane = other.path().join("vector_unit/vector_lane.v");
    let text = std::fs::read_to_string(&lane).unwrap();
    let edited = text.replacen("assign result = ", "assign result = 32'd1 ^ ", 1);
    assert_ne!(text, edited);
    std::fs::write(&lane, edited).unwrap();
    // Older than any build.
    let old = std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(1 << 30);
    let file = std::fs::File::options().write(true).open(&lane).unwrap();
    file.set_modified(old).unwrap();
    let faulty = format!("RTL={}", other.path().display());
    let run = |more: &[&str]| simulated(folder.path(), &[&[simulator], more].concat());
    let plain = run(&[]);
    assert!(plain.0, "{}", plain.1);
    let (passes, said) = run(&[&faulty]);
    assert!(!passes && said.contains("FAIL"), "{said}");
    let plain = run(&[]);
    assert!(plain.0, "{}", plain.1);
    let (passes, said) = run(&["CHECKS=1"]);
    assert!(passes && said.contains("-DPOTAMOI_CHECKS"), "{said}");
    let (passes, said) = run(&["CHECKS=1"]);
    assert!(passes && !said.contains("-DPOTAMOI_CHECKS"), "{said}");
    for (option, named) in [
        ("RTL=/nowhere", "no Verilog in /nowhere/vector_unit"),
        ("RUNS=", "RUNS is empty"),
        ("RUNS=abc:1", "RUNS=abc:1: expected GAPS:SEED"),
        ("RUNS=5", "RUNS=5: expected GAPS:SEED"),
        ("MACROS=none.v", "no file none.v"),
    ] {
        let (passes, said) = simulated(folder.path(), &[option]);
        assert!(!passes && said.contains(named), "{option}: {said}");
    }
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn the_benches_of_all_presets_pass() {
    for preset in presets() {
        let folder = tempfile::tempdir().unwrap();
        emit(&preset, folder.path());
        // Those of the Makefile, and the longest pauses.
        simulates(folder.path(), &format!("{RUNS} 95:5"), &[]);
        simulates(folder.path(), "40:1", &["CHECKS=1"]);
        let verilator = &["CHECKS=1", "SIM=verilator"];
        simulates(folder.path(), "40:1", verilator);
    }
}

/// Lines, at most, of the top that joins the units of a preset, without the units.
const TOP_LINES: usize = 1000;

/// Lines and the percentage of repetition, at most, of the units of a preset.
const TEXT: [(&str, usize, f64); 4] = [
    ("paper", 1400, 10.0),
    ("small", 1440, 10.0),
    ("parity", 1760, 18.0),
    ("feature-major", 1920, 8.0),
];

/// Folders beside the units.
const BESIDE: [&str; 2] = ["sim/", "checks/"];

/// The text that is read without `POTAMOI_CHECKS`, and without the empty line in front of them.
fn without_checks(text: &str) -> String {
    let mut depth = 0;
    let mut kept = String::new();
    for line in text.lines() {
        let begins = line.starts_with("`ifdef") && (depth > 0 || line.ends_with(" POTAMOI_CHECKS"));
        if begins && depth == 0 && kept.ends_with("\n\n") {
            kept.pop();
        }
        depth += usize::from(begins);
        if depth == 0 {
            kept += line;
            kept.push('\n');
        }
        depth -= usize::from(depth > 0 && line.starts_with("`endif"));
    }
    assert_eq!(depth, 0, "{text}");
    kept
}

/// Marks the lines of a file that repeat others but for numbers: those in a block of two to four lines
/// that occurs three times or more. The first occurrence is free.
fn repeated(lines: &[String]) -> Vec<bool> {
    let mut marks = vec![false; lines.len()];
    for length in 2..=4 {
        let mut places: BTreeMap<&[String], Vec<usize>> = BTreeMap::new();
        for (at, block) in lines.windows(length).enumerate() {
            places.entry(block).or_default().push(at);
        }
        for at in places
            .values()
            .filter(|at| at.len() >= 3)
            .flat_map(|at| &at[1..])
        {
            marks[*at..at + length].fill(true);
        }
    }
    marks
}

#[test]
fn blocks_that_differ_in_numbers_are_repetition() {
    let lines = ["a1", "b2", "x", "a3", "b4", "y", "a5", "b6", "c", "c", "c"];
    let plain = lines.map(|line| line.replace(|c: char| c.is_ascii_digit(), "#"));
    let found = repeated(&plain);
    let expected = [3, 4, 6, 7];
    assert!(
        (0..8).all(|at| found[at] == expected.contains(&at)),
        "{found:?}"
    );
}

#[test]
fn the_verilog_is_short_enough_to_read() {
    for (preset, most, share) in TEXT {
        let files = read(&root().join("rtl_out").join(preset));
        let is_top = |name: &str| name.starts_with("potamoi_npu_ext/");
        let is_unit = |name: &str| {
            name.ends_with(".v") && !is_top(name) && !BESIDE.iter().any(|f| name.starts_with(f))
        };
        let of_top = files.iter().filter(|(name, _)| is_top(name));
        let of_top = of_top.map(|(_, text)| without_checks(text).lines().count());
        let of_top = of_top.sum::<usize>();
        assert!(
            (1..=TOP_LINES).contains(&of_top),
            "{preset}: {of_top} lines of the top, expected {TOP_LINES} at most"
        );
        let (mut lines, mut all, mut again) = (0, 0, 0);
        for (name, text) in files.iter().filter(|(name, _)| is_unit(name)) {
            let text = without_checks(text);
            lines += text.lines().count();
            for (at, line) in text.lines().enumerate() {
                assert!(line.len() <= 100, "{preset}/{name}:{}: {line}", at + 1);
            }
            let plain = text.lines().map(str::trim).filter(|line| !line.is_empty());
            let plain: Vec<String> = plain
                .map(|line| {
                    let mut numbers = line.split(|c: char| c.is_ascii_digit());
                    let first = numbers.next().unwrap_or_default().to_owned();
                    let rest = numbers.filter(|part| !part.is_empty());
                    rest.fold(first, |text, part| text + "#" + part)
                })
                .collect();
            all += plain.len();
            again += repeated(&plain).into_iter().filter(|mark| *mark).count();
        }
        let found = 100.0 * again as f64 / all as f64;
        println!("{preset}: {lines} lines, {found:.1} % repetition");
        assert!(
            lines <= most,
            "{preset}: {lines} lines, expected {most} at most"
        );
        assert!(
            found <= share,
            "{preset}: {found:.1} % repetition, expected {share} at most"
        );
    }
}

fn accepts(tool: &str, args: &[&str], files: &[PathBuf]) {
    let done = Command::new(tool).args(args).args(files).output();
    let done = done.unwrap_or_else(|e| panic!("{tool}: {e}; tools/setup installs it"));
    let text = format!(
        "{}{}",
        String::from_utf8_lossy(&done.stdout),
        String::from_utf8_lossy(&done.stderr)
    );
    assert!(
        done.status.success() && text.trim().is_empty(),
        "{tool} {args:?} says:\n{text}"
    );
}

#[test]
fn verilator_icarus_and_yosys_accept_it_without_a_waiver() {
    tools_accept(&TO_READ.map(str::to_owned));
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn verilator_icarus_and_yosys_accept_all_presets_without_a_waiver() {
    tools_accept(&presets());
}

fn tools_accept(presets: &[String]) {
    let emitted = tempfile::tempdir().unwrap();
    let units = presets.iter().flat_map(|preset| {
        let folder = emitted.path().join(preset);
        emit(preset, &folder);
        let units = ["gathering_unit", "vector_unit"];
        let [one, other] = units.map(|unit| (vec![folder.join(unit)], unit));
        let all = ["gathering_unit", "vector_unit", "potamoi_npu_ext"];
        let all = all.map(|unit| folder.join(unit)).to_vec();
        [one, other, (all, "potamoi_npu_ext")]
    });
    for (folders, unit) in units {
        let files = folders
            .iter()
            .map(|folder| std::fs::read_dir(folder).unwrap());
        let mut files: Vec<PathBuf> = files.flatten().map(|f| f.unwrap().path()).collect();
        files.sort();
        for file in &files {
            let text = std::fs::read_to_string(file).unwrap();
            assert!(
                !text.contains("lint_off"),
                "{} has a waiver",
                file.display()
            );
        }
        accepts(
            "verilator",
            &[
                "--lint-only",
                "-Wall",
                "--language",
                "1364-2005",
                "--top-module",
                unit,
            ],
            &files,
        );
        accepts(
            "iverilog",
            &["-g2005", "-Wall", "-tnull", "-s", unit],
            &files,
        );
        let list: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
        let script = format!(
            "read_verilog {}; hierarchy -check -top {unit}; proc; check -assert",
            list.join(" ")
        );
        accepts("yosys", &["-q", "-e", ".*", "-p", &script], &[]);
    }
}
