//! Tools are found, missed, and refused by version, in folders of scripts.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use super::search::number;
use super::*;

use std::collections::BTreeMap;
use std::os::unix::fs::PermissionsExt as _;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A script that is being written while another test starts a program cannot itself be started.
static ALONE: Mutex<()> = Mutex::new(());

/// A folder of programs that print what they are told to.
struct Fake {
    root: tempfile::TempDir,
    variables: BTreeMap<&'static str, OsString>,
    _alone: MutexGuard<'static, ()>,
}

impl Fake {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("bin").into_os_string();
        Self {
            root,
            variables: BTreeMap::from([("PATH", path)]),
            _alone: ALONE.lock().unwrap_or_else(PoisonError::into_inner),
        }
    }

    fn path(&self, inside: &str) -> PathBuf {
        self.root.path().join(inside)
    }

    fn script(&self, path: &str, body: &str) {
        let path = self.path(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, format!("#!/bin/sh\n{body}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    }

    fn says(&self, path: &str, text: &str) {
        self.script(path, &format!("echo '{text}'"));
    }

    fn all(&self) {
        self.says(
            "bin/verilator",
            "Verilator 5.006 2023-01-22 rev (Debian 5.006-3)",
        );
        self.says("bin/g++", "g++ (Debian 12.2.0-14+deb12u1) 12.2.0");
        self.says("bin/iverilog", "Icarus Verilog version 11.0 (stable) ()");
        self.says("bin/vvp", "Icarus Verilog runtime version 11.0 (stable) ()");
        self.says("bin/yosys", "Yosys 0.23 (git sha1 7ce5011c24b)");
    }

    fn report(&self) -> Vec<Finding> {
        examine_in(&Surroundings {
            variable: &|name| self.variables.get(name).cloned(),
            folder: self.path("project/deep"),
        })
    }
}

fn is_complete(report: &[Finding]) -> bool {
    !report.iter().any(Finding::is_lacking)
}

fn tool<'a>(report: &'a [Finding], name: &str) -> &'a Finding {
    report.iter().find(|t| t.name == name).unwrap()
}

#[test]
fn the_required_tools_are_enough() {
    let fake = Fake::new();
    fake.all();
    let report = fake.report();
    assert!(is_complete(&report), "{report:?}");
    let versions = ["verilator", "g++", "iverilog", "yosys"]
        .map(|t| tool(&report, t).version.clone().unwrap());
    assert_eq!(versions, ["5.006", "12.2.0", "11.0", "0.23"]);
    assert_eq!(tool(&report, "sta").state, State::Missing);
    assert!(!tool(&report, "sta").required);
}

#[test]
fn an_empty_path_lacks_everything_and_says_what_is_lost() {
    let report = Fake::new().report();
    assert!(!is_complete(&report));
    for tool in &TOOLS {
        let found = self::tool(&report, tool.name);
        assert_eq!(found.state, State::Missing);
        assert_eq!((found.disables, found.remedy), (tool.disables, tool.remedy));
    }
}

#[test]
fn each_required_tool_is_missed() {
    for name in ["verilator", "g++", "iverilog", "vvp", "yosys"] {
        let fake = Fake::new();
        fake.all();
        std::fs::remove_file(fake.path("bin").join(name)).unwrap();
        let report = fake.report();
        assert!(!is_complete(&report), "without {name}");
        let lacking: Vec<_> = report
            .iter()
            .filter(|t| t.is_lacking())
            .map(|t| t.name)
            .collect();
        assert_eq!(lacking, [if name == "vvp" { "iverilog" } else { name }]);
    }
}

#[test]
fn an_old_tool_is_refused_with_both_versions() {
    let fake = Fake::new();
    fake.all();
    fake.says(
        "bin/verilator",
        "Verilator 4.038 2020-07-11 rev v4.036-114-g0cd4a57ad",
    );
    let report = fake.report();
    let verilator = tool(&report, "verilator");
    assert_eq!(verilator.state, State::TooOld);
    assert_eq!(
        verilator.problem.as_deref(),
        Some("4.038 is too old, 5.006 is needed")
    );
    assert!(!is_complete(&report));
}

#[test]
fn a_tool_that_fails_or_says_nothing_is_broken() {
    for body in ["exit 7", "echo hello"] {
        let fake = Fake::new();
        fake.all();
        fake.script("bin/yosys", body);
        let report = fake.report();
        assert_eq!(tool(&report, "yosys").state, State::Broken, "{body}");
        assert!(!is_complete(&report));
    }
}

#[test]
fn the_package_of_verilator_has_its_version_in_a_header() {
    let mut fake = Fake::new();
    fake.all();
    let root = fake.path("package");
    let body = format!(
        "if [ $1 = --getenv ]; then echo {}; else echo ' rev vUNKNOWN-built20260516-4e853d8'; fi",
        root.display()
    );
    fake.script("package/bin/verilator", &body);
    std::fs::create_dir_all(root.join("include")).unwrap();
    std::fs::write(
        root.join("include/verilated_config.h"),
        "\n#define VERILATOR_VERSION \"5.49\"\n",
    )
    .unwrap();
    fake.variables.insert("VERILATOR_ROOT", root.clone().into());
    let report = fake.report();
    let verilator = tool(&report, "verilator");
    assert_eq!(verilator.version.as_deref(), Some("5.49"));
    assert_eq!(verilator.path, Some(root.join("bin/verilator")));
}

#[test]
fn a_variable_that_names_no_program_is_not_passed_over() {
    let mut fake = Fake::new();
    fake.all();
    fake.variables.insert("CXX", "no-such-compiler -m64".into());
    let report = fake.report();
    assert_eq!(tool(&report, "g++").state, State::Missing);
    assert!(
        tool(&report, "g++")
            .problem
            .as_ref()
            .unwrap()
            .contains("CXX is \"no-such-compiler -m64\"")
    );

    fake.script("bin/wrap", "[ $1 = g++ ] && echo 'cc 13.1.0'");
    fake.variables.insert("CXX", "wrap g++".into());
    assert_eq!(
        tool(&fake.report(), "g++").version.as_deref(),
        Some("13.1.0")
    );
}

#[test]
fn the_named_folder_of_tools_goes_before_the_path() {
    let mut fake = Fake::new();
    fake.all();
    fake.says("mine/yosys", "Yosys 0.70 (git)");
    fake.variables
        .insert("POTAMOI_TOOLS", fake.path("mine").into());
    assert_eq!(
        tool(&fake.report(), "yosys").version.as_deref(),
        Some("0.70")
    );
}

#[test]
fn private_tools_that_the_path_leaves_out_do_not_count() {
    let fake = Fake::new();
    fake.all();
    std::fs::remove_file(fake.path("bin/yosys")).unwrap();
    fake.says("project/.tools/bin/yosys", "Yosys 0.70 (git)");
    let report = fake.report();
    let yosys = tool(&report, "yosys");
    assert_eq!(yosys.state, State::OutsidePath);
    assert!(
        yosys
            .problem
            .as_ref()
            .unwrap()
            .contains("project/.tools/bin")
    );
    assert!(!is_complete(&report));
}

#[test]
fn the_json_has_every_tool() {
    let fake = Fake::new();
    fake.all();
    let json = serde_json::to_value(fake.report()).unwrap();
    assert_eq!(json.as_array().unwrap().len(), TOOLS.len());
    assert_eq!(json[0]["state"], "found");
    assert_eq!(json[4]["state"], "missing");
}

#[test]
fn versions_are_compared_by_their_parts() {
    assert!(numbers("5.48.0") > numbers("5.006") && numbers("5.006") > numbers("4.228"));
    assert!(numbers("0.9") < numbers("0.23") && numbers("12.2.0") > numbers("9.0"));
    assert_eq!(number("Yosys 0.23 (git sha1 7ce5011c24b)"), Some("0.23"));
    assert_eq!(number(" rev vUNKNOWN-built20260516-4e853d8"), None);
    assert_eq!(number("version 3. and 4.5."), Some("4.5"));
}
