//! The properties of the presets, as they were proven; and that each can fail.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::PathBuf;

use potamoi_formats::config::{Config, PRESETS};
use potamoi_prove::{Options, Outcome, Proof, Tools, units};

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
