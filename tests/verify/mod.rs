//! `potamoi verify` and `potamoi trace` from end to end.

mod real_models;
mod traces;

use crate::common::{expect, json, words};

#[test]
fn a_built_in_scene_agrees_in_every_bit_and_cycle() {
    presets_agree(&[("lantern", "paper")]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn both_built_in_scenes_agree_with_other_presets() {
    presets_agree(&[
        ("garden", "paper"),
        ("garden", "small"),
        ("lantern", "small"),
        ("garden", "fields"),
        ("garden", "piecewise"),
        ("lantern", "piecewise"),
    ]);
}

fn presets_agree(cases: &[(&str, &str)]) {
    let folder = tempfile::tempdir().unwrap();
    for &(scene, preset) in cases {
        let said = expect(
            folder.path(),
            0,
            &[
                "verify", "--config", preset, "--scene", scene, "--width", "40", "--level", "full",
                "--json", "r.json",
            ],
        );
        assert!(said.contains("no mismatch in any bit or cycle"), "{said}");
        let r = json(&folder.path().join("r.json"));
        assert_eq!(r["format_version"], 1);
        assert_eq!(r["mismatches"], 0);
        assert_eq!(r["engine"], "verilator");
        assert_eq!(r["cycles"], r["cycles_predicted"]);
        let n = |field: &str| r[field].as_u64().unwrap();
        let stalls = ["fifo", "mft", "rit", "bank"].map(|cause| n(&format!("stall_{cause}")));
        assert_eq!(n("cycles"), n("busy") + stalls.iter().sum::<u64>());
        assert_eq!(stalls[3], 0, "{r}");
        assert!(n("samples") > 500 && n("vectors") > 500, "{r}");
        assert_eq!(
            r["gathering_unit"]["samples"],
            r["gathering_unit"]["samples_total"]
        );
        assert_eq!(
            r["vector_unit"]["elements"],
            r["vector_unit"]["elements_total"]
        );
        assert_eq!(r["configuration"].as_str().unwrap().len(), 12);
    }
    // Nothing but what was asked for.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// Entries of Gaussians have no weights, so that a wrong weight is not found in them: it is said.
#[test]
fn what_had_no_work_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let verified = |scene: &str| {
        let own = ["verify", "--config", "small", "--engine", "interpreter"];
        let rest = ["--scene", scene, "--width", "8", "--json", "r.json"];
        let said = expect(folder.path(), 0, &[&own[..], &rest].concat());
        (words(&said), json(&folder.path().join("r.json")))
    };
    let (said, report) = verified("garden");
    let weights = "had no work: weights that differ; ties of rounding; entries of 2, 4, 8 vertices";
    assert!(said.contains(weights), "{said}");
    assert!(
        said.contains("operations pass, relu, add, one-minus-exp"),
        "{said}"
    );
    let reach = |report: &serde_json::Value| report["gathering_unit"]["reach"].clone();
    assert_eq!(reach(&report)["weight_bits"], 0);
    let (said, report) = verified("lantern");
    let ties = "had no work: weights that differ in bit 15; ties rounded down; entries of 1, 2, 4";
    assert!(said.contains(ties), "{said}");
    assert_eq!(reach(&report)["ties"], serde_json::json!([false, true]));
    let operations = &report["vector_unit"]["operations"];
    assert!(operations.as_array().unwrap().contains(&"multiply".into()));
}

/// Compact entries, whole cells by parity and deeper pipelines, on traces of scenes.
#[test]
fn other_gathering_units_agree_in_every_bit_and_cycle() {
    gathering_units_agree(false);
}

/// Two records a row, and exact sums of a split halo, too.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn more_gathering_units_agree_in_every_bit_and_cycle() {
    gathering_units_agree(true);
}

/// Some units, or all of them.
fn gathering_units_agree(all: bool) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let builtin = "[model]\nkind = \"builtin\"\nname = \"lantern\"\n";
    let split = at(
        "split.toml",
        &format!("{builtin}[render]\nhalo = \"split\"\n"),
    );
    let fields = "[rit]\nentry = \"compact\"\n[vu]\nops = [\"pass\", \"relu\", \"add\", \"multiply\", \
                  \"square-sum\", \"exp\", \"one-minus-exp\", \"sigmoid\", \"softplus\"]\n[vu.exp]\n\
                  iterations = 18\niterations_per_clock = 2\naccumulator_bits = 20\nconstant_bits = 20\n";
    let pipelined = at("pipelined.toml", "[gu]\npipelined = true\n");
    let two = at("two.toml", "[gu]\nrecords_a_row = 2\n");
    let exact = at("exact.toml", "[gu]\nsums = \"exact\"\n");
    let cells = "organisation = \"parity\"\nmodes = \"structured\"\nvertices = [8]\n";
    let whole = at("whole.toml", &format!("[gu]\n{cells}"));
    let four = at(
        "four.toml",
        "[gu]\nports = 4\nbanks = 16\npipelined = true\n",
    );
    let [tensorf, dvgo] = ["tensorf", "dvgo"].map(|representation| {
        let model = "[model]\nkind = \"builtin\"\nname = \"cairn\"\n";
        let text =
            format!("{model}representation = \"{representation}\"\n[render]\nhalo = \"split\"\n");
        at(&format!("{representation}.toml"), &text)
    });
    let exact_fields = at(
        "exact-fields.toml",
        &format!(
            "[gu]\nsums = \"exact\"\n{}",
            fields.replace("compact", "paper")
        ),
    );
    let turns = at("turns.toml", "[gu]\nports = 4\nextra_ports = \"split\"\n");
    let lanes = "[gu]\norganisation = \"feature-major\"\nbanks = 16\nlanes = 64\n";
    let lanes = at("lanes.toml", lanes);
    let fields = at("fields.toml", fields);
    let mut cycles = vec![];
    let some = [
        ("cairn:voxels", "paper", "16"),
        ("cairn:voxels", "compact", "16"),
        ("cairn:voxels", "parity", "16"),
        ("cairn:voxels", &pipelined, "16"),
    ];
    let others = [
        ("cairn:voxels", "paper", "32"),
        ("garden", &two, "16"),
        ("cairn:voxels", &turns, "12"),
        (&split, &exact, "12"),
        (&tensorf, &exact_fields, "10"),
        ("cairn:voxels", "compact", "32"),
        ("garden", "paper", "32"),
        ("cairn:voxels", &whole, "24"),
        ("cairn:voxels", &four, "24"),
        ("garden", &turns, "16"),
        ("garden", &lanes, "24"),
        ("cairn:tensorf", &fields, "16"),
        (&dvgo, &exact_fields, "16"),
        ("cairn:ngp-mvoxel", &exact_fields, "12"),
    ];
    let others = others.into_iter().filter(|_| all);
    for (scene, config, width) in some.into_iter().chain(others) {
        let said = expect(
            folder.path(),
            0,
            &[
                "verify", "--config", config, "--scene", scene, "--width", width, "--json",
                "r.json",
            ],
        );
        assert!(said.contains("no mismatch in any bit or cycle"), "{said}");
        let r = json(&folder.path().join("r.json"));
        assert_eq!(r["mismatches"], 0);
        assert_eq!(r["cycles"], r["cycles_predicted"]);
        let unit = &r["gathering_unit"];
        assert_eq!(unit["samples"], unit["samples_total"]);
        cycles.push(unit["busy"].as_u64().unwrap());
    }
    let [paper, compact, parity, pipelined, ..] = cycles[..] else {
        panic!("{cycles:?}");
    };
    assert_eq!((compact, pipelined, 8 * parity), (paper, paper, paper));
}

/// Banks of whole vectors: voxels conflict, and 16 splats in the order of their
/// rows do not.
#[test]
fn the_feature_major_preset_agrees_in_every_bit_and_cycle() {
    let folder = tempfile::tempdir().unwrap();
    for (scene, conflicts) in [("garden", false), ("lantern", true)] {
        let arguments = [
            "--config",
            "feature-major",
            "verify",
            "--scene",
            scene,
            "--width",
            "20",
            "--json",
            "r.json",
        ];
        let said = expect(folder.path(), 0, &arguments);
        assert!(said.contains("no mismatch in any bit or cycle"), "{said}");
        let r = json(&folder.path().join("r.json"));
        let n = |field: &str| r[field].as_u64().unwrap();
        let stalls = ["fifo", "mft", "rit", "bank"].map(|cause| n(&format!("stall_{cause}")));
        assert_eq!(n("cycles"), n("busy") + stalls.iter().sum::<u64>());
        assert_eq!(r["cycles"], r["cycles_predicted"]);
        assert_eq!(stalls[3] > 0, conflicts, "{r}");
        assert_eq!(r["samples"], r["gathering_unit"]["samples_total"]);
    }
}

/// Traces of TensoRF, also with MVoxels that store nothing twice, Instant-NGP, also
/// hashed by MVoxel, Compact-3DGS and EfficientNeRF.
#[test]
fn other_algorithms_agree_in_every_bit_and_cycle() {
    algorithms_agree(&["tensorf/tiny.th", "cairn:ngp-mvoxel"]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn more_algorithms_agree_in_every_bit_and_cycle() {
    algorithms_agree(&[
        "compact/tiny.npz",
        "split",
        "cairn:dvgo",
        "ngp/cube.ingp",
        "moons:efficientnerf",
    ]);
}

/// Of fixtures, built-in scenes, and `split`, whose MVoxels store nothing twice.
fn algorithms_agree(scenes: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let fixtures = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/tests/fixtures");
    let split = folder.path().join("split.toml");
    let text = "[model]\nkind = \"builtin\"\nname = \"cairn\"\nrepresentation = \"tensorf\"\n\
                [render]\nhalo = \"split\"\n";
    std::fs::write(&split, text).unwrap();
    for scene in scenes {
        let file = fixtures.join(scene);
        let (scene, width) = match *scene {
            "split" => (split.display().to_string(), "32"),
            "ngp/cube.ingp" => (file.display().to_string(), "16"),
            "compact/tiny.npz" => (file.display().to_string(), "48"),
            _ if file.exists() => (file.display().to_string(), "32"),
            "moons:efficientnerf" => ((*scene).to_owned(), "48"),
            _ => ((*scene).to_owned(), "32"),
        };
        let said = expect(
            folder.path(),
            0,
            &[
                "verify", "--config", "fields", "--scene", &scene, "--width", width, "--level",
                "full", "--json", "r.json",
            ],
        );
        assert!(said.contains("no mismatch in any bit or cycle"), "{said}");
        let r = json(&folder.path().join("r.json"));
        // Agreement is of the units alone, and says so.
        assert_eq!(said.matches("not checked: ").count(), 1, "{said}");
        let left = r["not_checked"].as_array().unwrap();
        let truth =
            |v: &serde_json::Value| v.as_str().unwrap().starts_with("nearness to the truth");
        let built_in = scene.contains(':') || scene.ends_with(".toml");
        assert_eq!(left.iter().any(truth), !built_in, "{r}");
        let said = words(&said);
        assert!(left.iter().all(|v| said.contains(v.as_str().unwrap())));
        let n = |field: &str| r[field].as_u64().unwrap();
        assert_eq!(n("cycles"), n("cycles_predicted"), "{scene}");
        assert!(n("samples") > 500 && n("vectors") > 500, "{r}");
        for (unit, compared) in [("gathering_unit", "samples"), ("vector_unit", "elements")] {
            let unit = &r[unit];
            assert_eq!(unit[compared], unit[format!("{compared}_total")], "{scene}");
        }
    }
}

#[test]
fn an_injected_fault_is_found_with_its_first_cycle() {
    faults_are_found("small", "8", &[("bit", "gathering_unit")]);
}

/// Whose turn it is, and which of a part's reads is whose.
#[test]
fn taking_turns_wrongly_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[gu]\nports = 4\nextra_ports = \"split\"\n";
    std::fs::write(folder.path().join("turns.toml"), text).unwrap();
    let frame = ["--scene", "lantern", "--width", "16"];
    for fault in ["grant", "crossbar"] {
        let verify = [
            "verify",
            "--config",
            "turns.toml",
            "--engine",
            "interpreter",
        ];
        let inject = ["--inject", fault];
        let said = expect(folder.path(), 1, &[&verify, &frame[..], &inject].concat());
        assert!(
            said.contains("MISMATCH in gathering_unit, cycle "),
            "{said}"
        );
    }
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_injected_fault_is_found_with_its_first_cycle() {
    let faults = [
        ("bit", "gathering_unit"),
        ("bubble", "gathering_unit"),
        ("weight", "gathering_unit"),
        ("exp", "vector_unit"),
    ];
    faults_are_found("paper", "32", &faults);
}

fn faults_are_found(preset: &str, width: &str, faults: &[(&str, &str)]) {
    let folder = tempfile::tempdir().unwrap();
    for (fault, unit) in faults {
        let said = expect(
            folder.path(),
            1,
            &[
                "verify", "--config", preset, "--scene", "lantern", "--width", width, "--inject",
                fault, "--vcd", "w.vcd", "--json", "r.json",
            ],
        );
        assert!(
            said.contains(&format!("MISMATCH in {unit}, cycle ")),
            "{said}"
        );
        assert!(
            said.contains("expected ") && said.contains("found "),
            "{said}"
        );
        let again = format!("--inject {fault} --seed 1");
        assert!(
            said.contains(&format!(
                "to reproduce: potamoi verify --scene lantern --width {width}"
            )),
            "{said}"
        );
        assert!(said.contains(&again), "{said}");
        let r = json(&folder.path().join("r.json"));
        assert_eq!(r["mismatches"], 1);
        let cycle = r["failure"]["mismatch"]["cycle"].as_u64().unwrap();
        assert!(said.contains(&format!("cycle {cycle}:")), "{said}");
        assert!(
            std::fs::metadata(folder.path().join("w.vcd"))
                .unwrap()
                .len()
                > 1000
        );
        std::fs::remove_file(folder.path().join("w.vcd")).unwrap();
    }
    // Single ids have no weights: nothing can be found, and that is no pass.
    let said = expect(
        folder.path(),
        4,
        &[
            "verify", "--config", preset, "--scene", "garden", "--width", width, "--inject",
            "weight",
        ],
    );
    assert!(said.contains("was not found"), "{said}");
}

#[test]
fn other_engines_agree_on_a_share() {
    let folder = tempfile::tempdir().unwrap();
    for engine in ["interpreter", "icarus"] {
        let said = expect(
            folder.path(),
            0,
            &[
                "verify", "--scene", "garden", "--width", "16", "--engine", engine,
            ],
        );
        assert!(
            said.contains("no mismatch") && said.contains(engine),
            "{said}"
        );
    }
}

/// Lanes as wide as what splats send, with register stages between; a scene of voxels sends more.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn narrow_lanes_agree_on_splats_and_refuse_voxels_by_field() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[vu]\nregistered = true\n[vu.operands]\nmultiply = [22, 18]\nsquare_sum = 19\n";
    std::fs::write(folder.path().join("narrow.toml"), text).unwrap();
    let verify = |code: i32, scene: &str, level: &str| {
        let args = [
            "verify",
            "--config",
            "narrow.toml",
            "--scene",
            scene,
            "--width",
            "64",
            "--level",
            level,
        ];
        expect(folder.path(), code, &args)
    };
    let said = verify(0, "garden", "full");
    assert!(said.contains("no mismatch in any bit or cycle"), "{said}");
    let said = verify(2, "lantern", "quick");
    assert!(said.contains("vu.operands.multiply"), "{said}");
}

/// What compared nothing has shown nothing.
#[test]
fn an_empty_view_is_inconclusive() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[model]\nkind = \"builtin\"\nname = \"garden\"\n[camera]\nkind = \"orbit\"\n\
                elevation = 0\nfov = 20\ntarget = [0, 1000, 0]\n";
    std::fs::write(folder.path().join("away.toml"), text).unwrap();
    let said = expect(
        folder.path(),
        4,
        &["verify", "--scene", "away.toml", "--width", "32"],
    );
    assert!(said.contains("nothing was compared"), "{said}");
    assert!(!said.contains("no mismatch"), "{said}");
}
