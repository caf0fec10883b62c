//! `potamoi model`: variants of the system side by side.

use std::path::Path;

use crate::common::{json, potamoi, stderr, stdout, words};
use serde_json::Value;

/// Runs with a cache of its own.
fn model(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let output = potamoi()
        .current_dir(folder)
        .env("POTAMOI_CACHE", folder.join("cache"))
        .arg("model")
        .args(arguments)
        .output()
        .unwrap();
    let said = stdout(&output) + &stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{said}");
    said
}

fn number(value: &Value, path: &str) -> f64 {
    value
        .pointer(path)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("{path} in {value}"))
}

#[test]
fn variants_stand_beside_the_baseline_and_the_paper() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let arguments = [
        "--scene",
        "lantern",
        "--width",
        "48",
        "--frames",
        "6",
        "--window",
        "3",
        "--scenario",
        "both",
        "--json",
        "r.json",
        "--chrome-trace",
        "t.json",
        "--plot-energy",
        "e.svg",
        "--plot-roofline",
        "r.svg",
    ];
    let said = model(at, 0, &arguments);
    for part in [
        "Local rendering",
        "Remote rendering",
        "the paper's mean",
        "53.1",
        "the GPU alone",
        "a ratio that includes 1 is no conclusion",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let report = json(&at.join("r.json"));
    let scene = &report["scenes"][0];
    let outcomes = scene["outcomes"].as_array().unwrap();
    assert_eq!(outcomes.len(), 16);
    let of = |scenario: &str, name: &str| {
        let same = |o: &&Value| o["scenario"] == scenario && o["variant"]["name"] == name;
        outcomes.iter().find(same).unwrap()
    };
    let span = |scenario: &str, name: &str| number(of(scenario, name), "/run/max/span_ns");
    assert!(span("local", "sparw") < span("local", "baseline"));
    assert!(span("local", "potamoi") < span("local", "fs+gu"));
    let gathering = |name: &str| {
        let stage = |field| {
            number(
                of("local", name),
                &format!("/run/max/stages/gathering/{field}_ns"),
            )
        };
        stage("own") + stage("memory")
    };
    assert!(gathering("potamoi") > 0.0 && gathering("sparw+fs") > 0.0);
    assert_ne!(gathering("potamoi"), gathering("sparw+fs"));
    // Over the link a raw frame takes three bytes a pixel at 10 MB/s.
    let sent = 48.0 * 48.0 * 3.0;
    let link = number(of("remote", "baseline"), "/run/max/stages/link/own_ns");
    assert!((link - sent * 100.0).abs() < 1e-6, "{link}");
    let alone = |bound: &str| number(scene, &format!("/gpu_only/fused/frame_ns/{bound}"));
    assert!(0.0 < alone("max") && alone("max") < alone("sum"));
    for outcome in outcomes {
        let spans = ["max", "sum"].map(|at| number(outcome, &format!("/run/{at}/span_ns")));
        assert!(spans[0] <= 1.05 * spans[1], "{spans:?}");
        assert!(number(outcome, "/run/max/free_units_ns") <= spans[0]);
    }
    for outcome in outcomes.iter().map(|o| &o["run"]["max"]) {
        let parts = outcome["energy"].as_object().unwrap();
        assert_eq!(parts.len(), 11);
        // The data lines are a part of two of them.
        let of_memory = ["memory_mj", "dma_mj"].map(|part| parts[part].as_f64().unwrap());
        let lines = number(outcome, "/memory_io_mj");
        assert!(0.0 < lines && lines < of_memory.iter().sum::<f64>());
        assert!(parts.values().all(|mj| mj.as_f64().unwrap() >= 0.0));
        let utilisation = outcome["utilisation"].as_object().unwrap();
        assert!(
            utilisation
                .values()
                .all(|share| share.as_f64().unwrap() <= 1.0 + 1e-9)
        );
        let fps = number(outcome, "/frames_per_second");
        assert!((fps - 6e9 / number(outcome, "/span_ns")).abs() < 1e-6 * fps);
    }
    // Neighbours miss what lies in rows that are open.
    assert_eq!(scene["fidelity"], "cycle models");
    let misses = |way: &str| number(scene, &format!("/memory/full/missed/{way}/ns"));
    assert!(misses("replayed") < misses("at_rates"));
    assert!(
        said.contains("memory, with their accesses replayed: "),
        "{said}"
    );
    // The GPU and memory (four channels of two ranks) are counted, and the remote GPU's energy stands apart.
    for outcome in outcomes {
        let is_remote = outcome["scenario"] == "remote";
        let outcome = &outcome["run"]["sum"];
        let frames = 6.0;
        let us = number(outcome, "/span_ns") * 1e-3;
        let refreshes = number(outcome, "/refreshes");
        assert!(
            (refreshes - 8.0 * us / 3.9).abs() <= 8.0,
            "{refreshes} {us}"
        );
        assert!(number(outcome, "/spent/rows_opened") > 0.0);
        assert_eq!(outcome["remote_mj"].is_number(), is_remote);
        if is_remote {
            let busy = number(outcome, "/utilisation/remote");
            let watts = 260.0 * busy + 15.0 * (1.0 - busy);
            let mj = number(outcome, "/remote_mj");
            assert!((mj - watts * us * 1e-3 / frames).abs() < 1e-6 * mj);
        }
    }
    let instructions = |name: &str| number(of("local", name), "/run/max/spent/gpu/instructions");
    assert!(instructions("baseline") > instructions("fs+gu"));
    assert!(instructions("sparw") < instructions("baseline"));
    assert!(said.contains("remote GPU, mJ, not the device's"), "{said}");
    assert!(words(&said).contains("260 W active, 15 W idle"), "{said}");
    // Only the gathering unit's variants spend on it.
    let spent = |name: &str| number(of("local", name), "/run/max/energy/gathering_unit_mj");
    assert!(spent("potamoi") > 0.0 && spent("fs+gu") > spent("potamoi") && spent("sparw") == 0.0);

    let trace = json(&at.join("t.json"));
    let events = trace["traceEvents"].as_array().unwrap();
    let name = |name: &str| events.iter().filter(|e| e["name"] == name).count();
    assert!(
        name("warping") == 4 && name("thread_name") >= 3,
        "{events:?}"
    );
    // Memory is shared, and at rest at the end.
    let moving: Vec<f64> = (events.iter().filter(|e| e["name"] == "memory"))
        .map(|e| number(e, "/args/jobs that move bytes"))
        .collect();
    assert!(moving.iter().any(|jobs| *jobs >= 1.0), "{moving:?}");
    assert_eq!(moving.last(), Some(&0.0));
    for file in ["e.svg", "r.svg"] {
        let picture = std::fs::read_to_string(at.join(file)).unwrap();
        assert!(
            picture.starts_with("<svg") && picture.contains("potamoi"),
            "{file}"
        );
    }

    // The same again, from what was counted.
    let again = model(at, 0, &arguments);
    assert!(again.contains("counted earlier") && !said.contains("counted earlier"));
    let mut second = json(&at.join("r.json"));
    assert_eq!(second["scenes"][0]["was_kept"], true);
    second["scenes"][0]["was_kept"] = false.into();
    assert_eq!(second, report);

    // A system of half the memory and a tenth of the link.
    std::fs::write(
        at.join("s.toml"),
        "memory_channels = 2\nlink_bytes_per_second = 1e6\n",
    )
    .unwrap();
    model(at, 0, &[&arguments[..], &["--system", "s.toml"]].concat());
    let slower = json(&at.join("r.json"));
    let first = |of: &Value, scenario: &str| {
        let all = of["scenes"][0]["outcomes"].as_array().unwrap();
        all.iter()
            .find(|o| o["scenario"] == scenario)
            .map(|o| number(o, "/run/max/span_ns"))
            .unwrap()
    };
    assert!(first(&slower, "local") > first(&report, "local"));
    assert!(first(&slower, "remote") > 5.0 * first(&report, "remote"));
}

#[test]
fn scenes_stand_side_by_side_with_their_means() {
    let folder = tempfile::tempdir().unwrap();
    let size = [
        "--width", "24", "--height", "24", "--frames", "3", "--window", "2",
    ];
    let scenes = [
        "--scenes",
        "garden,lantern",
        "--variants",
        "potamoi",
        "--json",
        "r.json",
    ];
    let said = model(folder.path(), 0, &[&size[..], &scenes].concat());
    assert!(
        said.contains("geometric mean") && said.contains("lantern"),
        "{said}"
    );
    let report = json(&folder.path().join("r.json"));
    assert_eq!(report["scenes"].as_array().unwrap().len(), 2);
    assert_eq!(report["scenes"][1]["outcomes"].as_array().unwrap().len(), 2);
    // Splats have pairs of pixel and Gaussian, in full frames and in the rest; fields have none.
    for part in ["full", "rest"] {
        let pairs = |kind: &str| {
            number(
                &report["scenes"][0]["splats"][part],
                &format!("/pairs_{kind}"),
            )
        };
        assert!(pairs("drawn") > 0.0 && pairs("stopped") >= 0.0, "{part}");
        assert!(
            4.0 * (pairs("drawn") + pairs("stopped")) < pairs("evaluated"),
            "{part}"
        );
    }
    assert!(report["scenes"][1]["splats"].is_null());
}

#[test]
fn merging_cells_is_compared_with_leaving_them() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "--octree", "--scene", "garden", "--width", "64", "--json", "r.json",
    ];
    let said = model(folder.path(), 0, &arguments);
    assert!(said.contains("the paper: 7.2 > 172.8"), "{said}");
    assert!(said.contains("garden, 64 x "), "{said}");
    let report = json(&folder.path().join("r.json"));
    let [before, after] = [0, 1].map(|i| report["scenes"][0]["sides"][i].clone());
    assert!(number(&after, "/points_a_mvoxel") > 1.5 * number(&before, "/points_a_mvoxel"));
    assert!(number(&after, "/done/mvoxels") < number(&before, "/done/mvoxels"));
    // The same entries, in fewer MVoxels.
    assert_eq!(after["done"]["entries"], before["done"]["entries"]);
    // Hence fewer descriptors.
    for less in ["/done/array_cycles", "/gathering_pj"] {
        assert!(number(&after, less) < number(&before, less), "{less}");
    }
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn three_ways_to_a_frame_differ_as_they_say() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["garden", "lantern", "cairn:dvgo"] {
        let arguments = [
            "--ladder", "--scene", scene, "--width", "32", "--json", "r.json",
        ];
        model(folder.path(), 0, &arguments);
        let report = json(&folder.path().join("r.json"));
        let own = &report["scenes"][0];
        let [formulas, models, rtl] = [0, 1, 2].map(|i| own["rungs"][i].clone());
        for field in ["gather_cycles", "vector_cycles", "frame_ns"] {
            let of = |rung: &Value| number(rung, &format!("/{field}"));
            assert_eq!(of(&models), of(&rtl), "{scene} {field}");
            assert!(
                0.0 < of(&formulas) && of(&formulas) <= 1.01 * of(&rtl),
                "{scene} {field}"
            );
        }
        // Two streams side by side are no faster than one.
        let loads = |way: &str| number(own, &format!("/memory/loaded/{way}/ns"));
        assert!(loads("replayed") > 0.98 * loads("at_rates"), "{scene}");
    }
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn accelerators_for_instant_ngp_are_compared_on_it() {
    let folder = tempfile::tempdir().unwrap();
    let size = [
        "--width", "40", "--height", "40", "--frames", "4", "--window", "4",
    ];
    let arguments = ["--rivals", "--scene", "cairn:ngp", "--json", "r.json"];
    let said = model(folder.path(), 0, &[&size[..], &arguments].concat());
    assert!(said.contains("NeuRex") && said.contains("NGPC"), "{said}");
    let report = json(&folder.path().join("r.json"));
    let own = &report["scenes"][0];
    for name in ["neurex", "ngpc", "potamoi_without_sparw", "potamoi"] {
        assert!(number(own, &format!("/{name}/max")) > 0.0);
        assert!(number(own, &format!("/{name}/sum")) > 0.0);
    }
}

#[test]
fn less_is_rendered_by_the_rules_of_the_paper() {
    let folder = tempfile::tempdir().unwrap();
    let rendered = |profile| {
        let arguments =
            "--scene lantern --width 32 --frames 4 --window 4 --variants sparw --json r.json";
        let arguments: Vec<_> = arguments.split(' ').chain(["--profile", profile]).collect();
        let said = model(folder.path(), 0, &arguments);
        let is_said = said.contains("warped by the paper's rules");
        assert_eq!(is_said, profile == "paper", "{said}");
        let report = json(&folder.path().join("r.json"));
        let found = &report["scenes"][0];
        (
            number(found, "/rendered_share"),
            number(&found["outcomes"][1], "/run/max/span_ns"),
        )
    };
    let [own, paper] = ["potamoi", "paper"].map(rendered);
    assert!(paper.0 < own.0 && paper.1 < own.1, "{paper:?} {own:?}");
}

/// Speed-up and energy saving by variant where demands do not overlap, of each change of a report of `--sensitivity`.
fn rows(report: Value) -> impl Fn(&str) -> std::collections::BTreeMap<String, (f64, f64)> {
    move |change| {
        let rows = report["scenes"][0]["rows"].as_array().unwrap();
        let row = rows.iter().find(|r| r["change"] == change).unwrap();
        let means = row["means"].as_array().unwrap().iter();
        let of = |m: &Value| {
            let name = m["variant"].as_str().unwrap().to_owned();
            (name, (number(m, "/speed_up/sum"), number(m, "/saving/sum")))
        };
        means.map(of).collect()
    }
}

/// Conclusions of a report of `--sensitivity`: a slower GPU alone is easier to beat, and by no more
/// than it is slower.
fn concludes(said: &str, report: &Value) {
    let all = report["conclusions"].as_array().unwrap();
    let names: Vec<&Value> = report["errors"]
        .as_array()
        .unwrap()
        .iter()
        .map(|e| &e["name"])
        .collect();
    assert!(names.len() > 4 && all.len() > 20, "{names:?}");
    let means = |name: &str| {
        let own = report["errors"]
            .as_array()
            .unwrap()
            .iter()
            .find(|e| e["name"] == name);
        let text = own.unwrap()["means"].as_str().unwrap();
        text.split(' ').next().unwrap().parse::<f64>().unwrap()
    };
    for own in all {
        let of = own["of"].as_str().unwrap();
        assert!(said.contains(of), "{of}");
        for opened in own["open_by"].as_array().unwrap() {
            assert!(
                names.contains(&&opened[0]) && opened[1] != own["says"],
                "{own}"
            );
        }
        if own["ratio"].is_null() {
            continue;
        }
        let [max, sum, low, high] =
            ["/ratio/max", "/ratio/sum", "/within/0", "/within/1"].map(|at| number(own, at));
        assert!(low <= max.min(sum) && max.max(sum) <= high, "{own}");
        if of.ends_with("over the GPU alone") {
            let under = |name: &str| number(own, &format!("/under/{name}/sum"));
            let [fast, slow, slowest] = ["faster GPUs", "slower GPUs", "slowest GPUs"].map(under);
            assert!(fast < sum && sum < slow && slow < slowest, "{own}");
            assert!(slowest <= 1.01 * means("slowest GPUs") * sum, "{own}");
            assert!(under("wires") <= 1.01 * sum, "{own}");
        }
    }
}

#[test]
fn what_the_gpu_were_otherwise_would_change_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let sensitivity = [
        "--sensitivity",
        "--scenes",
        "lantern",
        "--width",
        "32",
        "--frames",
        "4",
        "--window",
        "2",
        "--json",
        "s.json",
    ];
    let said = model(at, 0, &sensitivity);
    assert!(
        said.contains("the device's work takes no time and no energy"),
        "{said}"
    );
    assert!(!said.contains("remote GPU"), "{said}");
    let report = json(&at.join("s.json"));
    concludes(&said, &report["scenes"][0]);
    let row = rows(report);
    let own = row("unchanged");
    assert_eq!((own.len(), own["baseline"]), (8, (1.0, 1.0)));
    // Where the GPU gathers, its rate counts; the unit does not wait for it.
    let slow = row("half the clock of the GPUs");
    assert!(slow["fs+gu"].0 > own["fs+gu"].0, "{slow:?}");
    assert_eq!(row("twice the watts")["potamoi"].0, own["potamoi"].0);
    assert_ne!(row("twice the watts")["potamoi"].1, own["potamoi"].1);

    // A faster remote GPU leaves less to speed up.
    model(
        at,
        0,
        &[&sensitivity[..], &["--scenario", "remote"]].concat(),
    );
    let remote = rows(json(&at.join("s.json")));
    let speed_up = |change: &str| remote(change)["potamoi"].0;
    let faster = speed_up("twice the remote GPU, not the device's");
    assert!(speed_up("unchanged") >= faster, "{faster}");

    // The row is what the variants take on such a system, with a device file beside it.
    let device = include_str!("../sim/gpu/devices/xavier-maxn.toml");
    let slow = device.replace("value = 1.377", "value = 0.6885");
    std::fs::write(at.join("half.toml"), slow).unwrap();
    let remote = include_str!("../sim/gpu/devices/2080ti.toml");
    std::fs::write(at.join("remote.toml"), remote).unwrap();
    let text = "gpu.device = \"half.toml\"\nremote.device = \"remote.toml\"\n";
    std::fs::write(at.join("slow.toml"), text).unwrap();
    let same = &sensitivity[1..sensitivity.len() - 1];
    model(
        at,
        0,
        &[same, &["v.json", "--system", "slow.toml"]].concat(),
    );
    let scene = &json(&at.join("v.json"))["scenes"][0];
    let span = |name: &str| {
        let all = scene["outcomes"].as_array().unwrap().iter();
        let mut own = all.filter(|o| o["variant"]["name"] == name);
        number(own.next().unwrap(), "/run/sum/span_ns")
    };
    let halved = row("half the clock of the GPUs")["potamoi"].0;
    let expected = span("baseline") / span("potamoi");
    assert!(
        (halved / expected - 1.0).abs() < 1e-9,
        "{halved} {expected}"
    );
}
