//! Files of parameters are read, and refused where figures contradict each other.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use potamoi_formats::config::Config;

use crate::{NetlistDigests, SYSTEM, SynthReport, Synthesised, UnitKind};

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../synth/paper-asap7.json")
}

/// The parameters that come with the project are of its presets.
#[test]
fn the_papers_parameters_are_read() {
    let config = Config::paper();
    let report = SynthReport::read(&path())
        .unwrap()
        .of(&config, &path())
        .unwrap();
    assert_eq!(report.library.node_nm, Some(7));
    for unit in [UnitKind::Gathering, UnitKind::Vector] {
        let (raw, scaled) = (
            report.unit(unit).unwrap(),
            report.scaled_unit(unit).unwrap(),
        );
        assert!(scaled.area_um2 > raw.area_um2 && scaled.period_ps > raw.period_ps);
        let energy = scaled.energy.unwrap();
        assert!(energy.with_glitches_pj_a_cycle > energy.zero_delay_pj_a_cycle);
    }
    let banks = report.unit(UnitKind::Gathering).unwrap().memories.clone();
    for own in banks {
        let (raw, scaled) = report
            .memory(UnitKind::Gathering.top(), &own.module)
            .unwrap();
        assert_eq!((raw.count, raw.shape.words), (own.count, own.words));
        assert!(scaled.unwrap().figures.area_um2 < raw.figures.area_um2);
    }
    assert_eq!(
        report
            .memory(SYSTEM, "global_feature_buffer")
            .unwrap()
            .0
            .count,
        48
    );
    assert!(report.memory(SYSTEM, "mft_bank").is_none());

    let other = Config::preset("small").unwrap();
    let error = report.of(&other, &path()).unwrap_err().to_string();
    assert!(
        error.contains("expected") && error.contains(&other.hash()),
        "{error}"
    );
}

/// An unknown key in any kind of object, at any depth, in any kind of file is refused.
#[test]
fn keys_that_nobody_knows_are_refused_at_every_depth() {
    use serde_json::Value;

    /// Paths of objects; of lists only the first element's.
    fn objects(value: &Value, path: &str, found: &mut Vec<String>) {
        match value {
            Value::Object(entries) => {
                found.push(path.to_owned());
                for (key, value) in entries {
                    objects(value, &format!("{path}/{key}"), found);
                }
            }
            Value::Array(values) => {
                if let Some(first) = values.first() {
                    objects(first, &format!("{path}/0"), found);
                }
            }
            _ => {}
        }
    }

    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../synth");
    type Parse = fn(&str) -> Result<(), String>;
    let report: Parse = |text| SynthReport::parse(text).map(drop);
    let grid: Parse = |text| {
        let read = crate::grid::Grid::parse(text, Path::new("grid.json"));
        read.map(drop).map_err(|e| e.to_string())
    };
    for (file, parse, least) in [
        ("paper-asap7.json", report, 10),
        ("grid-asap7.json", grid, 6),
        ("forms-asap7.json", grid, 6),
    ] {
        let text = std::fs::read_to_string(root.join(file)).unwrap();
        parse(&format!("\u{feff}{text}")).unwrap();
        let good: Value = serde_json::from_str(&text).unwrap();
        let mut paths = vec![];
        objects(&good, "", &mut paths);
        assert!(paths.len() >= least, "{file}: {paths:?}");
        // There, keys are names of memories and of modules.
        let is_fixed =
            |path: &&String| !path.ends_with("/access_ps") && !path.ends_with("/netlists");
        for path in paths.iter().filter(is_fixed) {
            let mut more = good.clone();
            more.pointer_mut(path).unwrap()["news"] = 1.into();
            let error = parse(&more.to_string()).unwrap_err();
            assert!(error.contains("news"), "{file}{path}: {error}");
        }
    }
}

/// Netlists that were changed since need another synthesis: `make parameters`.
#[test]
fn the_parameters_are_of_what_is_generated_now() {
    let mut all = Synthesised::checked_in().unwrap();
    all.push(Synthesised {
        config: Config::paper(),
        report: SynthReport::of_records().unwrap(),
    });
    for Synthesised { config, report } in all {
        for unit in &report.raw.units {
            let kind = UnitKind::WITH_SPLAT_UNIT
                .into_iter()
                .find(|kind| kind.top() == unit.unit)
                .unwrap();
            let now = NetlistDigests::of(&config, kind).unwrap();
            assert_eq!(
                unit.netlists.changed(&now),
                [""; 0],
                "{}, {}",
                config.hash(),
                unit.unit
            );
        }
    }
}

#[test]
fn what_is_wrong_is_named() {
    let text = std::fs::read_to_string(path()).unwrap();
    let good: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(SynthReport::parse(&good.to_string()).is_ok());
    type Change = fn(&mut serde_json::Value);
    let changes: [(Change, &str); 14] = [
        (
            |v| v["format_version"] = 1.into(),
            "format_version 1, expected 5",
        ),
        (|v| v["command"] = "cost".into(), "command `cost`"),
        (
            |v| v["raw"]["units"][0]["area_um2"] = 1.0.into(),
            "gathering_unit: area_um2 1, expected",
        ),
        (
            |v| v["raw"]["units"][1]["cells"] = 7.into(),
            "vector_unit: cells 7, expected",
        ),
        (
            |v| v["raw"]["units"][0]["period_ps"] = (-1.0).into(),
            "period_ps -1, expected a number above 0",
        ),
        (
            |v| v["raw"]["memories"]["macros"][0]["read_pj"] = 0.0.into(),
            "mft_bank: read_pj 0",
        ),
        (
            |v| v["scaled"]["logic"]["factors"]["area"] = 2.0.into(),
            "scaled gathering_unit: area_um2",
        ),
        (
            |v| v["scaled"]["logic"]["units"][1]["energy"]["with_glitches_pj_an_item"] = 1.0.into(),
            "scaled vector_unit: with_glitches_pj_an_item 1, expected",
        ),
        (
            |v| v["scaled"]["logic"]["units"][0]["with_memories_ps"] = 1.0.into(),
            "scaled gathering_unit: with_memories_ps 1, expected",
        ),
        (
            |v| v["raw"]["units"][0]["with_memories"]["period_ps"] = 900.0.into(),
            "gathering_unit: with_memories.clock_ghz",
        ),
        (
            |v| v["scaled"]["logic"]["units"][0]["energy"] = serde_json::Value::Null,
            "scaled gathering_unit: energy, expected where",
        ),
        (
            |v| v["scaled"]["memories"]["macros"][1]["cycle_ps"] = 1.0.into(),
            "scaled rit_bank: cycle_ps",
        ),
        (
            |v| v["scaled"]["memories"]["macros"] = serde_json::json!([]),
            "as many as in raw",
        ),
        (|v| v["raw"]["unit"] = 1.into(), "raw.unit"),
    ];
    for (change, said) in changes {
        let mut bad = good.clone();
        change(&mut bad);
        let why = SynthReport::parse(&bad.to_string()).unwrap_err();
        assert!(why.contains(said), "{said}: {why}");
    }
    assert!(
        SynthReport::parse("{}")
            .unwrap_err()
            .contains("format_version")
    );
    assert!(SynthReport::parse(&text[..text.len() / 2]).is_err());
    let gone = SynthReport::read(Path::new("gone.json"))
        .unwrap_err()
        .to_string();
    assert!(
        gone.starts_with("gone.json: ") && gone.contains("potamoi synth --json"),
        "{gone}"
    );
}
