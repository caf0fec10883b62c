//! Machines side by side, sweeps, and the search: from plans and files to rows.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::{expect, json, potamoi};

/// Longest line of a table, in characters.
const COLUMNS: usize = 100;

fn assert_narrow(text: &str) {
    for line in text
        .lines()
        .filter(|line| line.contains(" x ") || line.contains("GHz"))
    {
        assert!(line.chars().count() <= COLUMNS, "{line}");
    }
}

/// Rows of a CSV file, by name of the column.
fn rows(path: &Path) -> Vec<std::collections::BTreeMap<String, String>> {
    let text = fs::read_to_string(path).unwrap();
    let split = |line: &str| -> Vec<String> {
        // Reasons of refusals alone have commas, in quotes, and stand last.
        let (plain, quoted) = match line.split_once('"') {
            Some((plain, rest)) => (
                plain.trim_end_matches(','),
                Some(rest.trim_end_matches('"')),
            ),
            None => (line, None),
        };
        let cells = plain.split(',').chain(quoted);
        cells.map(str::to_owned).collect()
    };
    let mut lines = text.lines();
    let names = split(lines.next().unwrap());
    let each = lines.map(|line| names.iter().cloned().zip(split(line)).collect());
    each.collect()
}

#[test]
fn rivals_stand_on_the_counted_trace() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "compare", "--rivals", "--csv", "r.csv", "--json", "r.json", "paper",
    ];
    let text = expect(folder.path(), 0, &arguments);
    let table = text.split_once("\ngarden ").unwrap().1;
    for line in table.lines().filter(|line| !line.starts_with("  ")) {
        assert!(line.chars().count() <= COLUMNS, "{line}");
    }
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
        "32",
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

const PLAN: &str = "scenes = [\"garden\"]\nwidth = 48\n[vary]\n\"vu.lanes\" = { from = 2, to = 16, step = 1 }\n\
    \"system.memory_channels\" = [1, 2, 4]\n\"gu.banks\" = [16, 0, 32]\nclock_ghz = [\"reached\", 1.0]\n";

#[test]
fn a_killed_sweep_goes_on_with_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("plan.toml"), PLAN).unwrap();
    let sweep = |out: &'static str| {
        [
            "sweep",
            "plan.toml",
            "--work-dir",
            out,
            "--front",
            "fps,mm2",
        ]
    };
    let whole = expect(path, 0, &sweep("whole"));
    assert!(whole.contains("270 points: 181 evaluated now"), "{whole}");
    assert!(
        whole.contains("90 without figures") && whole.contains("gu.banks"),
        "{whole}"
    );
    let mut child = potamoi()
        .current_dir(path)
        .args(sweep("killed"))
        .spawn()
        .unwrap();
    let journal = path.join("killed/journal.jsonl");
    let lines = || fs::read_to_string(&journal).map_or(0, |text| text.lines().count());
    let begun = Instant::now();
    while lines() < 40 && begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = lines() - 1;
    assert!((39..181).contains(&before), "{before}");
    let resumed = expect(path, 0, &sweep("killed"));
    let count = |text: &str, after: &str| -> usize {
        let at = text.find(after).unwrap();
        let digits = text[..at].rsplit(' ').next().unwrap();
        digits.parse().unwrap()
    };
    let (read, now) = (
        count(&resumed, " read from"),
        count(&resumed, " evaluated now"),
    );
    // The last line may have been torn.
    assert!(read + now == 181 && before - read <= 1, "{resumed}");
    let bytes = |of: &str| fs::read(path.join(of).join("rows.csv")).unwrap();
    assert!(bytes("whole") == bytes("killed"));
    let again = expect(
        path,
        0,
        &[&sweep("killed")[..], &["--beside", "whole"]].concat(),
    );
    assert!(
        again.contains(": 0 evaluated now") && again.contains("0 figures differ"),
        "{again}"
    );
    assert_narrow(&again);
}

/// On one thread of the pool, too.
#[test]
fn a_sweep_has_the_same_bytes_on_one_thread() {
    let folder = tempfile::tempdir().unwrap();
    let plan = "scenes = [\"lantern\"]\nwidth = 16\n[vary]\n\"vu.lanes\" = [3, 6]\n\"gu.ports\" = [1, 2]\n";
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    for (out, threads) in [("one", "1"), ("many", "4")] {
        let mut command = potamoi();
        command
            .current_dir(folder.path())
            .env("RAYON_NUM_THREADS", threads);
        let done = command
            .args(["sweep", "plan.toml", "--work-dir", out])
            .output()
            .unwrap();
        assert!(done.status.success());
    }
    let bytes = |of: &str| fs::read(folder.path().join(of).join("rows.csv")).unwrap();
    assert!(bytes("one") == bytes("many"));
}

/// A sweep without a figure is no success, and its rows say why.
#[test]
fn a_sweep_of_refused_points_alone_fails() {
    let folder = tempfile::tempdir().unwrap();
    let plan =
        "machines = [\"lean-splats\"]\nscenes = [\"lantern\"]\nwidth = 8\n[workload]\nframes = 1\n";
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    let text = expect(
        folder.path(),
        2,
        &["sweep", "plan.toml", "--work-dir", "out"],
    );
    assert!(text.contains("no point has figures"), "{text}");
    let rows = fs::read_to_string(folder.path().join("out/rows.csv")).unwrap();
    assert!(rows.contains("relu"), "{rows}");
}

#[test]
fn mistakes_of_a_plan_are_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    for (plan, said) in [
        ("[vary]\n\"vu.lnes\" = [3]", "vu.lnes"),
        ("[vary]\n\"vu.lanes\" = 3", "a list of values"),
        (
            "[vary]\n\"vu.lanes\" = { from = 3, to = 1, step = 1 }",
            "does not end",
        ),
        ("sceens = [\"garden\"]", "sceens"),
        ("scenes = [\"gardn\"]", "gardn"),
        ("machines = [\"papr\"]", "papr"),
        ("[workload]\nframes = 0", "1 frame or more"),
        (
            "[[together]]\n\"vu.lanes\" = [1, 2]\n\"gu.ports\" = [1]",
            "equally long",
        ),
        (
            "[vary]\n\"vu.lanes\" = [1]\n[[together]]\n\"vu.lanes\" = [2]",
            "varies twice",
        ),
    ] {
        fs::write(folder.path().join("plan.toml"), plan).unwrap();
        let text = expect(
            folder.path(),
            2,
            &["sweep", "plan.toml", "--work-dir", "out"],
        );
        assert!(text.contains(said), "{plan}: {text}");
        assert!(!folder.path().join("out").exists(), "{plan}");
    }
    fs::write(folder.path().join("plan.toml"), "").unwrap();
    let arguments = ["sweep", "plan.toml", "--work-dir", "out", "--front", "psnr"];
    let text = expect(folder.path(), 2, &arguments);
    assert!(
        text.contains("--front psnr") && text.contains("did you mean `psnr_db`?"),
        "{text}"
    );
}

/// Another plan in a used folder takes the place of its rows, which are named; a finished folder lacks
/// nothing; and a figure that no row has is on no front.
#[test]
fn what_a_used_folder_has_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let plan = |name: &str, lanes: &str| {
        let text = format!(
            "width = 8\n[workload]\nframes = 2\nquality = false\n[vary]\n\"vu.lanes\" = [{lanes}]\n"
        );
        fs::write(folder.path().join(name), text).unwrap();
    };
    plan("a.toml", "3, 6");
    plan("b.toml", "6, 12");
    let sweep = |plan: &str, more: &[&str]| {
        let all = [&["sweep", plan, "--work-dir", "w"][..], more].concat();
        expect(folder.path(), 0, &all)
    };
    let rows = || fs::read_to_string(folder.path().join("w/rows.csv")).unwrap();
    sweep("a.toml", &[]);
    let first = rows();
    let text = sweep("a.toml", &["--missing"]);
    assert!(text.contains("note: w lacks no point of a.toml"), "{text}");
    assert!(sweep("b.toml", &["--missing"]).contains("\"number\":1"));
    assert!(!sweep("a.toml", &[]).contains("another plan"));
    let text = sweep("b.toml", &["--front", "psnr_db,fps"]);
    assert!(
        text.contains("note: w/rows.csv had 1 row of another plan"),
        "{text}"
    );
    assert!(text.contains("0 of 2 rows"), "{text}");
    assert!(
        text.contains("psnr_db is not known for 2 of 2 rows"),
        "{text}"
    );
    assert!(text.contains("quality = false"), "{text}");
    sweep("a.toml", &[]);
    assert_eq!(rows(), first);
}

#[test]
fn what_the_search_finds_is_a_machine_for_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let search = [
        "explore",
        "small",
        "--scene",
        "garden",
        "--width",
        "16",
        "--vary",
        "vu.lanes=2..6:+1",
        "--vary",
        "vu.exp.pipelined=false,true",
        "--vary",
        "system.memory_channels=2,4",
        "--vary",
        "clock=reached,0.5",
        "--max-area",
        "1.2",
        "--min-psnr",
        "60",
        "--objective",
        "fps",
        "--json",
        "e.json",
    ];
    let text = expect(path, 0, &search);
    assert_narrow(&text);
    assert!(text.contains("every point of the space: 40"), "{text}");
    assert!(text.contains("no mismatch in any bit or cycle"), "{text}");
    let found = fs::read_to_string(path.join("found.toml")).unwrap();
    assert!(!found.contains("not verified"), "{found}");
    let small = ["--width", "16", "--scene", "garden"];
    let on = |command: &[&str]| expect(path, 0, &[command, &small].concat());
    on(&[
        "model",
        "--config",
        "found.toml",
        "--frames",
        "2",
        "--variants",
        "fs+gu",
    ]);
    on(&["compare", "paper", "found.toml"]);
    on(&["verify", "--config", "found.toml"]);
    expect(
        path,
        0,
        &["emit", "--config", "found.toml", "--out-dir", "rtl"],
    );
    let report = json(&path.join("e.json"));
    assert!(report["proofs"][0]["elements"][0].as_u64().unwrap() > 0);
    // No point that keeps the limits is faster.
    let at = |name: &str| {
        let columns = report["columns"].as_array().unwrap();
        columns.iter().position(|own| own == name).unwrap()
    };
    let tried = report["trials"]["tried"].as_array().unwrap();
    let best = report["trials"]["best"].as_u64().unwrap() as usize;
    let fps = |own: &serde_json::Value| own["scenes"][0]["Ok"][at("fps")].as_f64();
    let most = tried
        .iter()
        .filter(|own| own["keeps_limits"] == true)
        .filter_map(fps);
    assert_eq!(most.fold(0.0, f64::max), fps(&tried[best]).unwrap());
    let front = report["trials"]["front"].as_array().unwrap();
    assert_eq!(front[0].as_u64().unwrap() as usize, best);
    assert!(text.contains("front of fps, area and quality"), "{text}");
    let out_of_reach = [&search[..16], &["--min-fps", "1e9"]].concat();
    let text = expect(path, 4, &out_of_reach);
    assert!(
        text.contains("no machine that was tried keeps the limits"),
        "{text}"
    );
}

/// What the search over settings writes beside the configuration is honoured by every command.
#[test]
fn what_cost_finds_is_a_machine_for_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let small = ["--width", "16", "--scene", "garden"];
    let on = |command: &[&str]| expect(path, 0, &[command, &small].concat());
    let search = [
        "--config",
        "small",
        "cost",
        "--knobs",
        "stop",
        "--target-psnr",
        "25",
    ];
    on(&search);
    let found = fs::read_to_string(path.join("found.toml")).unwrap();
    assert!(found.contains("[render]"), "{found}");
    on(&["compare", "small", "found.toml"]);
    on(&["model", "--config", "found.toml", "--frames", "2"]);
    on(&["verify", "--config", "found.toml"]);
    let arguments = ["emit", "--config", "found.toml", "--out-dir", "rtl"];
    let text = expect(path, 0, &arguments);
    assert!(text.contains("emit does not use [render]"), "{text}");
    // The settings of rendering are those of the file.
    let drawn = |config: &str, report: &str| {
        let own = [
            "render", "--config", config, "--out", "p.png", "--json", report,
        ];
        on(&own);
        json(&path.join(report))["float"]["db"].as_f64()
    };
    assert_ne!(drawn("found.toml", "f.json"), drawn("small", "s.json"));
}

/// A search that was interrupted, and one with the same seed, try the same points.
#[test]
fn a_search_is_its_seed() {
    let folder = tempfile::tempdir().unwrap();
    let search = |out: &'static str, json: &'static str| {
        let arguments = [
            "explore",
            "small",
            "--width",
            "16",
            "--vary",
            "system.array_columns=8..32:+4",
            "--vary",
            "system.memory_channels=1,2,4,8",
            "--vary",
            "system.array_rows=8..32:+4",
            "--objective",
            "energy",
            "--max-area",
            "1.1",
            "--budget",
            "24",
            "--work-dir",
            out,
            "--json",
            json,
        ];
        expect(folder.path(), 0, &arguments)
    };
    let text = search("a", "a.json");
    assert!(
        text.contains("24 of 196 points, by Parzen estimators"),
        "{text}"
    );
    assert!(
        text.contains("by a random search of the same budget"),
        "{text}"
    );
    search("b", "b.json");
    search("a", "again.json");
    let bytes = |of: &str| fs::read(folder.path().join(of)).unwrap();
    assert!(bytes("a.json") == bytes("b.json") && bytes("a.json") == bytes("again.json"));
}

/// Points without figures are told by their reason, and a file of an earlier search for what it is.
#[test]
fn why_a_search_finds_nothing_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("found.toml"), "preset = \"paper\"\n").unwrap();
    let search = |vary: &'static str| {
        let size = ["--width", "8", "--frames", "1", "--vary", vary];
        [&["explore", "paper"][..], &size].concat()
    };
    let text = expect(path, 4, &search("vu.exp.form=piecewise"));
    for part in [
        "no figures of 1 of 1 points",
        "vu.exp.pipelined",
        "has figures",
        "found.toml is of an earlier search",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let text = expect(path, 4, &search("system.memory_channels=1"));
    assert!(text.contains("is better than paper"), "{text}");
    let kept = fs::read_to_string(path.join("found.toml")).unwrap();
    assert_eq!(kept, "preset = \"paper\"\n");
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
        assert!(text.contains(&format!("  {gpu}, as lean-splats")), "{text}");
    }
}
