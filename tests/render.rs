//! `potamoi render` and `potamoi cost` from end to end.

use crate::common::{self, expect, json, potamoi};

#[test]
fn the_hardware_renders_the_fixed_picture_and_counts_its_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for scene in ["garden", "lantern"] {
        for numerics in ["float", "fixed", "rtl"] {
            let (out, report) = (format!("{numerics}.png"), format!("{numerics}.json"));
            expect(
                at,
                0,
                &[
                    "render",
                    "--scene",
                    scene,
                    "--width",
                    "16",
                    "--numerics",
                    numerics,
                    "--out",
                    &out,
                    "--json",
                    &report,
                ],
            );
        }
        let read = |name: &str| std::fs::read(at.join(name)).unwrap();
        assert_eq!(read("fixed.png"), read("rtl.png"), "{scene}");
        let [float, fixed, rtl] =
            ["float", "fixed", "rtl"].map(|n| json(&at.join(format!("{n}.json"))));
        assert_eq!(rtl["format_version"], 2);
        // The units count what the renderer says the frame needs.
        assert_eq!(
            rtl["units"]["feature_vectors"],
            rtl["frame"]["feature_vectors"]
        );
        assert_eq!(rtl["units"]["elements"], rtl["frame"]["elements"]);
        assert_eq!(rtl["units"], fixed["units"]);
        assert_eq!(rtl["float"], fixed["float"]);
        assert!(rtl["float"]["db"].as_f64().unwrap() > 80.0, "{rtl}");
        // Every pair of a live pixel and a Gaussian is evaluated, and few count.
        if let Some(splats) = fixed["frame"]["splats"].as_object() {
            let pairs = |kind: &str| splats[&format!("pairs_{kind}")].as_u64().unwrap();
            assert_eq!(rtl["frame"]["splats"], fixed["frame"]["splats"]);
            assert_eq!(fixed["frame"]["elements"]["exp"], pairs("evaluated"));
            assert_eq!(
                fixed["frame"]["elements"]["multiply"],
                pairs("evaluated") + pairs("drawn")
            );
            assert!(pairs("drawn") > 0 && pairs("stopped") <= 16 * 16);
            assert!(4 * (pairs("drawn") + pairs("stopped")) < pairs("evaluated"));
        }
        assert!(rtl["cycles"]["gather"].as_u64().unwrap() > 100, "{rtl}");
        assert!(
            float["float"].is_null() && float["units"].is_null(),
            "{float}"
        );
    }
}

/// One thread or many, the same bytes, in fixed and in floating point.
#[test]
fn threads_change_no_byte() {
    threads_agree(&[("garden", "90"), ("lantern", "90"), ("cairn:ngp", "24")]);
}

#[test]
fn threads_change_no_byte_of_other_fields() {
    threads_agree(&[("cairn:dvgo", "24"), ("cairn:tensorf", "24")]);
}

fn threads_agree(scenes: &[(&str, &str)]) {
    let folder = tempfile::tempdir().unwrap();
    let render = |threads: &str, scene: &str, numerics: &str, width: &str| {
        let done = potamoi()
            .current_dir(folder.path())
            .env("RAYON_NUM_THREADS", threads)
            .args(["--config", "fields", "render", "--scene", scene])
            .args(["--numerics", numerics, "--width", width, "--out", "p.png"])
            .output()
            .unwrap();
        assert!(done.status.success(), "{scene}, {numerics}: {done:?}");
        std::fs::read(folder.path().join("p.png")).unwrap()
    };
    for (scene, width) in scenes {
        for numerics in ["fixed", "float"] {
            let [one, seven] = ["1", "7"].map(|n| render(n, scene, numerics, width));
            assert_eq!(one, seven, "{scene}, {numerics}");
        }
    }
}

/// A way through a scene as numbered pictures, each that of its camera alone.
#[test]
fn a_path_is_rendered_as_numbered_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let poses = concat!(env!("CARGO_MANIFEST_DIR"), "/golden/tests/fixtures/colmap");
    let scene = |index: u32| {
        let text = format!(
            "[model]\nkind = \"builtin\"\nname = \"garden\"\n[camera]\nkind = \"colmap\"\n\
             path = \"{poses}\"\nindex = {index}\n"
        );
        std::fs::write(at.join(format!("{index}.toml")), text).unwrap();
    };
    scene(1);
    scene(3);
    let render = |scene: &str, out: &str, more: &[&str]| {
        let mut arguments = vec!["render", "--scene", scene, "--width", "32", "--out", out];
        arguments.extend(more);
        let code = if more.contains(&"5") { 2 } else { 0 };
        expect(at, code, &arguments)
    };
    let report = ["--frames", "3", "--json", "way.json"];
    let said = render("1.toml", "way/p.png", &report);
    assert!(said.contains("3 pictures"), "{said}");
    assert_eq!(said.matches("not checked: ").count(), 1, "{said}");
    let way = json(&at.join("way.json"));
    let names = |folder: &str| {
        let files = std::fs::read_dir(at.join(folder)).unwrap();
        let mut names: Vec<_> = files.map(|f| f.unwrap().file_name()).collect();
        names.sort();
        names
    };
    assert_eq!(names("way"), ["p.0000.png", "p.0001.png", "p.0002.png"]);
    let bytes = |name: &str| std::fs::read(at.join(name)).unwrap();
    render("1.toml", "first.png", &["--json", "first.json"]);
    // Of each picture, what its own report says.
    let first = json(&at.join("first.json"));
    assert_eq!(way["frames"].as_array().unwrap().len(), 3);
    for field in ["width", "height", "frame", "units", "cycles"] {
        assert_eq!(way["frames"][0][field], first[field], "{field}");
    }
    assert!(first["frame"]["feature_vectors"].as_u64().unwrap() > 100);
    assert_ne!(way["frames"][0]["frame"], way["frames"][2]["frame"]);
    assert_eq!(way["frames"][2]["file"], "way/p.0002.png");
    assert_eq!(way["not_checked"], first["not_checked"]);
    assert!(!first["not_checked"].as_array().unwrap().is_empty());
    render("3.toml", "third.png", &[]);
    assert_eq!(bytes("first.png"), bytes("way/p.0000.png"));
    assert_eq!(bytes("third.png"), bytes("way/p.0002.png"));
    assert_ne!(bytes("first.png"), bytes("third.png"));
    // Four are left from the second on.
    let said = render("1.toml", "way/q.png", &["--frames", "5"]);
    assert!(said.contains("at most 4"), "{said}");
    let float = ["--frames", "2", "--fps", "1", "--numerics", "float"];
    render("moons", "moons/m.png", &float);
    assert_ne!(bytes("moons/m.0000.png"), bytes("moons/m.0001.png"));
}

#[test]
fn every_exponential_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let said = expect(
        at,
        0,
        &[
            "cost", "--study", "exp", "--csv", "e.csv", "--json", "r.json",
        ],
    );
    assert!(
        said.contains("0.9728 ulp") && said.contains("monotone: yes"),
        "{said}"
    );
    let table = std::fs::read_to_string(at.join("e.csv")).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("u_code,y_code,cycles"));
    let mut count = 0;
    for (u, line) in lines.enumerate() {
        let fields: Vec<i64> = line.split(',').map(|f| f.parse().unwrap()).collect();
        assert_eq!((fields.len(), fields[0]), (3, u as i64));
        let exact = ((-(u as f64) / 8192.0).exp() * 65_536.0).min(65_535.0);
        assert!((fields[1] as f64 - exact).abs() < 1.0, "{line}");
        assert_eq!(fields[2], 21, "{line}");
        count += 1;
    }
    assert_eq!(count, 65_536);
    let r = json(&at.join("r.json"));
    assert_eq!(
        (&r["format_version"], &r["inputs"]),
        (&3.into(), &65_536.into())
    );
    assert!(r["max_ulp"].as_f64().unwrap() < 1.0);
    std::fs::write(
        at.join("g.toml"),
        "[vu.exp]\noutput = \"general\"\ninput = \"S3.12\"\n",
    )
    .unwrap();
    let said = expect(at, 2, &["cost", "--study", "exp", "--config", "g.toml"]);
    assert!(said.contains("vu.exp.output"), "{said}");
}

/// The forms side by side: largest error, cycles from vector to vector and
/// until its results.
#[test]
fn cost_compares_the_exponentials() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (name, knobs) in [
        ("radix", "form = \"radix-4\"\niterations = 4\ntail = true"),
        ("early", "early_out = true"),
        (
            "piecewise",
            "form = \"piecewise\"\npieces = 128\npipelined = true",
        ),
        (
            "two",
            "form = \"piecewise\"\npipelined = true\nbase = \"two\"",
        ),
    ] {
        let text = format!("[vu]\nlanes = 4\n[vu.exp]\n{knobs}\n");
        std::fs::write(at.join(format!("{name}.toml")), text).unwrap();
    }
    for (config, most, interval, latency, said) in [
        (
            "piecewise.toml",
            0.68,
            1.0,
            3,
            "exp(-u) in 128 straight pieces",
        ),
        ("two.toml", 1.039, 1.0, 2, "2^-u in 64 straight pieces"),
        ("radix.toml", 0.812, 7.0, 8, "radix 4, 4 digits, tail on"),
        (
            "early.toml",
            0.9906,
            15.634,
            21,
            "n = 16 at most, early out",
        ),
    ] {
        let args = [
            "cost", "--study", "exp", "--json", "r.json", "--config", config,
        ];
        let text = expect(at, 0, &args);
        assert!(text.contains(said), "{text}");
        let r = json(&at.join("r.json"));
        assert!(r["max_ulp"].as_f64().unwrap() <= most, "{r}");
        assert_eq!(r["monotone"], true);
        let found = r["interval_cycles"].as_f64().unwrap();
        assert!((found - interval).abs() < 0.01, "{config}: {found}");
        assert_eq!(r["latency_cycles"], latency, "{config}");
    }
}

/// A real scene through the Verilated units, at full size.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn real_splats_through_the_hardware_are_the_fixed_picture() {
    let Some(data) = common::shared() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let camera = data.join("cameras/camera_playbot_31k_800.json");
    let camera = camera.to_str().unwrap();
    for name in ["playbot_8k", "playbot_31k"] {
        let scene = data.join(format!("splats/{name}.ply"));
        let reports = ["fixed", "rtl"].map(|numerics| {
            let (png, report) = (format!("{numerics}.png"), format!("{numerics}.json"));
            expect(
                at,
                0,
                &[
                    "render",
                    "--scene",
                    scene.to_str().unwrap(),
                    "--camera",
                    camera,
                    "--width",
                    "400",
                    "--numerics",
                    numerics,
                    "--out",
                    &png,
                    "--json",
                    &report,
                ],
            );
            (
                std::fs::read(at.join(&png)).unwrap(),
                json(&at.join(&report)),
            )
        });
        let [(fixed, _), (rtl, report)] = reports;
        assert!(fixed == rtl, "{name}: the pictures differ");
        assert_eq!(
            report["units"]["feature_vectors"],
            report["frame"]["feature_vectors"]
        );
        assert_eq!(report["units"]["elements"], report["frame"]["elements"]);
        assert!(report["float"]["db"].as_f64().unwrap() >= 80.0, "{report}");
        assert!(
            report["float_covered_db"].as_f64().unwrap() >= 78.0,
            "{report}"
        );
    }
}
