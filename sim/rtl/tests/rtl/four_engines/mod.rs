//! One set of vectors on four engines: the netlist interpreter and Verilator with random state
//! before reset, Icarus Verilog with unknown state, and gates. All ports agree in every bit and
//! cycle, with one another and with the reference unit and the cycle model.
mod gates;
mod jobs;
mod mutants;
mod units;

use potamoi_formats::config::Config;
use potamoi_formats::units::{GATHERING_UNIT, VECTOR_UNIT};
use potamoi_rtl::EngineKind;

use jobs::Job;
use units::{Run, Text, Unit};

/// Seeds of the state before reset on engines of two values.
const STATES: [u64; 3] = [1, 0x5eed, u32::MAX as u64];

const BOTH: [&str; 2] = [GATHERING_UNIT, VECTOR_UNIT];

/// Two ports, so that beats have ports without an entry, and lanes that stay empty. Gates of a
/// multiplier take minutes, and are all the same.
pub(crate) const TINY: &str = "[gu]\nbanks = 2\nports = 2\nsegments = 3\n[rit]\nentries = 4\n\
     [mvoxel]\nrows = 64\n[vu]\nlanes = 2\n\
     ops = [\"add\", \"exp\", \"one-minus-exp\"]\n[vu.exp]\niterations = 8";

const SIMULATORS: [EngineKind; 2] = [EngineKind::Icarus, EngineKind::Verilator];

/// An engine, and the states that it begins with.
struct Engine {
    name: &'static str,
    unit: Unit,
    states: &'static [u64],
}

fn engine(name: &'static str, unit: Unit, states: &'static [u64]) -> Engine {
    Engine { name, unit, states }
}

/// The engines of a unit of `config`.
fn engines(config: &Config, unit: &str) -> Vec<Engine> {
    let on = |kind| Unit::of(kind, config, unit, Text::Own);
    vec![
        engine("interpreter", on(EngineKind::Interpreter), &STATES),
        engine("verilator", on(EngineKind::Verilator), &STATES),
        engine("icarus", on(EngineKind::Icarus), &[0]),
    ]
}

/// The same of its gates on one of the simulators or both.
fn gate_engines(config: &Config, unit: &str, simulators: &[EngineKind]) -> Vec<Engine> {
    let files = gates::of(unit, &units::verilog_of(config, unit));
    let of = |&kind: &EngineKind| {
        let unit = Unit::of(kind, config, unit, Text::Files(&files));
        match kind {
            EngineKind::Icarus => engine("gates on icarus", unit, &[0]),
            _ => engine("gates on verilator", unit, &STATES[..2]),
        }
    };
    simulators.iter().map(of).collect()
}

/// The first difference of the runs of a job, in words.
fn difference(engines: &[Engine], config: &Config, job: &Job) -> Option<String> {
    let mut first: Option<(String, Run)> = None;
    for engine in engines {
        for &state in engine.states {
            let label = format!("{}, state {state}", engine.name);
            let run = engine.unit.run(config, job, state);
            let (other, base) = first.get_or_insert_with(|| (label.clone(), run.clone()));
            if let Some(d) = base.trace.first_difference(&run.trace) {
                let port = d.port;
                return Some(format!(
                    "cycle {}: {port} is {} on {other}, and {} on {label}; {label}: {:?}",
                    d.cycle, d.first, d.second, run.totals
                ));
            }
            match (&base.totals, &run.totals) {
                (_, Err(why)) => return Some(format!("{label}: {why}")),
                (base, found) if base != found => {
                    return Some(format!("{other}: {base:?}, {label}: {found:?}"));
                }
                _ => {}
            }
        }
    }
    let (_, run) = first.expect("an engine");
    assert!(run.trace.beats() > 0 && run.trace.cycles() > run.trace.beats());
    None
}

/// Runs jobs of the seeds on both units, or of the seed that `FOUR_ENGINES_SEED` names.
fn agree(
    test: &str,
    name: &str,
    config: &Config,
    units: &[&str],
    seeds: std::ops::Range<u64>,
    make: impl Fn(&Config, &str) -> Vec<Engine>,
) {
    let only = std::env::var("FOUR_ENGINES_SEED").ok().map(|text| {
        text.parse()
            .unwrap_or_else(|_| panic!("FOUR_ENGINES_SEED is {text}: expected a number"))
    });
    for &unit in units {
        let engines = make(config, unit);
        let (mut runs, begun) = (0, std::time::Instant::now());
        for seed in only.map_or(seeds.clone(), |seed| seed..seed + 1) {
            for job in jobs::of(config, unit, seed) {
                if let Some(why) = difference(&engines, config, &job) {
                    panic!(
                        "{name}, {unit}, seed {seed}, {}: {why}\nagain: FOUR_ENGINES_SEED={seed} \
                         cargo test -p potamoi-rtl --test rtl four_engines::{test} -- \
                         --include-ignored --exact",
                        job.name
                    );
                }
                runs += engines.iter().map(|e| e.states.len()).sum::<usize>();
            }
        }
        println!("{name}, {unit}: {runs} runs agree, {:?}", begun.elapsed());
    }
}

#[test]
fn the_small_units_agree() {
    let config = Config::preset("small").unwrap();
    let test = "the_small_units_agree";
    agree(test, "small", &config, &BOTH, 0..1, engines);
}

/// Every engine, with gates on the simulators, of one unit or both.
fn all_agree(
    test: &str,
    (name, text): (&str, &str),
    units: &[&str],
    seeds: std::ops::Range<u64>,
    gates_on: &[EngineKind],
) {
    let config = Config::from_toml(text, name).unwrap_or_else(|e| panic!("{name}: {e}"));
    agree(test, name, &config, units, seeds, |config, unit| {
        let mut all = engines(config, unit);
        all.extend(gate_engines(config, unit, gates_on));
        all
    });
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn gates_of_the_vector_unit_agree() {
    let test = "gates_of_the_vector_unit_agree";
    all_agree(test, ("tiny", TINY), &[VECTOR_UNIT], 0..2, &SIMULATORS);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn gates_of_the_gathering_unit_agree() {
    let test = "gates_of_the_gathering_unit_agree";
    all_agree(test, ("tiny", TINY), &[GATHERING_UNIT], 0..1, &SIMULATORS);
}

/// Organisations and forms of entries, in sizes that gates and events can run. Verilator takes many minutes
/// for gates of these.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn units_of_every_organisation_agree() {
    let eight = "modes = \"structured\"\nvertices = [8]\n";
    let vu = "[vu]\nlanes = 2\nops = [\"add\", \"exp\", \"one-minus-exp\"]\n[vu.exp]\n";
    let rit = "[rit]\nentries = 4\n";
    for (name, text) in [
        (
            "paper, reduced",
            format!("[gu]\nbanks = 4\nports = 2\n{rit}{vu}iterations = 16\n"),
        ),
        (
            "parity",
            format!(
                "[gu]\norganisation = \"parity\"\nbanks = 8\n{eight}{rit}{vu}early_out = true\n"
            ),
        ),
        (
            "feature-major",
            format!(
                "[gu]\norganisation = \"feature-major\"\nbanks = 4\nlanes = 4\n{rit}\
                 [mvoxel]\nrows = 64\n{vu}form = \"piecewise\"\npipelined = true\n"
            ),
        ),
        (
            "compact, pipelined",
            format!(
                "[gu]\nbanks = 2\npipelined = true\n{rit}entry = \"compact\"\n[mvoxel]\nrows = 64\n\
                 {vu}form = \"radix-4\"\niterations = 4\ntail = true\n"
            ),
        ),
    ] {
        let test = "units_of_every_organisation_agree";
        all_agree(test, (name, &text), &BOTH, 0..1, &SIMULATORS[..1]);
    }
}
