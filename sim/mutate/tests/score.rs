//! Mutants of the vector unit of preset `small`, and their judges.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use potamoi_formats::config::Config;
use potamoi_mutate::{Design, Fate, Judge, Options, Score, Tools, score};
use potamoi_prove::{Unit, units_as_built};

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
    let draw = |seed| Design::new(&tools, &unit, MUTANTS, seed).unwrap().mutants;
    let mutants = draw(1);
    assert_eq!(mutants.len(), 3 * MUTANTS as usize, "{mutants:?}");
    assert_eq!(mutants, draw(1));
    assert_ne!(mutants, draw(2));
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn the_bench_and_the_miter_judge_mutants() {
    let (config, unit) = vector_unit();
    let options = Options {
        judges: BTreeSet::from([Judge::Bench, Judge::Miter]),
        mutants: MUTANTS,
        seed: 1,
        cycles: 4,
        kept: None,
    };
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
