//! Every property can fail: each is shown to on a mutant of the preset `small`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod data;
mod feature_major;
mod gathering;
mod top;
mod vector;

use std::collections::BTreeSet;

use potamoi_formats::config::{Config, PRESETS};
use potamoi_netlist::CheckKind;
use potamoi_prove::{Outcome, Tools, Unit, units};

/// Cycles of the runs, a short one first. The longer one fills the pipeline and the FIFO behind it.
const CYCLES: [u32; 2] = [12, 40];

/// A property, the file that a mutant edits, and what it replaces.
type Mutant = [&'static str; 4];

fn of_preset(preset: &str) -> Vec<Unit> {
    let (_, text) = PRESETS.iter().find(|(name, _)| *name == preset).unwrap();
    units(&Config::from_toml(text, preset).unwrap()).unwrap()
}

fn sets() -> Vec<(Unit, &'static [Mutant])> {
    let of = |unit: Unit| {
        let mutants: &[Mutant] = match unit.name.as_str() {
            "gathering_unit" => &gathering::GATHERING,
            "mft_bank" => &data::BANK,
            "mft_halves" => &data::HALVES,
            "reducer" => &data::REDUCER,
            "rit_bank" => &data::RIT_BANK,
            "vector_unit" => &vector::VECTOR,
            "vector_lane" => &data::LANE,
            "potamoi_npu_ext" => &top::TOP,
            other => panic!("{other} has no mutants"),
        };
        (unit, mutants)
    };
    of_preset("small").into_iter().map(of).collect()
}

fn have_mutants(unit: &Unit, mutants: &[Mutant], counts: impl Fn(&str) -> bool) {
    let all = unit.checks();
    let properties = all.iter().filter(|c| c.kind == CheckKind::Assert);
    let properties = properties.map(|c| c.path.as_str());
    let properties: BTreeSet<&str> = properties.filter(|path| counts(path)).collect();
    let shown: BTreeSet<&str> = mutants.iter().map(|[name, ..]| *name).collect();
    assert_eq!(properties, shown, "{}", unit.name);
}

#[test]
fn every_property_has_a_mutant() {
    for (unit, mutants) in sets() {
        have_mutants(&unit, mutants, |_| true);
    }
    // The RIT buffer and the FIFO are those of `small`.
    let unit = &of_preset("feature-major")[0];
    let anew = |path: &str| {
        !path.contains('.') || path.starts_with("mft.") || path.starts_with("lane_of_group[]")
    };
    have_mutants(unit, &feature_major::UNIT, anew);
}

fn dies(tools: &Tools, unit: &Unit, [property, file, from, to]: Mutant) -> Outcome {
    let mut mutant = unit.clone();
    mutant.edits.push([file, from, to].map(str::to_owned));
    for cycles in CYCLES {
        let found = mutant.look(tools, property, cycles);
        let found = found.unwrap_or_else(|e| panic!("{property}: {e}"));
        if matches!(found, Outcome::Failed(_)) {
            return found;
        }
    }
    panic!("{property} does not fail with `{to}` in {file}")
}

#[test]
fn some_mutants_fail() {
    let tools = Tools::find().unwrap_or_else(|e| panic!("{e}"));
    let (gathering, of_gathering) = sets().swap_remove(0);
    for mutant in of_gathering
        .iter()
        .filter(|m| ["mft.halves_apart", "rit.never_stuck"].contains(&m[0]))
    {
        dies(&tools, &gathering, *mutant);
    }
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_property_fails_on_its_mutant() {
    let tools = Tools::find().unwrap_or_else(|e| panic!("{e}"));
    for (unit, mutants) in sets() {
        for mutant in mutants {
            let found = dies(&tools, &unit, *mutant);
            println!("{} {}: {found:?}", unit.name, mutant[0]);
        }
    }
    let unit = &of_preset("feature-major")[0];
    for mutant in feature_major::UNIT {
        let found = dies(&tools, unit, mutant);
        println!("feature-major {}: {found:?}", mutant[0]);
    }
}
