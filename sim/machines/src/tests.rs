//! Machines on small scenes.
#![allow(clippy::unwrap_used)]

use potamoi_formats::config::PRESETS;
use potamoi_formats::document::Value;
use potamoi_scene::Scene;
use potamoi_system::system_model::ClockOrigin;
use proptest::prelude::*;

use crate::search::{Goal, Objective, Search, Tried};
use crate::{Axis, Comparison, Fidelity, Machine, Row, Space, Workbench, Workload};

fn scene(name: &str) -> Scene {
    let mut scene = Scene::open(name).unwrap();
    scene.set_size(Some(12), None).unwrap();
    scene
}

const SHORT: Workload = Workload {
    frames: 2,
    fps: 30.0,
    fidelity: Fidelity::Schedule,
    quality: true,
};

/// Each has figures on a scene of its kind: an unknown energy or area leaves the rest.
#[test]
fn every_preset_is_modelled() {
    let bench = Workbench::default();
    let scenes = ["garden", "lantern", "cairn:dvgo"].map(scene);
    for (name, _) in PRESETS {
        let machine = Machine::named(name).unwrap();
        let mut all = vec![];
        for scene in &scenes {
            match bench.figures(&machine, scene, &SHORT, &()) {
                Ok(own) => all.push(own),
                // A refusal names the presets that render the scene.
                Err(error) => {
                    let said = error.to_string();
                    assert!(said.contains(": use --config "), "{name}: {said}");
                }
            }
        }
        assert!(!all.is_empty(), "{name}");
        for own in &all {
            assert!(own.frames_per_second.low() > 0.0, "{name}");
            assert!(
                own.frames_per_second.high() <= own.free_units_frames_per_second.high() * 1.000_001
            );
            assert!(own.quality.unwrap().db.is_none_or(|db| db > 20.0), "{name}");
            let is_known = own.units_mm2.is_some() && own.mm2.is_some() && own.mj.is_some();
            assert!(is_known || !own.unknown.is_empty(), "{name}");
        }
    }
}

/// The reorder buffer of splats lies in the feature buffer, beside two blocks: a smaller one is no machine, and
/// saves no area.
#[test]
fn a_feature_buffer_has_room_for_the_records_of_splats() {
    let bench = Workbench::default();
    let of = |name: &str, bytes: i64, render: &[(&str, Value)]| {
        let size = ("system.feature_buffer_bytes", Value::Int(bytes));
        let changes = [&[size][..], render].concat();
        let machine = Machine::named("paper").unwrap().with("own", &changes);
        bench.figures(&machine.unwrap(), &scene(name), &SHORT, &())
    };
    let least = 8192 * 32 + 2 * 32 * 1024;
    assert!(of("garden", least, &[]).is_ok());
    let error = of("garden", least - 32, &[]).unwrap_err().to_string();
    assert!(
        error.contains("feature_buffer_bytes") && error.contains(&least.to_string()),
        "{error}"
    );
    assert!(of("lantern", least / 2, &[]).is_ok());
    let order = [("render.order", Value::Text("approximate".into()))];
    assert!(of("garden", least / 2, &order).is_ok());
}

/// The demands of a frame are a bound on every schedule of it.
#[test]
fn no_schedule_is_faster_than_the_largest_demand() {
    let bench = Workbench::default();
    let bound = Workload {
        fidelity: Fidelity::Demand,
        ..SHORT
    };
    for (name, preset) in [
        ("garden", "paper"),
        ("garden", "lean-splats"),
        ("lantern", "pipelined"),
    ] {
        let (machine, scene) = (Machine::named(preset).unwrap(), scene(name));
        let of = |workload| bench.figures(&machine, &scene, workload, &()).unwrap();
        let (bound, own) = (of(&bound), of(&SHORT));
        let [bound, own] = [bound, own].map(|of| of.frames_per_second);
        assert!(
            bound.max >= own.max && bound.sum >= own.sum,
            "{name} on {preset}: {bound:?} {own:?}"
        );
    }
}

/// What warps is no frame alone.
#[test]
fn a_warped_path_has_no_demand() {
    let machine = Machine::named("paper").unwrap();
    let machine = machine
        .with("own", &[("path.window", Value::Int(2))])
        .unwrap();
    let bound = Workload {
        fidelity: Fidelity::Demand,
        ..SHORT
    };
    let bench = Workbench::default();
    let error = bench
        .figures(&machine, &scene("garden"), &bound, &())
        .unwrap_err();
    assert!(error.to_string().contains("potamoi"), "{error}");
    let warped = bench
        .figures(&machine, &scene("garden"), &SHORT, &())
        .unwrap();
    assert_eq!(warped.variant, "potamoi");
}

/// Estimators that propose known points alone do not end a search.
#[test]
fn a_search_spends_its_budget() {
    let folder = tempfile::tempdir().unwrap();
    let axes = [
        "system.array_rows=8..24:+2",
        "system.memory_channels=1,2,4,8",
    ];
    let axes = axes.map(|own| Axis::parse(own).unwrap()).to_vec();
    let space = Space::new(Machine::named("small").unwrap(), axes).unwrap();
    let search = Search {
        space: &space,
        scenes: &[scene("garden")],
        goal: Goal {
            objective: Objective::Rate,
            max_area: None,
            min_psnr: None,
            min_fps: None,
            max_mj: None,
            needs_reached_clock: false,
            needs_known_clock: false,
        },
        workload: SHORT,
        budget: 35,
        seed: 3,
    };
    let found = search.run(folder.path(), &()).unwrap();
    let random = found.random.as_ref().unwrap();
    assert_eq!(
        (found.points, found.trials.tried.len(), random.tried.len()),
        (36, 35, 35)
    );
    // The best of both is found.
    let best = found.found().unwrap();
    for trials in [&found.trials, random] {
        assert!(!trials.nearest().unwrap().is_better(best));
    }
    // So is the front of both: its first machine has the best objective.
    let place = |own: &Tried| own.place(Objective::Rate).unwrap()[0];
    let front = found.front(Objective::Rate);
    assert!(
        front
            .windows(2)
            .all(|pair| place(pair[0]) >= place(pair[1]))
    );
    assert_eq!(place(front[0]), place(best));
}

/// Demands cannot tell channels apart that are not needed; the schedule can, and judges the limits.
#[test]
fn a_search_by_demand_is_judged_by_the_schedule() {
    let folder = tempfile::tempdir().unwrap();
    let axes = ["system.memory_channels=1,2,4,8", "vu.lanes=2,4"];
    let axes = axes.map(|own| Axis::parse(own).unwrap()).to_vec();
    let space = Space::new(Machine::named("small").unwrap(), axes).unwrap();
    let scenes = [scene("garden")];
    let search = |fidelity, min_fps| Search {
        space: &space,
        scenes: &scenes,
        goal: Goal {
            objective: Objective::Area,
            max_area: None,
            min_psnr: None,
            min_fps,
            max_mj: None,
            needs_reached_clock: false,
            needs_known_clock: false,
        },
        workload: Workload { fidelity, ..SHORT },
        budget: 8,
        seed: 3,
    };
    let fps = |own: &Tried| own.place(Objective::Rate).unwrap()[0];
    let run = |fidelity, least| search(fidelity, least).run(folder.path(), &()).unwrap();
    let whole = run(Fidelity::Schedule, None);
    let mut rates: Vec<f64> = whole.tried().map(fps).collect();
    rates.sort_by(f64::total_cmp);
    // A limit that some machines keep by their schedule, and more by their demand.
    let limit = rates[rates.len() - 1] * 0.999;
    let bounded = run(Fidelity::Demand, Some(limit));
    let best = bounded.found().unwrap();
    assert!(fps(best) >= limit, "{best:?}");
    let kept = |all: &[Tried]| all.iter().filter(|own| own.keeps_limits).count();
    let again = bounded.by_schedule.as_ref().unwrap();
    assert!(kept(&again.tried) < kept(&bounded.trials.tried), "{limit}");
    assert_eq!(bounded.judged_base().setting, bounded.base.setting);
    assert!(fps(bounded.judged_base()) < fps(&bounded.base));
}

/// What a guess gains is no machine to build.
#[test]
fn a_guessed_clock_keeps_no_limit_beside_a_known_one() {
    let folder = tempfile::tempdir().unwrap();
    let space = |base: &str| {
        let axes = vec![Axis::parse("su.lanes=1,2").unwrap()];
        Space::new(Machine::named(base).unwrap(), axes).unwrap()
    };
    let own = space("lean-splats");
    let scenes = [scene("garden")];
    let search = Search {
        space: &own,
        scenes: &scenes,
        goal: Goal {
            objective: Objective::Rate,
            max_area: None,
            min_psnr: None,
            min_fps: None,
            max_mj: None,
            needs_reached_clock: false,
            needs_known_clock: false,
        },
        workload: SHORT,
        budget: 2,
        seed: 3,
    };
    let found = search.run(folder.path(), &()).unwrap();
    let all: Vec<_> = (found
        .tried()
        .map(|own| (own.is_clock_guessed(), own.keeps_limits)))
    .collect();
    assert_eq!(all, [(false, true), (true, false)]);
    assert!(!found.found().unwrap().is_clock_guessed());
}

/// Steps of a voxel and longer are as wide as the presets' narrow factors.
#[test]
fn presets_with_narrow_factors_take_steps_of_any_length() {
    let bench = Workbench::default();
    for (preset, steps) in [("lean-fields", [0.3, 1.0]), ("lean", [1.0, 3.0])] {
        let base = Machine::named(preset).unwrap();
        for step in steps {
            let machine = base
                .with("own", &[("render.step", Value::Float(step))])
                .unwrap();
            let own = bench.figures(&machine, &scene("lantern"), &SHORT, &());
            assert!(own.is_ok(), "{preset}, step {step}: {own:?}");
            let own = own.unwrap();
            assert!(own.frames_per_second.low() > 0.0);
        }
    }
}

#[test]
fn ratios_are_over_the_first_machine() {
    let machines = ["paper", "pipelined", "lean-splats"].map(|own| Machine::named(own).unwrap());
    let scenes = ["garden", "lantern"].map(scene);
    let found = Comparison::of(&machines, &scenes, &SHORT, &()).unwrap();
    let first = found.ratios(0, 0).unwrap();
    assert_eq!((first.rate.max, first.energy.unwrap().sum), (1.0, 1.0));
    assert!(found.ratios(0, 2).unwrap().rate.low() > 1.0);
    // A saving: less energy than the first machine's is above 1.
    let [first, own] = [0, 2].map(|row| found.scenes[0][row].figures().unwrap().mj.unwrap());
    let saving = found.ratios(0, 2).unwrap().energy.unwrap();
    assert!((saving.max - first.max / own.max).abs() < 1e-12 && saving.low() > 1.0);
    assert!(matches!(found.scenes[1][2], Row::Refused { .. }));
    assert_eq!(found.ratios(1, 2), None);
    let (mean, count) = found.means(1).unwrap();
    let each = [0, 1].map(|scene| found.ratios(scene, 1).unwrap().rate.max);
    assert_eq!(count, 2);
    assert!((mean.rate.max - (each[0] * each[1]).sqrt()).abs() < 1e-9);
    assert_eq!(found.means(2).unwrap().1, 1);
    let csv = found.csv().unwrap();
    assert_eq!(csv.lines().count(), 7);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    /// A configuration that breaks no rule has a frame rate, whatever else of it is not known.
    #[test]
    fn every_legal_machine_is_modelled(
        lanes in 1i64..40, banks in prop::sample::select(vec![8i64, 16, 32]), ports in 1i64..4,
        iterations in 8i64..17, pipelined in any::<bool>(), tail in any::<bool>(),
        form in prop::sample::select(vec!["restoring", "radix-4", "piecewise"]),
        entry in prop::sample::select(vec!["paper", "compact"]),
        channels in prop::sample::select(vec![1i64, 2, 4, 8]), rows in 1i64..40,
        clock in prop::option::of(100i64..2000), window in prop::option::of(1i64..4),
        unit in prop::option::of((1i64..9, prop::sample::select(vec![4i64, 8, 16]), 1i64..5)),
        pairs in prop::sample::select(vec!["all", "that-may-count"]), piped in any::<bool>(),
        registered in any::<bool>(), narrow in prop::option::of(25i64..33),
        organisation in prop::sample::select(vec!["auto", "channel-major", "parity", "feature-major"]),
        memory in prop::sample::select(vec!["lpddr3-1600", "lpddr3-1600-8gb"]),
        gpu in prop::sample::select(vec!["xavier-maxn", "orin-nx", "3090"]),
        phi in prop::option::of(1i64..90),
        name in prop::sample::select(vec!["garden", "lantern", "cairn:dvgo"]),
    ) {
        let mut changes = vec![
            ("vu.lanes", Value::Int(lanes)), ("gu.banks", Value::Int(banks)),
            ("gu.ports", Value::Int(ports)), ("vu.exp.iterations", Value::Int(iterations)),
            ("vu.exp.pipelined", Value::Bool(pipelined)), ("vu.exp.tail", Value::Bool(tail)),
            ("vu.exp.form", Value::Text(form.into())), ("rit.entry", Value::Text(entry.into())),
            ("gu.pipelined", Value::Bool(piped)),
            ("system.memory_channels", Value::Int(channels)), ("system.array_rows", Value::Int(rows)),
        ];
        changes.extend(clock.map(|mhz| ("clock_ghz", Value::Float(mhz as f64 / 1e3))));
        changes.extend(window.map(|own| ("path.window", Value::Int(own))));
        // Paths that warp have a turn from which a pixel is rendered again.
        changes.extend(phi.filter(|_| window.is_some()).map(|own| ("path.phi", Value::Int(own))));
        let texts = [("rit.pairs", pairs), ("gu.organisation", organisation),
            ("system.memory", memory), ("system.gpu.device", gpu)];
        changes.extend(texts.map(|(field, own)| (field, Value::Text(own.into()))));
        changes.push(("vu.registered", Value::Bool(registered)));
        // Of a scene's factors, the second is the narrower one.
        let narrow = narrow.map(|own| Value::List(Box::new([Value::Int(32), Value::Int(own)])));
        changes.extend(narrow.map(|own| ("vu.operands.multiply", own)));
        if let Some((lanes, tiles, units)) = unit {
            let own = [("su.lanes", lanes), ("su.tiles", tiles), ("su.units", units)];
            changes.extend(own.map(|(name, own)| (name, Value::Int(own))));
        }
        let base = match name {
            // A network's activations are operations of their own.
            "cairn:dvgo" => Machine::named("fields"),
            _ => Machine::for_any_scene(),
        };
        let base = base.unwrap();
        let machine = match base.with("own", &changes) {
            Ok(own) => own,
            Err(error) => {
                prop_assert!(error.is_rule(), "{}", error);
                return Err(TestCaseError::reject("it breaks a rule"));
            }
        };
        let bench = Workbench::default();
        let own = bench.figures(&machine, &scene(name), &SHORT, &());
        let own = own.map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert!(own.frames_per_second.low() > 0.0);
        prop_assert!(own.clock_origin == ClockOrigin::Assumed || clock.is_none());
        let is_known = own.mj.is_some() && own.units_mm2.is_some() && own.mm2.is_some();
        prop_assert!(is_known || !own.unknown.is_empty());
        // Its file is the same machine, and a comparison and a search take it.
        let folder = tempfile::tempdir()?;
        let file = folder.path().join("own.toml");
        std::fs::write(&file, machine.to_toml().unwrap())?;
        let read = Machine::read(&file).map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert_eq!(read.identity(), machine.identity());
        let scenes = [scene(name)];
        let found = Comparison::of(std::slice::from_ref(&read), &scenes, &SHORT, &());
        let found = found.map_err(|error| TestCaseError::fail(error.to_string()))?;
        let figures = found.scenes[0][0].figures().map(|found| found.frames_per_second);
        prop_assert_eq!(figures, Some(own.frames_per_second));
        let axis = Axis::parse("system.memory_channels=1,2").unwrap();
        let space = Space::new(read, vec![axis]).unwrap();
        let search = Search {
            space: &space, scenes: &scenes, workload: SHORT, budget: 2, seed: 1,
            goal: Goal { objective: Objective::Rate, max_area: None, min_psnr: None, min_fps: None,
                max_mj: None, needs_reached_clock: false, needs_known_clock: false },
        };
        let searched = search.run(&folder.path().join("rows"), &());
        let searched = searched.map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert!(searched.base.has_figures());
        prop_assert!(searched.tried().all(|own| own.has_figures()));
    }
}
