//! Outputs that would be lost are refused, by name and through links.
#![allow(clippy::unwrap_used)]

use clap::CommandFactory as _;

use super::*;

/// Whoever adds an argument that names a file says here what it is.
#[test]
fn every_argument_that_names_a_file_has_a_role() {
    let root = crate::cli::Cli::command();
    let mut lacking = vec![];
    for command in root.get_subcommands() {
        let own = command.get_arguments().chain(root.get_arguments());
        for argument in own {
            let names = argument.get_value_names().unwrap_or_default();
            let is_path = names
                .iter()
                .any(|name| ["FILE", "DIR", "SCENE", "SCENE,..."].contains(&name.as_str()));
            let id = argument.get_id().as_str();
            if is_path && role(id).is_none() {
                lacking.push(format!("{} --{id}", command.get_name()));
            }
        }
    }
    assert!(lacking.is_empty(), "{lacking:?}");
}

fn said(arguments: &[&str]) -> Option<String> {
    let cli = crate::renamed::accept(crate::cli::Cli::command());
    let matches = cli.try_get_matches_from(arguments).unwrap();
    let arguments: Vec<_> = arguments.iter().skip(1).map(OsString::from).collect();
    check(&matches, &arguments).err().map(|e| e.to_string())
}

/// A folder to name files in, and what is said of commands that do.
struct Case(tempfile::TempDir);

impl Case {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn at(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    /// What is said of a picture and a report of a scene.
    fn render(&self, out: &str, json: &str, scene: &str) -> Option<String> {
        let render = ["potamoi", "render", "--scene", scene];
        said(&[&render[..], &["--out", out, "--json", json]].concat())
    }
}

#[test]
fn two_outputs_are_two_files() {
    let case = Case::new();
    let (a, b) = (case.at("a.png"), case.at("b.json"));
    assert_eq!(case.render(&a, &b, "garden"), None);
    let twice = case.render(&a, &case.at("x/../a.png"), "garden").unwrap();
    assert!(twice.contains("are the same file"), "{twice}");
    fs::write(&a, "a").unwrap();
    std::os::unix::fs::symlink(&a, &b).unwrap();
    assert!(
        case.render(&a, &b, "garden").is_some(),
        "a link to the other"
    );
    assert_eq!(case.render("/dev/null", "/dev/null", "garden"), None);
}

/// Files that are read, directly or because a description says so.
#[test]
fn inputs_are_kept() {
    let case = Case::new();
    let (a, model) = (case.at("a.png"), case.at("m.ply"));
    fs::write(&model, "ply").unwrap();
    let description = "[model]\nkind = \"splats\"\npath = \"m.ply\"\n";
    for (name, text) in [
        ("s.toml", description.to_owned()),
        ("S.TOML", description.to_owned()),
        ("marked.toml", format!("\u{feff}{description}")),
    ] {
        let scene = case.at(name);
        fs::write(&scene, text).unwrap();
        assert!(case.render(&a, &model, &scene).is_some(), "{name}");
        assert!(case.render(&a, &scene, &scene).is_some(), "{name}");
        assert_eq!(case.render(&a, &case.at("b.json"), &scene), None, "{name}");
    }
    let lost = case.render(&a, &model, &model).unwrap();
    assert!(
        lost.contains("--json") && lost.contains("would overwrite"),
        "{lost}"
    );
    fs::create_dir(case.at("f")).unwrap();
    fs::write(case.at("f/meta.json"), "{}").unwrap();
    let folder = case.render(&a, &case.at("f/meta.json"), &case.at("f"));
    assert!(folder.is_some());
}

/// Folders that hold inputs: pictures of a sequence, and those that a path of cameras names.
#[test]
fn flags_are_named_as_they_are_given() {
    let case = Case::new();
    let grid = case.at("grid.json");
    fs::write(&grid, "{}").unwrap();
    for flag in ["--grid", "--fit-to"] {
        let error = said(&["potamoi", "estimate", flag, &grid, "--json", &grid]);
        let error = error.unwrap();
        let given = format!("{flag} {grid}");
        assert!(error.contains(&given), "{error}");
        assert!(
            ["--grid", "--fit-to"]
                .iter()
                .filter(|f| error.contains(**f))
                .count()
                == 1
        );
    }
}

#[test]
fn frames_that_are_read_are_kept() {
    let case = Case::new();
    fs::create_dir(case.at("seq")).unwrap();
    fs::write(case.at("seq/frame.0000.png"), "png").unwrap();
    let images = "[model]\nkind = \"images\"\npath = \"seq\"\n";
    let scene = case.at("images.toml");
    fs::write(&scene, images).unwrap();
    let warp = |out: &str| said(&["potamoi", "warp", "--scene", &scene, "--out-dir", out]);
    assert!(warp(&case.at("seq")).unwrap().contains("frame.0000.png"));
    assert_eq!(warp(&case.at("other")), None);
    let path = |out: &str| {
        let out = case.at(out);
        let render = ["potamoi", "render", "--scene", &scene, "--out", &out];
        said(&[&render[..], &["--frames", "2"]].concat())
    };
    assert!(path("seq/frame.png").unwrap().contains("frame.0000.png"));
    assert_eq!(path("seq/fram.png"), None);
    fs::create_dir(case.at("taken")).unwrap();
    fs::write(case.at("taken/frame.0000.png"), "png").unwrap();
    let way = case.at("way.json");
    for name in ["taken/frame.0000", "taken/frame.0000.png"] {
        let text = format!("{{\"frames\": [{{\"file_path\": \"{name}\"}}]}}");
        fs::write(&way, text).unwrap();
        let scene = ["potamoi", "render", "--scene", "garden", "--camera", &way];
        let out = case.at("taken/frame.0000.png");
        assert!(said(&[&scene[..], &["--out", &out]].concat()).is_some());
    }
}

/// Files that are written into a folder, and reports of those names in it.
#[test]
fn folders_of_outputs_keep_their_files() {
    let case = Case::new();
    let trace = |json: &str| {
        let (out, mem) = (case.at("t.npz"), case.at("mem"));
        let trace = ["potamoi", "trace", "--scene", "garden", "--out", &out];
        said(&[&trace[..], &["--readmemh", &mem, "--json", json]].concat())
    };
    assert!(trace(&case.at("mem/memories.json")).is_some());
    assert!(trace(&case.at("mem/gathering_unit_tb.v")).is_some());
    assert_eq!(trace(&case.at("mem/report.json")), None);
    let mem = case.at("mem");
    let emit = |json: &str| said(&["potamoi", "emit", "--out-dir", &mem, "--json", json]);
    assert!(emit(&case.at("mem/vector_unit/vector_unit.v")).is_some());
    assert!(emit(&case.at("mem/manifest.json")).is_some());
    assert_eq!(emit(&case.at("mem/report.json")), None);
    assert_eq!(emit(&case.at("vector_unit.json")), None);
    fs::create_dir(&mem).unwrap();
    fs::write(case.at("mem/memories.json"), "{}").unwrap();
    std::os::unix::fs::symlink(case.at("mem/memories.json"), case.at("link.json")).unwrap();
    assert!(trace(&case.at("link.json")).is_some());
    let here = ["potamoi", "trace", "--scene", "garden", "--readmemh", "."];
    let here = said(&[&here[..], &["--out", "memories.json"]].concat());
    assert!(here.unwrap().contains("is also written by"));
}

/// `inspect A --json B` is a slip for `inspect A B --json C`, which must not cost B.
#[test]
fn files_of_another_kind_are_not_replaced() {
    let case = Case::new();
    for (command, flag, name) in [
        ("inspect a.ply", "--json", "b.ply"),
        ("render --scene garden --out p.png", "--json", "first.png"),
        ("cost --scene garden", "--csv", "b.ply"),
        ("trace --scene garden", "--out", "b.ply"),
        ("verify --scene garden", "--vcd", "b.ply"),
        ("explore small --vary vu.lanes=1", "--found", "b.json"),
    ] {
        let path = case.at(name);
        let words = ["potamoi"].into_iter().chain(command.split(' '));
        let arguments: Vec<&str> = words.chain([flag, &path]).collect();
        let refused = said(&arguments).unwrap();
        assert!(refused.contains("name a file that ends in ."), "{refused}");
        assert!(refused.contains(&path), "{refused}");
    }
    let text = |json| said(&["potamoi", "inspect", "a.ply", "--json", json]);
    for taken in ["/dev/null", "report", "A.JSON"] {
        assert_eq!(text(taken), None, "{taken}");
    }
}
