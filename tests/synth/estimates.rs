//! `potamoi estimate`, which needs no program.

use crate::common::{self, json, potamoi, stderr};

#[test]
fn units_are_estimated_without_synthesis() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let estimate = |code: i32, arguments: &[&str]| {
        let all = [&["estimate", "--json", "e.json"], arguments].concat();
        let output = potamoi()
            .current_dir(at)
            .env("PATH", at)
            .args(all)
            .output()
            .unwrap();
        let said = common::stdout(&output) + &stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{said}");
        said
    };
    let said = estimate(0, &[]);
    assert!(
        said.contains("gathering_unit, by formulas fitted to 20 syntheses"),
        "{said}"
    );
    let report = json(&at.join("e.json"));
    assert_eq!(report["format_version"], 1);
    assert_eq!(report["library"]["node_nm"], 7);
    assert_eq!(report["tools"]["opensta"], "2.0.17");
    let units = report["units"].as_array().unwrap();
    assert_eq!(units.len(), 2);
    for unit in units {
        let number = |field: &str| unit[field].as_f64().unwrap();
        assert!(
            number("area_um2") > 10_000.0 && number("period_ps") > 500.0,
            "{unit}"
        );
        assert!(
            number("with_glitches_pj") > number("zero_delay_pj"),
            "{unit}"
        );
        for figure in ["area", "period", "zero_delay", "with_glitches"] {
            let rms = unit["errors"][figure]["rms"].as_f64().unwrap();
            // Vector units are mapped to periods and glitches that scatter more.
            let most = match figure {
                "period" => 0.08,
                "with_glitches" => 0.06,
                _ => 0.05,
            };
            assert!((0.001..most).contains(&rms), "{figure}: {rms}");
        }
        assert!(unit["formulas"].as_array().unwrap().len() > 10);
        // What is scaled is printed beside what is not.
        let scaled = |field: &str| unit["scaled"][field].as_f64().unwrap();
        for (field, factor) in [
            ("area_um2", 2.29),
            ("period_ps", 1.26),
            ("with_glitches_pj", 1.86),
        ] {
            assert!((scaled(field) / number(field) / factor - 1.0).abs() < 1e-12);
        }
        for (field, name, digits, unit) in [
            ("area_um2", "mm^2", 4, 1e-6),
            ("period_ps", "ps", 0, 1.0),
            ("with_glitches_pj", "pJ", 2, 1.0),
        ] {
            let [raw, other] = [number(field) * unit, scaled(field) * unit];
            let words = format!("{raw:.digits$} {name} {other:.digits$} {name}");
            let printed = common::words(&said);
            assert!(printed.contains(&words), "{words}: {printed}");
        }
    }
    assert_eq!(units[0]["energies_of"]["vertices"], 8);
    assert_eq!(units[0]["memories"][0]["module"], "mft_bank");
    let paper = json(std::path::Path::new("synth/paper-asap7.json"));
    let paper = &paper["raw"]["units"][0];
    let [cells, with_memories] = [&paper["period_ps"], &paper["with_memories"]["period_ps"]]
        .map(|ps| ps.as_f64().unwrap().round());
    let period = format!(
        "the period excludes paths from and to memories (of the preset `paper` {with_memories} ps \
         with their access times and {cells} ps without, as synthesised)"
    );
    for line in [
        "energies are of samples of `lantern` with 8 vertices each",
        "energies are of the workload of `garden`",
        "memory mft_bank: 64 of 512 x 16 bit, not included",
        &period,
    ] {
        assert!(common::words(&said).contains(line), "{said}");
    }
    // The same unit at rest takes what its clock takes.
    estimate(0, &["--unit", "gu", "--busy", "0"]);
    let rest = json(&at.join("e.json"));
    let rest = &rest["units"][0];
    assert_eq!(rest["zero_delay_pj"], rest["clock_pj"]);
    assert!(rest["zero_delay_pj"].as_f64() < units[0]["zero_delay_pj"].as_f64());

    std::fs::write(at.join("small.toml"), "gu.banks = 4\n").unwrap();
    let said = estimate(0, &["--config", "small.toml", "--unit", "gu"]);
    assert!(
        common::words(&said).contains("gu.banks = 4, the grid has 8 to 64"),
        "{said}"
    );
    std::fs::remove_file(at.join("e.json")).unwrap();
    std::fs::write(at.join("grid.json"), "{\"format_version\": 9}").unwrap();
    // Of two units the second one is refused: nothing is printed of the first.
    let said = estimate(2, &["--config", "piecewise"]);
    assert!(
        said.contains("vu.exp.form") && !said.contains("fitted to"),
        "{said}"
    );
    for (arguments, said) in [
        (
            &["--config", "compact"][..],
            "rit.entry = \"compact\", expected \"paper\"",
        ),
        (&["--busy", "1.5"], "--busy 1.5: expected a share, 0 to 1"),
        (&["--busy", "NaN"], "--busy NaN: expected"),
        (
            &["--channels", "0"],
            "--channels 0: expected a whole number, 1 to 4096",
        ),
        (&["--scale-to", "5"], "--scale-to 5: no factors from 7 nm"),
        (&["--fit-to", "gone.json"], "gone.json"),
        (&["--fit-to", "grid.json"], "format_version 9, expected 3"),
    ] {
        let found = estimate(2, arguments);
        assert!(found.contains(said), "{arguments:?}: {found}");
        assert!(!at.join("e.json").exists(), "{arguments:?}");
    }
}
