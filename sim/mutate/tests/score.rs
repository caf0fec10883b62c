//! Mutants of the vector unit of preset `small`, and their judges.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};

use potamoi_formats::config::Config;
use potamoi_mutate::{Design, Draw, Fate, Judge, Mutant, Options, Score, Tools, score};
use potamoi_prove::{Unit, top_as_built, units_as_built};

const MUTANTS: u32 = 10;

fn vector_unit() -> (Config, Unit) {
    let config = Config::preset("small").unwrap();
    let mut units = units_as_built(&config).unwrap();
    (config, units.remove(1))
}

#[test]
fn equal_seeds_draw_equal_mutants() {
    let (_, unit) = vector_unit();
    let tools = Tools::find(&BTreeSet::new()).unwrap();
    let draw = |seed, modules: &[&str]| {
        let modules = modules.iter().map(|&name| name.to_owned()).collect();
        let draw = Draw {
            seed,
            modules,
            ..options().draw
        };
        Design::new(&tools, &unit, &draw).unwrap().mutants
    };
    let mutants = draw(1, &[]);
    assert_eq!(mutants.len(), 3 * MUTANTS as usize, "{mutants:?}");
    assert_eq!(mutants, draw(1, &[]));
    assert_ne!(mutants, draw(2, &[]));
    // A module alone has the same mutants as beside others.
    let places = |mutants: &[Mutant]| -> Vec<String> {
        let own = mutants.iter().filter(|m| m.module == "vector_lane");
        own.map(|m| m.command.clone()).collect()
    };
    let alone = draw(1, &["vector_lane"]);
    assert_eq!(alone.len(), MUTANTS as usize, "{alone:?}");
    assert_eq!(places(&alone), places(&mutants));
}

/// A netlist that differs from the one of its score in nothing but names has the same digest.
#[test]
fn the_scores_of_the_book_are_of_these_netlists() {
    let config = Config::preset("small").unwrap();
    let top = top_as_built(&config).unwrap();
    let page = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../docs/explanation/mutation.md"
    );
    let page = std::fs::read_to_string(page).unwrap();
    let (_, listed) = page.split_once("<!-- netlists of the scores:").unwrap();
    let (listed, _) = listed.split_once("-->").unwrap();
    let listed: BTreeMap<&str, &str> = listed
        .split_whitespace()
        .map(|one| one.split_once('=').unwrap())
        .collect();
    for (module, digest) in top.module.digests() {
        let digest = digest.to_string();
        assert_eq!(
            listed.get(&*module).copied(),
            Some(&*digest),
            "{module} is another netlist than that of its score in docs/explanation/mutation.md: judge it \
             again (potamoi --config small mutate --module {module} --json score.json), and write its row \
             and its digest, which is in the JSON"
        );
        assert!(
            page.contains(&format!("| `{module}` |")),
            "no row of {module}"
        );
    }
}

fn options() -> Options {
    Options {
        judges: BTreeSet::from([Judge::Bench, Judge::Miter]),
        draw: Draw {
            mutants: MUTANTS,
            modules: BTreeSet::new(),
            seed: 1,
        },
        cycles: 4,
        kept: None,
    }
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn no_mutant_that_the_bench_finds_is_called_equivalent() {
    let config = Config::preset("small").unwrap();
    let unit = units_as_built(&config).unwrap().remove(0);
    let judged = |judge| {
        let options = Options {
            judges: BTreeSet::from([judge]),
            draw: Draw {
                mutants: 60,
                modules: BTreeSet::from(["rit_buffer".to_owned()]),
                ..options().draw
            },
            ..options()
        };
        let tools = Tools::find(&options.judges).unwrap();
        let none = |_: &_| Ok(None);
        score(&tools, &config, &unit, &options, &none, &|_, _, _| {}).unwrap()
    };
    let (bench, miter) = (judged(Judge::Bench), judged(Judge::UnitMiter));
    let pairs = bench.iter().zip(&miter);
    let both: Vec<_> = pairs
        .filter(|(b, m)| b.fate != Fate::Alive && m.fate != Fate::Alive)
        .collect();
    assert!(both.is_empty(), "{both:?}");
    let equivalent = miter.iter().filter(|m| m.fate != Fate::Alive).count();
    assert!((1..60).contains(&equivalent), "{equivalent}");
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn the_bench_and_the_miter_judge_mutants() {
    let (config, unit) = vector_unit();
    let options = options();
    let tools = Tools::find(&options.judges).unwrap();
    let none = |_: &_| Ok(None);
    let judged = score(&tools, &config, &unit, &options, &none, &|_, _, _| {}).unwrap();
    let sum = Score::sum(&judged);
    eprintln!("{sum:?}");
    assert_eq!(sum.mutants, 3 * MUTANTS as usize);
    assert_eq!(sum.bench + sum.equivalent + sum.alive, sum.mutants);
    assert!(sum.bench * 10 >= sum.mutants * 7, "{sum:?}");
    assert!(
        judged
            .iter()
            .any(|m| matches!(&m.fate, Fate::Bench { said, .. } if said.contains("FAIL")))
    );
}
