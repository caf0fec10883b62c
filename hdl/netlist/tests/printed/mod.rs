//! What is printed passes Verilator's, Icarus' and Yosys' checks and means what
//! the interpreter says: every kind of node by itself at every odd width, and
//! random hierarchies, whose names, sections, unread bits and open outputs are
//! what linters look at.
//!
//! `POTAMOI_SEED=N` runs the random module of that seed alone.

mod bench;
mod every_kind;
mod grow;
mod kinds;
mod values;

use std::path::PathBuf;
use std::sync::Arc;

use potamoi_netlist::{Module, ModuleBuilder, Ty};

use bench::{Bench, Outputs};

/// Random modules of a default run.
const SEEDS: u64 = 20;

fn cache() -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("models")
}

fn agree(bench: &Bench, left: (&str, &Outputs), right: (&str, &Outputs)) {
    if let Some(d) = bench.difference(left, right) {
        let module = d.port.split("__").next().unwrap_or_default();
        let again = match module.strip_prefix("random_") {
            Some(seed) => format!(
                "POTAMOI_SEED={seed} cargo test -p potamoi-netlist --test netlist printed::random_modules"
            ),
            None => "cargo test -p potamoi-netlist --test netlist printed::every_kind".to_owned(),
        };
        let file = bench.files.iter().find(|f| f.0 == format!("{module}.v"));
        let text = file.map_or("", |f| f.1.as_str());
        panic!("{}\nrun again: {again}\n{text}", d.text);
    }
}

fn all_agree(modules: &[Arc<Module>], cycles: usize, seed: u64, expected: &[&str]) {
    let bench = Bench::new(bench::side_by_side(modules), cycles, seed);
    bench.lint(expected);
    let interpreted = bench.interpret(1);
    // Contents before the first write or reset must not matter.
    agree(
        &bench,
        ("the interpreter", &interpreted),
        ("the interpreter from other contents", &bench.interpret(2)),
    );
    agree(
        &bench,
        ("the interpreter", &interpreted),
        ("Icarus", &bench.icarus(&bench.files)),
    );
    agree(
        &bench,
        ("the interpreter", &interpreted),
        ("Verilator", &bench.verilate(&cache())),
    );
}

#[test]
fn every_kind_of_node_at_every_odd_width() {
    // Either side of the words that simulators hold values in.
    all_agree(
        &[1, 2, 31, 32, 33, 64, 65, 129].map(every_kind::module),
        60,
        1,
        &[],
    );
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_kind_of_node_at_more_widths() {
    all_agree(&every_kind::WIDTHS.map(every_kind::module), 60, 1, &[]);
}

#[test]
fn random_modules() {
    let seeds = match std::env::var("POTAMOI_SEED") {
        Ok(seed) => vec![seed.parse().expect("POTAMOI_SEED is a number")],
        Err(_) => (0..SEEDS).collect(),
    };
    run_random(&seeds);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn many_random_modules() {
    for first in (1000..3000).step_by(100) {
        run_random(&(first..first + 100).collect::<Vec<_>>());
    }
}

/// A case statement that waits for constants would never run.
#[test]
fn choices_that_constants_make() {
    let mut m = ModuleBuilder::new("fixed_choices");
    let options: Vec<_> = (0..4)
        .map(|i| m.input(&format!("option{i}"), Ty::u(5), ""))
        .collect();
    let own = m.lit(2, Ty::u(2));
    let named = m.param("PLACE", 1, Ty::u(2), "");
    let signed = m.lit(-1, Ty::s(2));
    let cast = m.as_unsigned(signed);
    let computed = m.sub(named, own);
    let computed = m.name(computed, "place_less_two");
    for (i, index) in [own, named, cast, computed].into_iter().enumerate() {
        let chosen = m.select(index, &options);
        m.output(&format!("chosen{i}"), chosen, "");
        let constants: Vec<_> = (0..4).map(|v| m.lit(v * 7, Ty::u(5))).collect();
        let fixed = m.select(index, &constants);
        let mixed = m.xor(fixed, options[0]);
        m.output(&format!("mixed{i}"), mixed, "");
    }
    all_agree(&[m.finish().unwrap()], 20, 1, &[]);
}

fn run_random(seeds: &[u64]) {
    let modules: Vec<_> = seeds
        .iter()
        .map(|s| grow::module(&format!("random_{s}"), *s))
        .collect();
    // Chance compares constants, which a linter is right to ask about.
    all_agree(&modules, 50, seeds[0], &["CMPCONST", "UNSIGNED"]);
}

/// The module of this width alone, its files with one text replaced, and what
/// Icarus makes of them.
fn with_a_fault(width: u32, right: &str, wrong: &str) -> Option<bench::Difference> {
    let bench = Bench::new(every_kind::module(width), 60, 1);
    let [(name, text)] = &bench.files[..] else {
        panic!("one file is expected")
    };
    assert!(text.contains(right), "`{right}` is not in\n{text}");
    let files = [(name.clone(), text.replacen(right, wrong, 1))];
    let (interpreted, simulated) = (bench.interpret(1), bench.icarus(&files));
    bench.difference(("the interpreter", &interpreted), ("Icarus", &simulated))
}

#[test]
fn a_fault_in_the_verilog_is_found() {
    assert!(with_a_fault(33, "u_a", "u_a").is_none());
    for (right, wrong, port) in [
        (
            "assign u_add = u_a + u_b",
            "assign u_add = u_a - u_b",
            "u_add",
        ),
        ("$signed(s_a) < $signed(s_b)", "s_a < s_b", "s_lt"),
        ("u_sum <= 33'd1", "u_sum <= 33'd2", "u_reg"),
        (
            "u_sum <= u_sum + u_a;",
            "if (choose) u_sum <= u_sum + u_a;",
            "u_reg",
        ),
    ] {
        let found =
            with_a_fault(33, right, wrong).unwrap_or_else(|| panic!("`{wrong}` was not found"));
        assert_eq!(found.port, port, "{}", found.text);
    }
}
