//! Syntheses of a user in comparisons and searches.

use std::fs;

use serde_json::Value;

use crate::common::{expect, json};

/// `lean-splats` with fewer tiles a splat unit, of which no synthesis comes with the program.
const OTHER: &str = "preset = \"lean-splats\"\n[su]\ntiles = 2\n";

/// A file of a unit, as `potamoi synth` would write it: the figures of `lean-splats` stand for any.
#[test]
fn units_that_were_synthesised_are_known() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("other.toml"), OTHER).unwrap();
    let size = ["--scene", "garden", "--width", "8", "--frames", "1"];
    let of = |status: i32, arguments: &[&str]| expect(path, status, &[arguments, &size].concat());

    let alone = of(0, &["compare", "other.toml"]);
    assert!(alone.contains("then --synth F"), "{alone}");

    // A file of an earlier program names no configuration, and one that it names has to be its own.
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/synth/lean-splats-asap7.json");
    let mut report: Value = json(file.as_ref());
    let write =
        |name: &str, report: &Value| fs::write(path.join(name), report.to_string()).unwrap();
    write("f.json", &report);
    let text = of(2, &["compare", "other.toml", "--synth", "f.json"]);
    assert!(text.contains("`configuration_toml` is missing"), "{text}");
    let preset = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/lean-splats.toml");
    let preset = fs::read_to_string(preset).unwrap();
    let other = preset.replace("\ntiles = 4", "\ntiles = 2");
    assert_ne!(preset, other);
    report["configuration_toml"] = other.into();
    write("f.json", &report);
    let text = of(2, &["compare", "other.toml", "--synth", "f.json"]);
    let hash = text.split("expected ").nth(1).unwrap();
    report["configuration"] = hash[..12].into();
    write("f.json", &report);

    let known = of(0, &["compare", "other.toml", "--synth", "f.json"]);
    assert!(!known.contains("not known:"), "{known}");
    // A machine without such a unit keeps its figures, and the file is named.
    let bare = of(0, &["compare", "paper"]);
    let unused = of(0, &["compare", "paper", "--synth", "f.json"]);
    assert!(unused.contains(bare.trim_end()), "{unused}");
    assert!(unused.contains("f.json: no machine here has"), "{unused}");

    // A search finds what it could not know before; its rows are not mistaken for those without.
    let space = ["--vary", "su.tiles=2,4", "--objective", "area"];
    let search = [&["explore", "lean-splats"][..], &space].concat();
    let text = of(4, &search);
    assert!(text.contains("nothing that was tried is better"), "{text}");
    let text = of(4, &[&search[..], &["--synth", "f.json"]].concat());
    assert!(!text.contains("is not known"), "{text}");
    assert!(
        text.contains("front of mm2, area and quality: 1 machine"),
        "{text}"
    );
}
