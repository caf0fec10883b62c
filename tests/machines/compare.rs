//! Machines and rivals side by side.

use std::fs;
use std::path::Path;

use super::{assert_narrow, rows};
use crate::common::{expect, json};

#[test]
fn rivals_stand_on_the_counted_trace() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "compare", "--rivals", "--csv", "r.csv", "--json", "r.json", "paper",
    ];
    let text = expect(folder.path(), 0, &arguments);
    assert_narrow(&text);
    assert!(text.contains("frozen, trace ") && !text.contains("NOT the frozen trace"));
    assert!(text.contains("1.28 times, on assumed counts"), "{text}");
    // Its bandwidth is not known, and what is not counted makes no frame faster.
    assert!(text.contains("<162641"), "{text}");
    assert!(text.contains("Cicero, full frames: - ("), "{text}");
    let report = json(&folder.path().join("r.json"));
    let inputs = report["inputs"].as_array().unwrap();
    for own in inputs {
        assert_eq!(own["digest"], own["frozen"], "{own}");
        let rivals = own["rivals"].as_array().unwrap();
        assert_eq!(rivals.len(), report["rivals"].as_array().unwrap().len());
        // A figure, or why there is none.
        for row in rivals {
            assert!(row["estimate"].is_null() != row["refused"].is_null());
        }
    }
    let csv = fs::read_to_string(folder.path().join("r.csv")).unwrap();
    let constants: Vec<&str> = csv
        .lines()
        .filter(|line| line.starts_with("constant,"))
        .collect();
    assert!(constants.len() > 50, "{csv}");
    // Nothing without a source, an assumption or a reason.
    assert!(constants.iter().all(|line| !line.ends_with(',')), "{csv}");
}

#[test]
fn sizes_of_frozen_inputs_are_fixed() {
    for arguments in [
        &["compare", "--rivals", "--width", "32"][..],
        &["compare", "--rivals", "--frames", "4"],
        &["compare"],
    ] {
        let folder = tempfile::tempdir().unwrap();
        expect(folder.path(), 2, arguments);
    }
}

#[test]
fn machines_stand_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let own =
        "preset = \"paper\"\n[vu]\nlanes = 24\n[system]\nmemory_channels = 2\n[path]\nwindow = 2\n";
    fs::write(folder.path().join("own.toml"), own).unwrap();
    let arguments = [
        "compare",
        "paper",
        "own.toml",
        "lean-splats",
        "--scene",
        "garden,lantern",
        "--width",
        "24",
        "--csv",
        "c.csv",
        "--json",
        "c.json",
        "--plot",
        "c.svg",
    ];
    let text = expect(folder.path(), 0, &arguments);
    assert_narrow(&text);
    assert!(text.contains("lean-splats is left out"), "{text}");
    assert!(text.contains("own.toml: potamoi"), "{text}");
    assert!(text.contains("xavier-maxn alone"), "{text}");
    let report = json(&folder.path().join("c.json"));
    let first = &report["scenes"][0];
    assert_eq!(first[0]["machine"], "paper");
    // The areas of the blocks, with their memories, are the whole area.
    for own in first
        .as_array()
        .unwrap()
        .iter()
        .filter(|own| !own["mm2"].is_null())
    {
        let blocks = own["blocks"].as_array().unwrap();
        let mm2 = |block: &serde_json::Value| {
            ["logic_mm2", "memories_mm2"].map(|part| block[part].as_f64().unwrap())
        };
        let sum: f64 = blocks.iter().flat_map(mm2).sum();
        assert!((sum - own["mm2"].as_f64().unwrap()).abs() < 1e-9, "{own}");
        let listed = |block: &serde_json::Value| !block["memories"].as_array().unwrap().is_empty();
        assert!(
            blocks.iter().filter(|block| listed(block)).count() >= 2,
            "{own}"
        );
    }
    assert_eq!(first[1]["memory"][1], 2);
    assert_eq!(first[1]["variant"], "potamoi");
    // The units of one and the other make the same picture, bit for bit.
    assert_eq!(first[0]["quality"], first[2]["quality"]);
    assert!(
        report["scenes"][1][2]["refused"]
            .as_str()
            .unwrap()
            .contains("relu")
    );
    let rows = rows(&folder.path().join("c.csv"));
    assert_eq!(rows.len(), 6);
    assert_eq!(rows[0]["fps_ratio"], "1");
    assert!(rows[2]["fps_ratio"].parse::<f64>().unwrap() > 1.0);
    assert!(
        fs::read_to_string(folder.path().join("c.svg"))
            .unwrap()
            .contains("frames a second")
    );
    let unused = ["emit", "--config", "own.toml", "--out-dir", "rtl"];
    let unused = expect(folder.path(), 0, &unused);
    assert!(
        unused.contains("emit does not use [system], [path]"),
        "{unused}"
    );
    let none = expect(
        folder.path(),
        2,
        &[
            "compare",
            "lean-splats",
            "--scene",
            "lantern",
            "--width",
            "16",
        ],
    );
    assert!(none.contains("lantern"), "{none}");
    let wrong = expect(folder.path(), 2, &["compare", "papr"]);
    assert!(wrong.contains("papr"), "{wrong}");
}

/// Every column has its row on the page, and the page has no other.
#[test]
fn the_columns_are_those_of_the_page() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/machines.md");
    let page = fs::read_to_string(page).unwrap();
    let (_, table) = page.split_once("## Columns").unwrap();
    let first = table.lines().filter(|line| line.starts_with("| `"));
    let mut named: Vec<String> = vec![];
    for line in first {
        for name in line.split('|').nth(1).unwrap().split(',') {
            let name = name.trim().trim_matches('`');
            let last = named.iter().rfind(|own| !own.ends_with("_low")).cloned();
            named.push(match name.starts_with('_') {
                true => last.unwrap() + name,
                false => name.to_owned(),
            });
        }
    }
    let mut columns: Vec<&str> = potamoi_machines::cells::COLUMNS
        .iter()
        .map(|own| own.name)
        .collect();
    named.sort_unstable();
    columns.sort_unstable();
    assert_eq!(named, columns);
}

/// What would not be honoured is refused or said, and no output takes the place of the rows.
#[test]
fn what_is_not_honoured_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("system.toml"), "[system]\nmemory_channels = 2\n").unwrap();
    let compare = |flag: &'static str, value: &'static str| {
        [
            "compare",
            "system.toml",
            "--width",
            "12",
            "--frames",
            "1",
            flag,
            value,
        ]
    };
    let text = expect(path, 2, &compare("--assume-clock", "2"));
    assert!(
        text.contains("system.toml names no configuration"),
        "{text}"
    );
    let text = expect(path, 0, &compare("--system", "orin-nx"));
    assert!(
        text.contains("system.toml has a [system] of its own"),
        "{text}"
    );
    fs::write(
        path.join("plan.toml"),
        "width = 12\n[workload]\nframes = 1\n",
    )
    .unwrap();
    for own in ["w/rows.csv", "w/journal.jsonl"] {
        let arguments = ["sweep", "plan.toml", "--work-dir", "w", "--json", own];
        let text = expect(path, 2, &arguments);
        assert!(text.contains("also written by"), "{text}");
    }
}

/// The frame of each GPU alone stands once for each, with its name.
#[test]
fn gpus_of_several_systems_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let systems = [
        "--width",
        "16",
        "--frames",
        "1",
        "--system",
        "xavier,orin-nx",
    ];
    let text = expect(
        folder.path(),
        0,
        &[&["compare", "paper", "lean-splats"][..], &systems].concat(),
    );
    for gpu in ["xavier-maxn", "orin-nx"] {
        assert_eq!(text.matches(&format!("{gpu} alone")).count(), 1, "{text}");
        // The same GPU at the frame of the other machine stands below it.
        let mut below = text
            .lines()
            .skip_while(|line| !line.contains(&format!("{gpu} alone")));
        let next = below.nth(1).unwrap();
        assert!(
            next.trim().starts_with("as ") && next.contains("splats"),
            "{text}"
        );
    }
}

/// Ratios are over the first machine: without its figures there are none, and the output says so. The others
/// have their figures.
#[test]
fn a_first_machine_without_figures_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let text = expect(
        folder.path(),
        0,
        &[
            "compare",
            "lean-splats",
            "paper",
            "--scene",
            "lantern,cairn:dvgo",
            "--width",
            "8",
            "--frames",
            "1",
        ],
    );
    assert_narrow(&text);
    for part in [
        "lean-splats is left out",
        "no ratios here: the first machine has no figures",
        "no means over scenes",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("geometric means"), "{text}");
}

/// What pays for an area beside the units stands below the table.
#[test]
fn a_smaller_array_is_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("small.toml"),
        "preset = \"paper\"\n[system]\narray_rows = 8\n",
    )
    .unwrap();
    let machines = [
        "compare",
        "paper",
        "small.toml",
        "--width",
        "8",
        "--frames",
        "1",
    ];
    let text = expect(folder.path(), 0, &machines);
    assert!(
        text.contains("small.toml has an array of 8 x 24 for 24 x 24\n"),
        "{text}"
    );
}
