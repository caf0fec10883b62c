//! The properties of the presets, as they were proven; and that each can fail.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::PathBuf;

use potamoi_formats::config::{Config, PRESETS};
use potamoi_prove::{Options, Outcome, Proof, Property, Tools, Unit, units};

/// Twice the vertices of the longest group, and the way through every pipeline.
const CYCLES: u32 = 24;

fn config(preset: &str) -> Config {
    let (_, text) = PRESETS.iter().find(|(name, _)| *name == preset).unwrap();
    Config::from_toml(text, preset).unwrap()
}

fn prove(preset: &str, cover: u32) -> Vec<Proof> {
    let tools = Tools::find().unwrap_or_else(|e| panic!("{e}"));
    let options = Options {
        depth: CYCLES,
        cover,
    };
    let all = units(&config(preset)).unwrap();
    all.iter()
        .map(|unit| {
            unit.prove(&tools, options)
                .unwrap_or_else(|e| panic!("{e}"))
        })
        .collect()
}

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("outcomes.csv")
}

const HEAD: &str = "preset,unit,property,kind,method,outcome,cycles,seconds of the unit";

fn line(preset: &str, proof: &Proof, name: &str, supports: bool, outcome: Outcome) -> String {
    let (method, said, cycles) = match outcome {
        Outcome::Proven => ("induction", "proven", String::new()),
        Outcome::Bounded(n) => ("bounded", "bounded", n.to_string()),
        Outcome::Failed(n) => ("bounded", "failed", n.to_string()),
        Outcome::Reached(n) => ("cover", "reached", n.to_string()),
        Outcome::NotReached(n) => ("cover", "not reached", n.to_string()),
    };
    let kind = match (outcome, supports) {
        (Outcome::Reached(_) | Outcome::NotReached(_), _) => "cover",
        (_, true) => "invariant",
        (_, false) => "property",
    };
    let seconds = match method {
        "cover" => proof.cover_seconds,
        _ => proof.seconds,
    };
    format!(
        "{preset},{},{name},{kind},{method},{said},{cycles},{seconds:.0}",
        proof.unit
    )
}

/// Kept outcomes by preset, unit and property.
fn kept() -> BTreeMap<[String; 3], Outcome> {
    let text = std::fs::read_to_string(path()).unwrap();
    let lines = text.lines().skip(1);
    lines
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            let cycles = fields[6].parse().unwrap_or(0);
            let outcome = match fields[5] {
                "proven" => Outcome::Proven,
                "bounded" => Outcome::Bounded(cycles),
                "failed" => Outcome::Failed(cycles),
                "reached" => Outcome::Reached(cycles),
                "not reached" => Outcome::NotReached(cycles),
                other => panic!("{}: outcome {other}", path().display()),
            };
            ([0, 1, 2].map(|i| fields[i].to_owned()), outcome)
        })
        .collect()
}

/// Holds the outcomes of a preset against those kept; with `POTAMOI_REFRESH` keeps them.
fn hold(preset: &str, cover: u32) {
    let proofs = prove(preset, cover);
    if std::env::var_os("POTAMOI_REFRESH").is_some() {
        let old = std::fs::read_to_string(path()).unwrap_or_default();
        let others = old.lines().skip(1);
        let others = others.filter(|line| !line.starts_with(&format!("{preset},")));
        let mut lines: BTreeSet<String> = others.map(str::to_owned).collect();
        for proof in &proofs {
            for p in &proof.properties {
                lines.insert(line(preset, proof, &p.name, p.supports, p.outcome));
            }
        }
        let mut text = format!("{HEAD}\n");
        for line in lines {
            let _ = writeln!(text, "{line}");
        }
        std::fs::write(path(), text).unwrap();
        return;
    }
    let expected = kept();
    let mut seen = 0;
    for proof in &proofs {
        for p in &proof.properties {
            let key = [preset, &proof.unit, &p.name].map(str::to_owned);
            let kept = expected.get(&key);
            let kept =
                kept.unwrap_or_else(|| panic!("{key:?} is new: refresh {}", path().display()));
            assert!(
                p.outcome.keeps(*kept),
                "{key:?}: {:?}, was {kept:?}",
                p.outcome
            );
            assert!(!matches!(p.outcome, Outcome::Failed(_)), "{key:?} fails");
            seen += 1;
        }
    }
    let covered =
        |outcome: &Outcome| matches!(outcome, Outcome::Reached(_) | Outcome::NotReached(_));
    let all = expected
        .iter()
        .filter(|(key, o)| key[0] == preset && (cover > 0 || !covered(o)));
    assert_eq!(seen, all.count(), "a property of {preset} is gone");
}

#[test]
fn small_is_proven_as_kept() {
    hold("small", 0);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn all_presets_are_proven_as_kept() {
    for (preset, _) in PRESETS {
        let cover = if preset == "small" { 40 } else { 0 };
        hold(preset, cover);
    }
}

fn packer(lanes: u32) -> Unit {
    let text = format!("[su]\nlanes = {lanes}\ntiles = 2\n");
    let config = Config::from_toml(&text, "packer").unwrap();
    let mut all = units(&config).unwrap().into_iter();
    all.find(|unit| unit.name == "splat_powers").unwrap()
}

/// The packer of a splat unit loses and reorders no pair.
fn packers_are_proven(lanes: &[u32]) {
    let tools = Tools::find().unwrap_or_else(|e| panic!("{e}"));
    let options = Options {
        depth: CYCLES,
        cover: 0,
    };
    for lanes in lanes.iter().copied() {
        let proof = packer(lanes).prove(&tools, options);
        let proof = proof.unwrap_or_else(|e| panic!("{lanes} lanes: {e}"));
        let others = |p: &&Property| p.outcome != Outcome::Proven;
        let others: Vec<_> = proof.properties.iter().filter(others).collect();
        assert!(others.is_empty(), "{lanes} lanes: {others:?}");
        let names: BTreeSet<&str> = proof.properties.iter().map(|p| p.name.as_str()).collect();
        assert!(names.is_superset(&BTreeSet::from(["packed_in_order", "none_lost", "balance"])));
    }
}

#[test]
fn packers_of_few_lanes_are_proven() {
    packers_are_proven(&[1, 5]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn packers_of_any_number_of_lanes_are_proven() {
    packers_are_proven(&[2, 4, 16, 24, 64]);
}

/// A packer that pads without a shift, takes padding for pairs, or counts a vector twice.
#[test]
fn a_packer_that_loses_pairs_fails() {
    let tools = Tools::find().unwrap_or_else(|e| panic!("{e}"));
    for (property, from, to) in [
        ("packed_in_order", "if (shifts) begin", "if (accepts) begin"),
        ("none_lost", "{accepts, info}", "{shifts, info}"),
        ("balance", "(in_flight + 2'd1)", "(in_flight + 2'd2)"),
    ] {
        let mut unit = packer(5);
        let edit = ["splat_powers.v", from, to].map(str::to_owned);
        unit.edits.push(edit);
        let found = unit.look(&tools, property, CYCLES);
        let found = found.unwrap_or_else(|e| panic!("{property}: {e}"));
        assert!(matches!(found, Outcome::Failed(_)), "{property}: {found:?}");
    }
}
