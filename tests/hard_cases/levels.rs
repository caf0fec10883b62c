//! Where each case of the unit is shown besides: by the Verilated units, in a picture, and in the
//! system.

use std::fmt::Write;
use std::path::Path;

use serde::Deserialize;

use super::{sampled, table};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Levels {
    case: Vec<Level>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Level {
    name: String,
    verilated: Shown,
    pictures: Shown,
    system: Shown,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Shown {
    In(Vec<String>),
    /// Why not.
    Not(String),
}

impl Shown {
    fn names(&self) -> &[String] {
        match self {
            Self::In(names) => names,
            Self::Not(_) => &[],
        }
    }

    fn cell(&self, called: impl Fn(&str) -> String) -> String {
        match self {
            Self::In(names) => names
                .iter()
                .map(|n| called(n))
                .collect::<Vec<_>>()
                .join(", "),
            Self::Not(why) => format!("({why})"),
        }
    }
}

/// What frames of the system hold, and the test that has them.
const SYSTEM: [(&str, &str); 6] = [
    ("splats", "every_hard_scene_is_modelled"),
    ("pictures", "pictures_of_samples_are_modelled"),
    ("samples", "hard_paths_are_modelled"),
    ("turns", "hard_paths_are_modelled"),
    ("still", "hard_paths_are_modelled"),
    ("nothing", "hard_paths_are_modelled"),
];

/// Tests of the files beside this one.
fn tests(file: &str) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hard_cases");
    let text = std::fs::read_to_string(path.join(file)).unwrap();
    let functions = text.split("#[test]\nfn ").skip(1);
    functions
        .map(|rest| rest.split('(').next().unwrap().to_owned())
        .collect()
}

fn read() -> Vec<Level> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hard_cases/levels.toml");
    let levels: Levels = toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    levels.case
}

fn written() -> String {
    let mut text = "| case | Verilated units | pictures | system |\n|---|---|---|---|\n".to_owned();
    let operands = tests("units.rs");
    for level in read() {
        let verilated = level.verilated.cell(|test| {
            let operand = operands.iter().any(|t| t == test);
            if operand { "operands" } else { "pictures" }.to_owned()
        });
        let [pictures, system] =
            [&level.pictures, &level.system].map(|shown| shown.cell(str::to_owned));
        writeln!(
            text,
            "| {} | {verilated} | {pictures} | {system} |",
            level.name
        )
        .unwrap();
    }
    text
}

/// Every case is listed, in order; every test and picture that is named is there, and every
/// picture is named.
#[test]
fn every_case_says_where_it_is_shown() {
    let levels = read();
    let names: Vec<_> = levels.iter().map(|l| l.name.clone()).collect();
    assert_eq!(names, table::cases_at_the_unit());
    let files = [
        "units.rs",
        "pictures.rs",
        "voxels.rs",
        "fog.rs",
        "fields.rs",
    ];
    let verilated = files.map(tests).concat();
    let mut pictures: Vec<&str> = potamoi_analysis::hard_cases::pictures::all()
        .iter()
        .map(|s| s.name)
        .collect();
    pictures.extend(sampled::all().iter().map(|s| s.scene));
    pictures.push("voxels");
    let system = [tests("system.rs"), tests("modelled.rs")].concat();
    for (what, test) in SYSTEM {
        assert!(system.iter().any(|t| t == test), "{what}: {test}");
    }
    for level in &levels {
        let name = &level.name;
        for test in level.verilated.names() {
            assert!(verilated.contains(test), "{name}: no test {test}");
        }
        for picture in level.pictures.names() {
            assert!(
                pictures.contains(&picture.as_str()),
                "{name}: no picture {picture}"
            );
        }
        for frames in level.system.names() {
            let known = SYSTEM.iter().any(|(what, _)| what == frames);
            assert!(known, "{name}: no frames of {frames}");
        }
    }
    for picture in pictures {
        let named = levels
            .iter()
            .flat_map(|l| l.pictures.names())
            .any(|p| p == picture);
        assert!(named, "{picture} shows no case");
    }
    table::compare(
        ["<!-- levels -->\n", "<!-- end of levels -->\n"],
        &written(),
        || {},
    );
}
