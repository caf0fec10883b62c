//! What a file says that is not used is told by every command that reads the file.

use std::fs;
use std::path::Path;

use super::expect;

/// Arguments of each command that opens a scene, which is `q.ply`.
const QUICK: [(&str, &str); 11] = [
    (
        "render",
        "--scene q.ply --width 8 --numerics float --out o.png",
    ),
    ("trace", "--scene q.ply --width 8 --out t.npz"),
    ("layouts", "--scene q.ply --width 8"),
    ("characterise", "--scene q.ply --width 8"),
    ("effects", "--scene q.ply --width 8 --frames 1 --pairs 0"),
    ("warp", "--scene q.ply --width 8 --frames 2"),
    ("emit", "--for-scene q.ply --out-dir e"),
    ("model", "--scene q.ply --width 12 --frames 2 --window 2"),
    ("compare", "paper --scene q.ply --width 8 --frames 1"),
    ("sweep", "plan.toml --work-dir w"),
    ("hard-cases", "--scene q.ply --width 8"),
];
/// Those that build models or netlists, in `make test-full`.
const SLOW: [(&str, &str); 7] = [
    ("bench", "--scene q.ply --width 8 --only splats --runs 1"),
    ("cost", "--scene q.ply --width 8 --frames 2 --knobs tail"),
    (
        "explore",
        "small --scene q.ply --width 8 --frames 1 --vary system.memory_channels=2,4",
    ),
    (
        "report",
        "q.ply --width 8 --frames 2 --knobs tail --out r.html",
    ),
    ("--config small verify", "--scene q.ply --width 8"),
    ("--config small synth", "--activity q.ply --unit vu"),
    (
        "--config small mutate",
        "--scene q.ply --width 8 --unit vu --mutants 1 --judges bench",
    ),
];

/// Three Gaussians with a property that nobody knows.
fn with_unknown_property(folder: &Path) {
    let mut names = vec!["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity"];
    names.extend(["scale_0", "scale_1", "scale_2"]);
    names.extend(["rot_0", "rot_1", "rot_2", "rot_3", "zzz"]);
    let declared: String = names
        .iter()
        .map(|n| format!("property float {n}\n"))
        .collect();
    let rows: String = (0..3)
        .map(|i| format!("{} 0 1 1 0 0 2 -2 -2 -2 1 0 0 0 7\n", 0.3 * f64::from(i)))
        .collect();
    let head = "ply\nformat ascii 1.0\nelement vertex 3\n";
    let text = format!("{head}{declared}end_header\n{rows}");
    fs::write(folder.join("q.ply"), text).unwrap();
    let plan = "scenes = [\"q.ply\"]\nwidth = 8\n[workload]\nframes = 1\n";
    fs::write(folder.join("plan.toml"), plan).unwrap();
}

fn tell(commands: &[(&str, &str)]) {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    with_unknown_property(at);
    for (command, arguments) in commands {
        let said = expect(at, 0, &format!("$P {command} {arguments} --json r.json"));
        let told = said.matches("not used of the file: zzz").count();
        assert_eq!(told, 1, "{command}: {said}");
        let report = fs::read_to_string(at.join("r.json")).unwrap();
        assert!(
            report.contains("not used of the file: zzz"),
            "{command}: {report}"
        );
    }
}

#[test]
fn commands_tell_what_of_a_file_is_not_used() {
    tell(&QUICK);
}

#[test]
#[ignore = "builds models and netlists; run with make test-full"]
fn commands_that_build_tell_what_of_a_file_is_not_used() {
    tell(&SLOW);
}

/// Which names the parts of a file one by one.
#[test]
fn inspect_names_what_of_a_file_is_not_used() {
    let folder = tempfile::tempdir().unwrap();
    with_unknown_property(folder.path());
    let said = expect(folder.path(), 0, "$P inspect q.ply --json r.json");
    assert!(said.contains("not used: zzz"), "{said}");
    let report = fs::read(folder.path().join("r.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(report["not_used"][0], "zzz");
}

/// A new command that opens scenes stands in one of the lists.
#[test]
fn every_command_that_opens_a_scene_is_tried() {
    let folder = tempfile::tempdir().unwrap();
    let help = expect(folder.path(), 0, "$P --help");
    let (_, commands) = help.split_once("Commands:\n").unwrap();
    let names = commands.lines().take_while(|line| line.starts_with("  "));
    let names: Vec<&str> = names
        .filter(|line| !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(names.len() > 10, "{names:?}");
    for name in names.iter().filter(|name| **name != "help") {
        let help = expect(folder.path(), 0, &format!("$P {name} --help"));
        let opens = [
            "--scene ",
            "--for-scene ",
            "--activity ",
            "<PLAN>",
            "<SCENE>...",
            "<FILE> [OTHER]",
        ];
        let is_tried = QUICK
            .iter()
            .chain(&SLOW)
            .any(|(own, _)| own.ends_with(name))
            || *name == "inspect";
        assert_eq!(
            opens.iter().any(|flag| help.contains(flag)),
            is_tried,
            "{name}"
        );
    }
}
