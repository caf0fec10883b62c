//! `potamoi cost --scene`: what accuracy costs in time.

use std::path::Path;

use crate::common::{json, potamoi, stderr, stdout};
use serde_json::Value;

/// Runs in a folder of its own.
pub(crate) fn cost(folder: &Path, code: i32, arguments: &[&str]) -> String {
    cost_of(&["cost"], folder, code, arguments)
}

/// The same of a configuration of few lanes and banks, whose models are built soon.
fn cost_of_few(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let few = "[gu]\nbanks = 8\n[vu]\nlanes = 2\n";
    std::fs::write(folder.join("few.toml"), few).unwrap();
    cost_of(&["--config", "few.toml", "cost"], folder, code, arguments)
}

fn cost_of(command: &[&str], folder: &Path, code: i32, arguments: &[&str]) -> String {
    let output = potamoi()
        .current_dir(folder)
        .args(command)
        .args(arguments)
        .output()
        .unwrap();
    let said = stdout(&output) + &stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{said}");
    said
}

pub(crate) fn number(of: &Value, field: &str) -> f64 {
    of[field]
        .as_f64()
        .unwrap_or_else(|| panic!("{field} in {of}"))
}

pub(crate) fn point<'a>(report: &'a Value, knob: &str, setting: &str) -> &'a Value {
    let is_it = |p: &&Value| p["knob"] == knob && p["setting"] == setting;
    let points = report["points"].as_array().unwrap();
    let found = points.iter().find(is_it);
    found.unwrap_or_else(|| panic!("no {knob} {setting} among {points:?}"))
}

/// More iterations take more time and are nearer; no unit is farther off than its bound.
#[test]
fn iterations_trade_time_for_quality() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let arguments = [
        "--scene",
        "garden",
        "--width",
        "12",
        "--knobs",
        "iterations,early-out,order",
        "--ladder",
        "--json",
        "c.json",
        "--csv",
        "c.csv",
        "--plot",
        "c.svg",
    ];
    let said = cost(at, 0, &arguments);
    for part in [
        "iterations 10 (iterations of the exponential): ",
        "order streamed",
        "fidelity",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let report = json(&at.join("c.json"));
    let ladder = report["ladder"].as_array().unwrap();
    let [_, cycles, verilated] = ladder.as_slice() else {
        panic!("{ladder:?}")
    };
    for unit in ["gather_cycles", "vector_cycles"] {
        assert!(number(verilated, unit) > 0.0);
        assert_eq!(cycles[unit], verilated[unit]);
    }
    let default = point(&report, "default", "");
    let of = |n: &str| point(&report, "iterations", n);
    let all = [of("8"), of("12"), default, of("24")];
    let db = |p: &Value| number(&p["float"], "db");
    for pair in all.windows(2) {
        assert!(number(pair[0], "frame_ns") < number(pair[1], "frame_ns"));
        // With more iterations than eight the other roundings hide the exponential's.
        assert!(db(of("8")) < db(pair[1]));
        let ulp = |p: &Value| number(&p["units"]["exponential"], "max_ulp");
        assert!(ulp(pair[0]) > ulp(pair[1]));
    }
    for p in report["points"].as_array().unwrap() {
        let exp = &p["units"]["exponential"];
        assert!(number(exp, "max_ulp") <= number(exp, "bound_ulp"), "{p}");
        if p["knob"] != "order" {
            assert!(number(&p["worst"], "part_of_bound") <= 1.0, "{p}");
            assert!(
                number(&p["worst"], "bound_db") <= number(&p["float"], "db"),
                "{p}"
            );
        }
    }
    assert!(number(point(&report, "early-out", "on"), "frame_ns") < number(default, "frame_ns"));
    let streamed = point(&report, "order", "streamed");
    assert!(number(&streamed["converged"], "db") < 60.0);

    let csv = std::fs::read_to_string(at.join("c.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + report["points"].as_array().unwrap().len());
    let columns = lines[0].split(',').count();
    assert!(
        lines.iter().all(|line| line.split(',').count() == columns),
        "{csv}"
    );
    let picture = std::fs::read_to_string(at.join("c.svg")).unwrap();
    assert!(picture.starts_with("<svg") && picture.contains("early-out"));
    // Nothing is both faster and better than a point of the front.
    let points = report["points"].as_array().unwrap();
    let place = |p: &Value| (number(p, "frame_ns"), number(&p["converged"], "db"));
    let front = report["front"].as_array().unwrap();
    assert!(!front.is_empty());
    for i in front {
        let (time, db) = place(&points[i.as_u64().unwrap() as usize]);
        let mut others = points.iter().map(place);
        assert!(!others.any(|(t, d)| t < time && d > db), "{front:?}");
    }
}

/// Settings of paths are compared on the same path: where nothing is warped the picture is the
/// default's, and what is warped is faster and worse beside converged picture and truth.
#[test]
fn settings_of_paths_are_compared_on_one_path() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let arguments = [
        "--scene",
        "cairn:voxels",
        "--width",
        "32",
        "--frames",
        "3",
        "--knobs",
        "phi,resolution",
        "--json",
        "c.json",
    ];
    cost(at, 0, &arguments);
    let report = json(&at.join("c.json"));
    assert_eq!(report["ladder"], serde_json::json!([]));
    let default = point(&report, "default", "");
    let db = |p: &Value| ["converged", "truth"].map(|beside| number(&p[beside], "db"));
    // By less than a degree this path turns nowhere.
    let still = point(&report, "phi", "1");
    assert_eq!(db(still), db(default));
    let turned = point(&report, "phi", "4");
    let half = point(&report, "resolution", "half");
    // In a picture this small, a warped frame takes longer than a full one that overlaps the next;
    // it takes less the more of it is warped.
    for (worse, slower) in [(turned, still), (half, default)] {
        for (own, whole) in db(worse).into_iter().zip(db(default)) {
            assert!(own < whole, "{worse}");
        }
        for beside in ["converged", "truth"] {
            let ssim = |p: &Value| number(&p[beside], "ssim");
            assert!(ssim(worse) < ssim(default), "{worse}");
        }
        assert!(number(worse, "frame_ns") < number(slower, "frame_ns"));
        assert!(worse["worst"].is_null(), "{worse}");
    }
}

/// The cheapest settings at nearly the default's quality take at most three quarters of its time;
/// what is written is read again, and its Verilog is held against the golden models.
#[test]
fn a_search_finds_a_cheaper_configuration_and_proves_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let knobs = [
        "--scene",
        "garden",
        "--width",
        "8",
        "--knobs",
        "iterations,early-out",
    ];
    let arguments = [&knobs[..], &["--target-psnr", "74", "--json", "c.json"]].concat();
    let said = cost_of_few(at, 0, &arguments);
    assert!(said.contains("no mismatch in any bit or cycle"), "{said}");
    let report = json(&at.join("c.json"));
    let (default, found) = (point(&report, "default", ""), &report["found"]["point"]);
    assert!(
        number(found, "frame_ns") <= 0.75 * number(default, "frame_ns"),
        "{found}"
    );
    assert!(number(&found["converged"], "db") >= 74.0);
    let written = std::fs::read_to_string(at.join("found.toml")).unwrap();
    assert!(written.contains("early_out = true"), "{written}");
    let output = potamoi()
        .current_dir(at)
        .args(["--config", "found.toml", "emit", "--out-dir", "rtl"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", stderr(&output));

    // Nothing is so good, and nothing so fast.
    for (goal, number) in [("--target-psnr", "500"), ("--budget-ms", "0.000001")] {
        let knobs = "--scene garden --width 8 --knobs early-out";
        let asked = knobs.split(' ').chain([goal, number]);
        let said = cost_of_few(at, 4, &asked.collect::<Vec<_>>());
        assert!(said.contains("no settings reach it"), "{said}");
    }
}

/// Of all that is good enough nothing by itself has less of what was asked for, which need not be
/// what is fastest.
#[test]
fn the_cheapest_is_by_what_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let asked = "--scene garden --width 8 --knobs pieces,iterations --target-psnr 70 --by area --json c.json";
    cost_of_few(at, 0, &asked.split(' ').collect::<Vec<_>>());
    let report = json(&at.join("c.json"));
    let found = &report["found"]["point"];
    assert!(number(&found["converged"], "db") >= 70.0, "{found}");
    let points = report["points"].as_array().unwrap();
    let good = points
        .iter()
        .filter(|p| number(&p["converged"], "db") >= 70.0);
    let known = good.clone().filter(|p| p["area_mm2"].is_number());
    assert!(known.clone().count() > 4, "{points:?}");
    for p in known {
        assert!(number(found, "area_mm2") <= number(p, "area_mm2"), "{p}");
    }
    let mut is_faster = good.map(|p| number(p, "frame_ns") < number(found, "frame_ns"));
    assert!(is_faster.any(|is| is), "pieces are faster, and larger");

    let asked = "--scene garden --width 8 --knobs early-out --target-psnr 500 --by energy";
    let said = cost_of_few(at, 4, &asked.split(' ').collect::<Vec<_>>());
    assert!(said.contains(" mJ a frame"), "{said}");
}

/// Where the truth is known it says how good a picture is: beside the converged picture of the model, which
/// has the same samples, fewer of them are worse much sooner.
#[test]
fn a_search_is_beside_the_truth_where_that_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let run = |more: &str| {
        let asked = format!("--scene cairn:voxels --width 24 --json c.json {more}");
        let said = cost_of_few(at, 0, &asked.split(' ').collect::<Vec<_>>());
        (said, json(&at.join("c.json")))
    };
    let (_, report) = run("--knobs sums");
    let [truth, converged] =
        ["truth", "converged"].map(|beside| number(&point(&report, "default", "")[beside], "db"));
    assert!(truth + 20.0 < converged);
    let goal = format!("--target-psnr {} --by energy", truth - 0.5);
    let (said, report) = run(&format!("--knobs step,stop {goal}"));
    let found = &report["found"]["point"];
    assert!(said.contains("dB PSNR to truth"), "{said}");
    assert!(number(&found["truth"], "db") >= truth - 0.5, "{found}");
    // Settings that take less would do beside the converged picture.
    let points = report["points"].as_array().unwrap();
    let would_do = |p: &Value| {
        number(&p["converged"], "db") >= truth - 0.5
            && number(p, "energy_mj") < number(found, "energy_mj")
    };
    assert!(points.iter().any(would_do), "{points:?}");
}

/// Time and energy of a frame are those of the same frame in the system's model.
#[test]
fn a_frame_takes_what_the_model_of_the_system_says() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    cost(
        at,
        0,
        &"--scene lantern --width 24 --frames 2 --knobs sums --json c.json"
            .split(' ')
            .collect::<Vec<_>>(),
    );
    let report = json(&at.join("c.json"));
    let default = point(&report, "default", "");
    let asked =
        "model --scene lantern --width 24 --frames 2 --variants baseline,fs+gu --json m.json";
    let output = potamoi()
        .current_dir(at)
        .args(asked.split(' '))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let model = json(&at.join("m.json"));
    let found = &model["scenes"][0]["outcomes"][1];
    assert_eq!(found["variant"]["name"], "fs+gu", "{found}");
    // `cost` has the geometric mean of the GPU's bounds. Memory is at the rates of streams here, and
    // replayed there: up to 6 % apart (docs/explanation/system.md). The camera stands still here, and there
    // turns by a degree or two between both frames.
    let mean = |of: &dyn Fn(&Value) -> f64| {
        let run = &found["run"];
        (of(&run["max"]) * of(&run["sum"])).sqrt()
    };
    let energy = |run: &Value| {
        let parts = run["energy"].as_object().unwrap().values();
        parts.filter_map(Value::as_f64).sum()
    };
    for (own, of) in [
        ("frame_ns", mean(&|run| number(run, "span_ns") / 2.0)),
        ("energy_mj", mean(&energy)),
    ] {
        let own = number(default, own);
        assert!((own / of - 1.0).abs() < 0.06, "{own} beside {of}");
    }
}

/// What is not of a configuration is written as a description has it: with both a frame takes the
/// time that was found.
#[test]
fn what_is_found_can_be_asked_for_again() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let asked = "--scene lantern --width 16 --knobs stop,step --target-psnr 40 --json c.json";
    cost_of_few(at, 0, &asked.split(' ').collect::<Vec<_>>());
    let found = json(&at.join("c.json"))["found"]["point"].clone();
    let written = std::fs::read_to_string(at.join("found.toml")).unwrap();
    assert!(written.contains("[render]"), "{written}");
    let again = "--scene lantern --width 16 --knobs sums --json d.json";
    let output = potamoi()
        .current_dir(at)
        .args(["--config", "found.toml", "cost"])
        .args(again.split(' '))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let report = json(&at.join("d.json"));
    let same = point(&report, "default", "");
    for field in ["frame_ns", "energy_mj"] {
        assert_eq!(number(same, field), number(&found, field), "{written}");
    }
}

/// Forms of the exponential stand beside what others use; none exceeds its bound.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn forms_of_the_exponential_stand_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let said = cost(
        at,
        0,
        &[
            "--study", "methods", "--json", "m.json", "--plot", "m.svg", "--csv", "m.csv",
        ],
    );
    assert!(
        said.contains("faithful form with the fewest clocks, of those synthesised: "),
        "{said}"
    );
    let report = json(&at.join("m.json"));
    let methods = report["methods"].as_array().unwrap();
    let of = |name: &str| methods.iter().find(|m| m["name"] == name).unwrap();
    let mut unbuilt = 0;
    for own in methods {
        assert_eq!(own["monotone"], true, "{own}");
        // Nothing bounds, or draws, what is not generated.
        match own["bound_ulp"].as_f64() {
            Some(bound) => assert!(number(own, "max_ulp") <= bound, "{own}"),
            None => {
                assert!(own["area_mm2"].is_null(), "{own}");
                unbuilt += 1;
            }
        }
    }
    assert_eq!(unbuilt, 7);
    // Measured exhaustively before (docs/reference/vector-unit.md).
    let paper = of("restoring, n = 16 (the paper's)");
    assert!((number(paper, "max_ulp") - 0.9728).abs() < 1e-4 && number(paper, "clocks") == 20.0);
    let cheapest = of(report["cheapest_faithful"].as_str().unwrap());
    assert!(number(cheapest, "max_ulp") < 1.0 && number(cheapest, "clocks") == 1.0);
    assert!(cheapest["area_mm2"].is_number(), "{cheapest}");
    // Half a step of a table at the start, where the exponential is steepest.
    let peers = report["peers"].as_array().unwrap();
    let table = peers
        .iter()
        .find(|p| p["name"] == "a table of 1024 entries")
        .unwrap();
    assert!((number(table, "max_ulp") - 256.0).abs() < 1.5, "{table}");
    assert!(
        std::fs::read_to_string(at.join("m.svg"))
            .unwrap()
            .contains("straight pieces")
    );
    let lines = std::fs::read_to_string(at.join("m.csv")).unwrap();
    assert_eq!(lines.lines().count(), 1 + methods.len() + peers.len());
    assert!(
        lines.contains("\n\"restoring, n = 16 (the paper's)\","),
        "{lines}"
    );
}
