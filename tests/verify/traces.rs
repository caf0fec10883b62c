//! Traces: verified without their scene, refused when changed.

use crate::common::{expect, json};

#[test]
fn a_trace_is_verified_without_its_scene_and_refused_when_changed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let trace = [
        "trace", "--scene", "lantern", "--width", "40", "--out", "t.npz",
    ];
    let said = expect(at, 0, &trace);
    assert!(said.contains("feature vectors"), "{said}");
    assert!(said.contains("not checked: "), "{said}");
    let said = expect(at, 0, &["verify", "--trace", "t.npz", "--level", "full"]);
    assert!(
        said.contains("trace of lantern")
            && said.contains("no mismatch")
            && said.contains("a trace holds their work alone"),
        "{said}"
    );
    let bytes = std::fs::read(at.join("t.npz")).unwrap();
    expect(at, 0, &trace);
    assert_eq!(
        std::fs::read(at.join("t.npz")).unwrap(),
        bytes,
        "the same bytes again"
    );

    std::fs::write(at.join("other.toml"), "[gu]\nports = 4\n").unwrap();
    let said = expect(
        at,
        2,
        &["verify", "--trace", "t.npz", "--config", "other.toml"],
    );
    assert!(said.contains("is of configuration"), "{said}");
    std::fs::write(at.join("cut.npz"), &bytes[..bytes.len() / 2]).unwrap();
    let said = expect(at, 2, &["verify", "--trace", "cut.npz"]);
    assert!(said.contains("cut.npz"), "{said}");
    let mut changed = bytes.clone();
    let middle = changed.len() / 2;
    changed[middle] ^= 1;
    std::fs::write(at.join("changed.npz"), &changed).unwrap();
    let said = expect(at, 2, &["verify", "--trace", "changed.npz"]);
    assert!(said.contains("array `"), "{said}");
}

/// Of a configuration with exact sums, a trace holds the parts of samples that several
/// MVoxels share.
#[test]
fn a_trace_of_exact_sums_is_verified_whole() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let model = "[model]\nkind = \"builtin\"\nname = \"lantern\"\n";
    let split = format!("{model}[render]\nhalo = \"split\"\n");
    std::fs::write(at.join("split.toml"), split).unwrap();
    std::fs::write(
        at.join("exact.toml"),
        "[gu]\nsums = \"exact\"\nbanks = 8\n[vu]\nlanes = 2\n",
    )
    .unwrap();
    let exact = ["--config", "exact.toml"];
    let scene = ["--scene", "split.toml", "--width", "4"];
    let trace = ["trace", "--all", "--out", "t.npz", "--json", "t.json"];
    expect(at, 0, &[&exact[..], &trace, &scene].concat());
    let verify = [
        "verify",
        "--engine",
        "interpreter",
        "--level",
        "full",
        "--json",
    ];
    expect(at, 0, &[&exact[..], &verify, &["s.json"], &scene].concat());
    expect(
        at,
        0,
        &[&exact[..], &verify, &["v.json", "--trace", "t.npz"]].concat(),
    );
    let [trace, of_scene, of_trace] = ["t", "s", "v"].map(|n| json(&at.join(format!("{n}.json"))));
    assert!(of_scene["samples"].as_u64().unwrap() > 100, "{of_scene}");
    assert_eq!(trace["samples"], of_scene["samples"]);
    assert_eq!(of_trace["samples"], of_scene["samples"]);
    // What cannot sum parts is left out of a comparison, which is of the same samples.
    let layouts = ["layouts", "--json", "l.json"];
    let said = expect(at, 0, &[&exact[..], &layouts, &scene].concat());
    assert!(said.contains("left out: parity"), "{said}");
    let layouts = json(&at.join("l.json"));
    assert_eq!(layouts["samples"], of_scene["samples"]);
    assert!(
        layouts["layouts"][0]["cycles"].as_u64().unwrap() > 100,
        "{layouts}"
    );
}
