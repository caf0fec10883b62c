//! What a run repeats: units whose netlist has changed, and none for their names.

#![allow(clippy::unwrap_used)]

use super::*;

/// A vector unit of one lane.
fn sources(more: &str) -> Sources {
    let text = format!("vu.lanes = 1\nvu.ops = [\"exp\"]\n{more}");
    let config = Config::from_toml(&text, "test").unwrap();
    Sources::new(&config, UnitKind::Vector).unwrap()
}

/// The same netlist printed with another name and another comment.
fn renamed(mut sources: Sources) -> Sources {
    let file = sources.files.get_mut("vector_unit.v").unwrap();
    let text = file.replace("result_valid", "has_result") + "// Another comment.\n";
    assert!(text.matches("has_result").count() > 1);
    *file = text;
    sources
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn names_repeat_nothing_and_a_changed_module_its_unit() {
    let folder = tempfile::tempdir().unwrap();
    let cells = concat!(env!("CARGO_MANIFEST_DIR"), "/cells/handful.lib");
    let (library, tools) = (
        Library::read(Path::new(cells)).unwrap(),
        Tools::find().unwrap(),
    );
    let run = |sources: &Sources, reuse| {
        let cache = folder.path();
        let made = sources.synthesise(&library, &tools, cache, reuse, &|| ());
        made.unwrap()
    };
    let first = run(&sources(""), Reuse::Cached);
    assert!(!first.is_cached);

    let other = renamed(sources(""));
    let cached = run(&other, Reuse::Cached);
    assert!(cached.is_cached);
    assert_eq!(
        (cached.report, cached.netlist),
        (first.report.clone(), first.netlist)
    );
    assert_ne!(cached.verilog, other.hash());

    // Where nets are found by name, the unit is made again under the same key.
    let named = run(&other, Reuse::SameVerilog);
    assert!(!named.is_cached && named.key == first.key);
    assert!(named.verilog == other.hash() && named.netlist.contains("has_result"));
    // Yosys chooses between equally good cells by name.
    let area = named.report.area_um2 / first.report.area_um2;
    assert!((area - 1.0).abs() < 0.01, "{area}");
    assert!(run(&other, Reuse::SameVerilog).is_cached);

    // Another constant in the lanes.
    let changed = run(&sources("vu.exp.constant_bits = 14\n"), Reuse::Cached);
    assert!(!changed.is_cached && changed.key != first.key);
    let modules = first.report.netlists.changed(&changed.report.netlists);
    assert_eq!(modules, ["exp_constants", "vector_lane", "vector_unit"]);
}
