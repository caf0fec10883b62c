//! The verifier on the built-in scenes: what is right passes on every engine,
//! what is wrong is found, named, and shown in a dump.
use std::path::Path;

use potamoi_formats::config::{Config, PRESETS};
use potamoi_rtl::EngineKind;
use potamoi_rtl::verify::{Injection, Settings, Verifier};
use potamoi_scene::Scene;
use potamoi_units::gathering_unit::gathering_unit;

use crate::scenes_common::{garden_through, lantern_through, verified};

const SEED: u64 = 11;

fn settings(engine: EngineKind) -> Settings {
    Settings {
        engine,
        seed: SEED,
        gather_every: 1,
        vector_every: 1,
        splat_every: 1,
        inject: None,
        rtl: None,
        excerpt: None,
    }
}

fn config(text: &str) -> Config {
    Config::from_toml(text, "test").unwrap()
}

fn preset(name: &str) -> Config {
    let text = PRESETS.iter().find(|(n, _)| *n == name).unwrap().1;
    config(text)
}

/// Renders the garden, `side` pixels a side; the error of a unit, if any.
#[test]
fn the_paper_preset_passes_on_both_scenes() {
    let config = Config::paper();
    let mut calls = 0;
    let mut count = |_| calls += 1;
    let mut verifier = Verifier::new(&config, settings(EngineKind::Verilator), &mut count);
    verified(&mut verifier, |units| garden_through(units, 20)).unwrap();
    verified(&mut verifier, |units| lantern_through(units, &config, 32)).unwrap();
    assert_eq!(verifier.failure(), None);
    let (g, v) = (
        verifier.gather_report().clone(),
        verifier.vector_report().clone(),
    );
    assert!(g.samples > 2_000 && g.mvoxels > 20, "{g:?}");
    assert_eq!((g.samples, g.mvoxels), (g.samples_total, g.mvoxels_total));
    assert_eq!((g.cycles, g.fill), (g.cycles_predicted, g.fill_predicted));
    assert_eq!(g.cycles, g.busy + g.stall_fifo + g.stall_mft + g.stall_rit);
    assert!(g.cycles_stalled > g.cycles, "{g:?}");
    assert!(v.elements > 40_000, "{v:?}");
    assert_eq!(
        (v.elements, v.cycles),
        (v.elements_total, v.cycles_predicted)
    );
    assert!(calls > 4);
}

#[test]
fn a_share_is_what_was_asked_for() {
    let config = Config::paper();
    let mut none = |_| {};
    let quick = Settings {
        gather_every: 5,
        vector_every: 50,
        ..settings(EngineKind::Verilator)
    };
    let mut verifier = Verifier::new(&config, quick, &mut none);
    verified(&mut verifier, |units| garden_through(units, 64)).unwrap();
    let (g, v) = (verifier.gather_report(), verifier.vector_report());
    assert_eq!(g.mvoxels, g.mvoxels_total.div_ceil(5));
    let share = v.elements as f64 / v.elements_total as f64;
    assert!((share - 0.02).abs() < 0.01, "{v:?}");
}

/// Every engine runs the same netlist with the same stalls to the same counts.
#[test]
fn engines_agree() {
    let small = config(
        "[gu]\nbanks = 4\nports = 2\nsegments = 4\n[rit]\nentries = 8\n[vu]\nlanes = 3\n\
         [vu.exp]\niterations_per_clock = 5",
    );
    let reports = [
        EngineKind::Verilator,
        EngineKind::Interpreter,
        EngineKind::Icarus,
    ]
    .map(|engine| {
        let mut none = |_| {};
        let share = Settings {
            gather_every: 40,
            vector_every: 997,
            ..settings(engine)
        };
        let mut verifier = Verifier::new(&small, share, &mut none);
        verified(&mut verifier, |units| garden_through(units, 12))
            .unwrap_or_else(|e| panic!("{engine}: {e}"));
        (
            verifier.gather_report().clone(),
            verifier.vector_report().clone(),
        )
    });
    assert!(
        reports[0].0.samples > 20 && reports[0].1.elements > 50,
        "{reports:?}"
    );
    assert_eq!(reports[0], reports[1]);
    assert_eq!(reports[0], reports[2]);
}

/// Values of a port, by time, in a dump.
fn changes(path: &Path, name: &str) -> Vec<(u64, Vec<vcd::Value>)> {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut parser = vcd::Parser::new(file);
    let header = parser.parse_header().unwrap();
    let top = header.items.iter().find_map(|i| match i {
        vcd::ScopeItem::Scope(scope) => Some(scope),
        _ => None,
    });
    let var =
        find_var(&top.unwrap().items, name).unwrap_or_else(|| panic!("no {name} in {path:?}"));
    let (mut time, mut out) = (0, vec![]);
    for command in parser {
        match command.unwrap() {
            vcd::Command::Timestamp(t) => time = t,
            vcd::Command::ChangeScalar(id, value) if id == var => out.push((time, vec![value])),
            vcd::Command::ChangeVector(id, values) if id == var => {
                out.push((time, values.iter().collect()));
            }
            _ => {}
        }
    }
    out
}

fn find_var(items: &[vcd::ScopeItem], name: &str) -> Option<vcd::IdCode> {
    items.iter().find_map(|item| match item {
        vcd::ScopeItem::Var(var) if var.reference == name => Some(var.code),
        vcd::ScopeItem::Scope(scope) => find_var(&scope.items, name),
        _ => None,
    })
}

#[test]
fn an_injected_fault_is_found_and_dumped() {
    faults_are_found(&[
        (EngineKind::Verilator, &[Injection::Bit]),
        (EngineKind::Interpreter, &[Injection::Bit, Injection::Exp]),
    ]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_injected_fault_is_found_and_dumped() {
    let others = [Injection::Bubble, Injection::Weight, Injection::Exp];
    faults_are_found(&[(EngineKind::Verilator, &others)]);
}

fn faults_are_found(cases: &[(EngineKind, &[Injection])]) {
    let folder = tempfile::tempdir().unwrap();
    let small = config("[gu]\nbanks = 16\nports = 2\n[vu]\nlanes = 4");
    for &(engine, injections) in cases {
        for &injection in injections {
            let path = folder.path().join(format!("{engine}-{injection}.vcd"));
            let faulty = Settings {
                inject: Some(injection),
                excerpt: Some(path.clone()),
                gather_every: 9,
                vector_every: if injection.is_of_vector_unit() {
                    100
                } else {
                    5_000
                },
                ..settings(engine)
            };
            let mut none = |_| {};
            let mut verifier = Verifier::new(&small, faulty, &mut none);
            let error =
                verified(&mut verifier, |units| lantern_through(units, &small, 24)).unwrap_err();
            let failure = verifier.failure().expect(&error);
            let m = &failure.mismatch;
            assert!(error.contains(&m.to_string()), "{error}");
            if injection.is_of_vector_unit() {
                assert_eq!(m.module, "vector_unit");
                assert!(m.signal.starts_with("m_axis_vec_tdata"), "{m}");
            } else {
                assert_eq!(m.module, "gathering_unit");
            }
            let is_data = m.signal.starts_with("m_axis_feat_tdata");
            let wants_data = matches!(injection, Injection::Bit | Injection::Weight);
            assert_eq!(is_data, wants_data, "{m}");
            // The dump shows the cycle, and there what was found.
            let excerpt = failure.excerpt.as_ref().unwrap();
            assert_eq!(excerpt.path, path);
            let clock = changes(&path, "clk");
            let at = clock.iter().position(|(t, _)| *t == excerpt.time).unwrap();
            assert_eq!(clock[at].1, [vcd::Value::V0], "{m}");
            assert!(at > 2 && clock.len() > at + 8, "{at} of {}", clock.len());
            if is_data {
                let data = changes(&path, "m_axis_feat_tdata");
                let shown = data.iter().rev().find(|(t, _)| *t <= excerpt.time).unwrap();
                let number = |text: &str| text.parse::<usize>().unwrap();
                let words: Vec<&str> = m.signal.split([' ', ',']).collect();
                let lane = 16 * number(words[3]) + number(words[6]);
                let bits = shown.1.iter().rev().skip(16 * lane).take(16);
                let code = bits.enumerate().fold(0u16, |code, (i, v)| {
                    code | u16::from(*v == vcd::Value::V1) << i
                });
                assert_eq!((code as i16).to_string(), m.found, "{m}");
            }
        }
    }
}

/// The organisation that the paper argues against, on the same scenes.
#[test]
fn the_feature_major_preset_passes_on_both_scenes() {
    let config = preset("feature-major");
    let mut none = |_| {};
    // The vector unit is that of the paper's preset.
    let gathers = Settings {
        vector_every: 1000,
        ..settings(EngineKind::Verilator)
    };
    let mut verifier = Verifier::new(&config, gathers, &mut none);
    verified(&mut verifier, |units| garden_through(units, 32)).unwrap();
    verified(&mut verifier, |units| lantern_through(units, &config, 48)).unwrap();
    assert_eq!(verifier.failure(), None);
    let g = verifier.gather_report();
    assert!(g.samples > 5_000 && g.mvoxels > 40, "{g:?}");
    assert_eq!((g.cycles, g.fill), (g.cycles_predicted, g.fill_predicted));
    let stalls = g.stall_fifo + g.stall_mft + g.stall_rit + g.stall_bank;
    assert_eq!(g.cycles, g.busy + stalls);
    assert!(g.stall_bank > g.busy / 4, "{g:?}");
}

/// One fault of arbitration, one of the crossbar, and those of every
/// organisation.
#[test]
fn faults_of_the_feature_major_unit_are_found() {
    let config = config("[gu]\norganisation = \"feature-major\"\nbanks = 4\nlanes = 4");
    for (injection, signal) in [
        (Injection::Grant, ""),
        (Injection::Crossbar, "m_axis_feat_tdata"),
        (Injection::Bit, "m_axis_feat_tdata"),
        (Injection::Weight, "m_axis_feat_tdata"),
        (Injection::Bubble, ""),
    ] {
        let faulty = Settings {
            inject: Some(injection),
            gather_every: 9,
            vector_every: 5_000,
            ..settings(EngineKind::Interpreter)
        };
        let mut none = |_| {};
        let mut verifier = Verifier::new(&config, faulty, &mut none);
        let error =
            verified(&mut verifier, |units| lantern_through(units, &config, 24)).unwrap_err();
        let m = &verifier.failure().expect(&error).mismatch;
        assert!(m.signal.starts_with(signal), "{injection}: {m}");
        assert_eq!(m.module, "gathering_unit");
    }
}

/// A fault cannot be built into what is not there.
#[test]
fn an_impossible_fault_is_refused() {
    let config = config("[gu]\nmodes = \"unstructured\"");
    let faulty = Settings {
        inject: Some(Injection::Weight),
        ..settings(EngineKind::Interpreter)
    };
    let mut none = |_| {};
    let mut verifier = Verifier::new(&config, faulty, &mut none);
    let error = verified(&mut verifier, |units| garden_through(units, 16)).unwrap_err();
    assert!(error.contains("s1_weight"), "{error}");
    assert_eq!(verifier.failure(), None);
    for injection in [Injection::Grant, Injection::Crossbar] {
        let error = injection.fault(&config);
        assert!(error.inject(&gathering_unit(&config).unwrap()).is_err());
    }
}

/// The garden through a verifier of a configuration with a splat unit; the error of a unit, if any.
fn garden_on_splat_unit(verifier: &mut Verifier<'_>, config: &Config) -> Result<(), String> {
    let mut garden = Scene::open("garden").unwrap();
    garden.set_size(Some(40), Some(24)).unwrap();
    verified(verifier, |units| {
        let done = garden.render_fixed(config, units);
        done.map(|_| ()).map_err(|error| error.to_string())
    })
}

const WITH_SPLAT_UNIT: &str = "[vu.exp]\npipelined = true\n[su]\nlanes = 1\ntiles = 4\n";

/// Every pixel and every cycle of each job, with and without stalls, and nothing for the vector unit.
#[test]
fn the_splat_unit_passes_on_the_garden() {
    for in_power in ["", "opacity = \"in-power\"\n"] {
        let config = config(&format!("{WITH_SPLAT_UNIT}{in_power}"));
        let mut none = |_| {};
        let mut verifier = Verifier::new(&config, settings(EngineKind::Verilator), &mut none);
        garden_on_splat_unit(&mut verifier, &config).unwrap();
        let (s, v) = (verifier.splat_report(), verifier.vector_report());
        assert_eq!((s.jobs, s.jobs_total), (2, 2));
        assert_eq!((s.pixels, s.pixels_total), (6 * 256, 6 * 256));
        assert!(
            s.drawn > 1_000 && s.exponentials >= s.drawn + s.stopped,
            "{s:?}"
        );
        assert!(
            s.cycles_stalled > s.cycles && s.cycles > s.exponentials,
            "{s:?}"
        );
        // Before the first record pixels are cleared and limits are written.
        let before = s.cycles_compared - s.cycles - s.cycles_stalled;
        assert!(before > 0 && before < s.cycles, "{s:?}");
        assert_eq!(v.elements_total, 0);
    }
}

/// One bit of an alpha is found, named, and shown in a dump.
#[test]
fn a_fault_of_the_splat_unit_is_found() {
    let config = config(WITH_SPLAT_UNIT);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("alpha.vcd");
    let faulty = Settings {
        inject: Some(Injection::Alpha),
        excerpt: Some(path.clone()),
        ..settings(EngineKind::Interpreter)
    };
    let mut none = |_| {};
    let mut verifier = Verifier::new(&config, faulty, &mut none);
    let error = garden_on_splat_unit(&mut verifier, &config).unwrap_err();
    let failure = verifier.failure().expect(&error);
    let m = &failure.mismatch;
    assert_eq!(m.module, "splat_unit");
    assert!(error.contains(&m.to_string()), "{error}");
    let excerpt = failure.excerpt.as_ref().unwrap();
    let clock = changes(&path, "clk");
    assert!(clock.iter().any(|(time, _)| *time == excerpt.time), "{m}");
}
