//! Every knob of a scene's frame on one scale.

use potamoi_explore::Setup;
use potamoi_reference::Twins;
use potamoi_rtl::EngineKind;
use potamoi_rtl::verify::{Injection, Settings, Verifier};

use super::front::{Place, front, knee};
use super::knobs::{self, Asked, Change, Knob, Setting};
use super::report::{Found, Refused, Report};
use super::search::{Chosen, Goal, search_by_ways_alone};
use super::trial::{Bench, Paths, Point};
use super::{CostArgs, FORMAT_VERSION, Price, pictures, tables};
use crate::args::Common;
use crate::failure::Failure;
use crate::files;
use crate::progress;
use crate::stdout::say;
use potamoi_explore::system::rungs;

/// Pixels a row of built-in scenes, unless asked for otherwise.
const WIDTH: u32 = 128;
/// Feature vectors and elements that a search's proof aims at: some seconds.
const PROOF: [u64; 2] = [100_000, 1_000_000];
/// Of a file that a search writes before its end.
const UNPROVED: &str =
    "# The best so far: its Verilog was not yet held against the golden models.\n";

pub(super) fn run(common: &Common, args: &CostArgs) -> Result<(), Failure> {
    let mut scene = args.scene.open()?;
    if !args.scene.looks_otherwise() {
        scene.set_size(Some(WIDTH), None)?;
    }
    let setup = Setup::of_times(common.chosen_for(&scene)?, scene, args.synth.as_deref())?;
    let knobs = knobs::named(knobs::of(&setup.scene), &args.knobs)?;
    let bench = Bench::new(setup, args.frames)?;
    let mut report = measure(&bench, &knobs)?;
    tables::print(&report, &knobs);
    if let Some(path) = &args.csv {
        files::write(path, &tables::csv(&report))?;
    }
    if let Some(path) = &args.plot {
        pictures::plot(path, &report)?;
    }
    let goal = match (args.target_psnr, args.budget_ms) {
        (Some(db), _) => Some(Goal::Quality(db)),
        (_, Some(ms)) => Some(Goal::Budget(ms * 1e6)),
        _ => None,
    };
    let sought = goal.map(|goal| seek(&bench, &knobs, goal, &report, args));
    let end = match sought {
        Some(Ok(found)) => {
            report.found = Some(found);
            Ok(())
        }
        Some(Err(failure)) => Err(failure),
        None => Ok(()),
    };
    if let Some(path) = &args.json {
        files::write_json(path, &report)?;
    }
    end
}

fn measure(bench: &Bench, knobs: &[Knob]) -> Result<Report, Failure> {
    let count: usize = knobs.iter().map(|knob| knob.settings.len()).sum();
    let bar = progress::bar(count as u64 + 2, "rendering");
    let mut points = vec![bench.point("default", "", &[])?];
    bar.inc(1);
    let mut refused = vec![];
    for knob in knobs {
        bar.set_message(knob.name);
        turn(bench, knob, &mut points, &mut refused, &|| bar.inc(1));
    }
    bar.set_message("three ways to the frame's time");
    let ladder = rungs(&bench.setup)?;
    bar.finish_and_clear();
    let places: Vec<Place> = points.iter().map(Point::place).collect();
    let front = front(&places);
    let scene = &bench.setup.scene;
    Ok(Report {
        format_version: FORMAT_VERSION,
        command: "cost",
        scene: scene.name().to_owned(),
        algorithm: scene.model().algorithm(),
        size: [scene.camera().width, scene.camera().height],
        configuration: bench.setup.config.hash(),
        knee: knee(&places, &front),
        front,
        points,
        refused,
        ladder,
        found: None,
    })
}

/// Measures each setting of a knob by itself, or says why it is refused.
fn turn(
    bench: &Bench,
    knob: &Knob,
    points: &mut Vec<Point>,
    refused: &mut Vec<Refused>,
    step: &dyn Fn(),
) {
    for setting in &knob.settings {
        match bench.point(knob.name, &setting.label, &[setting]) {
            Ok(point) => points.push(point),
            Err(failure) => refused.push(Refused {
                knob: knob.name,
                setting: setting.label.clone(),
                why: failure.to_string(),
            }),
        }
        step();
    }
}

/// Searches, writes what was found, and proves it by its Verilog.
fn seek(
    bench: &Bench,
    knobs: &[Knob],
    goal: Goal,
    report: &Report,
    args: &CostArgs,
) -> Result<Found, Failure> {
    let counts: Vec<usize> = knobs.iter().map(|knob| knob.settings.len()).collect();
    let spinner = progress::spinner("searching");
    let mut tried = 0;
    let settings = |chosen: &[Option<usize>]| -> Vec<(&Knob, &Setting)> {
        let pairs = knobs.iter().zip(chosen);
        pairs
            .filter_map(|(knob, at)| Some((knob, &knob.settings[(*at)?])))
            .collect()
    };
    let labels = |of: &[(&Knob, &Setting)]| -> Vec<String> {
        let label =
            |(knob, setting): &(&Knob, &Setting)| format!("{} {}", knob.name, setting.label);
        of.iter().map(label).collect()
    };
    let point = |of: &[(&Knob, &Setting)]| {
        let own: Vec<&Setting> = of.iter().map(|(_, setting)| *setting).collect();
        bench.point("found", &labels(of).join(", "), &own)
    };
    let place = |chosen: &Chosen, paths: Paths| -> Result<_, Failure> {
        let own = settings(chosen);
        if let Some(known) = measured(report, &own, args.by) {
            return Ok(known);
        }
        tried += 1;
        spinner.set_message(format!(
            "searching: {tried} tried, {}",
            labels(&own).join(", ")
        ));
        // Two ways through a path are one too many; what cannot be is passed over.
        let ways = own
            .iter()
            .filter(|(_, s)| matches!(s.change, Change::Path(_)));
        if ways.count() > 1 {
            return Ok(None);
        }
        let plain: Vec<&Setting> = own.iter().map(|(_, setting)| *setting).collect();
        Ok(bench.place(&plain, paths, args.by).ok().flatten())
    };
    let reach = |chosen: &Chosen| -> Result<(), Failure> {
        let text = text(bench, &settings(chosen))?;
        Ok(files::write(&args.found, &format!("{UNPROVED}{text}"))?)
    };
    let found = search_by_ways_alone(goal, &counts, place, reach)?;
    spinner.finish_and_clear();
    let Some((chosen, at, is_met)) = found else {
        return Err(Failure::Inconclusive(match args.by {
            Price::Time => "the default cannot be measured".to_owned(),
            Price::Energy | Price::Area => {
                "energy and area of the default are not known: potamoi synth --json finds them, and \
                 --synth takes them"
                    .to_owned()
            }
        }));
    };
    if !is_met {
        return Err(Failure::Inconclusive(format!(
            "no settings reach it: the nearest have {:.2} dB at {}",
            at.quality,
            args.by.words(at.cost)
        )));
    }
    let own = settings(&chosen);
    let found = Found {
        settings: labels(&own),
        point: point(&own)?,
        tried,
    };
    tables::found(&found.settings, &found.point, report.default_point(), tried);
    let plain: Vec<&Setting> = own.iter().map(|(_, setting)| *setting).collect();
    let text = text(bench, &own)?;
    files::write(&args.found, &format!("{UNPROVED}{text}"))?;
    prove(bench, &plain, None)?;
    files::write(&args.found, &text)?;
    say!("written to {}", args.found.display());
    Ok(found)
}

/// What is known of no setting or one alone: its place, or that it cannot be.
fn measured(report: &Report, own: &[(&Knob, &Setting)], price: Price) -> Option<Option<Place>> {
    match own {
        [] => Some(report.default_point().priced(price)),
        [(knob, setting)] => {
            let of = |point: &&Point| point.knob == knob.name && point.setting == setting.label;
            Some((report.points.iter().find(of)).and_then(|point| point.priced(price)))
        }
        _ => None,
    }
}

/// The configuration, and what is not of it as lines of a description or flags.
fn text(bench: &Bench, own: &[(&Knob, &Setting)]) -> Result<String, Failure> {
    let plain: Vec<&Setting> = own.iter().map(|(_, setting)| *setting).collect();
    let (config, _) = bench.apply(&plain)?;
    let (mut render, mut flags) = (vec![], vec![]);
    for setting in &plain {
        match setting.change.asked() {
            Some(Asked::Render(lines)) => render.extend(lines),
            Some(Asked::Flags(own)) => flags.push(own),
            None => {}
        }
    }
    let mut text = String::new();
    if !render.is_empty() {
        text.push_str("# Beside this configuration, in the scene's description:\n# [render]\n");
        text.extend(render.iter().map(|line| format!("# {line}\n")));
    }
    if !flags.is_empty() {
        text.push_str("# Beside this configuration, of commands:\n");
        text.extend(flags.iter().map(|flag| format!("# {flag}\n")));
    }
    let made = config.to_toml();
    text.push_str(&made.map_err(|e| Failure::Usage(e.to_string()))?);
    Ok(text)
}

/// Holds the Verilog of what was found against the golden models on its frame; with a fault in it,
/// to see that it is found.
fn prove(bench: &Bench, own: &[&Setting], inject: Option<Injection>) -> Result<(), Failure> {
    let (config, scene) = bench.apply(own)?;
    let counts = scene
        .render_fixed(&config, &mut Twins::new(&config))?
        .counts;
    let total = [counts.feature_vectors, counts.elements.values().sum()];
    let [gather_every, vector_every] = [0, 1].map(|i| total[i].div_ceil(PROOF[i]).max(1));
    let settings = Settings {
        engine: EngineKind::Verilator,
        seed: 0,
        gather_every,
        vector_every,
        inject,
        excerpt: None,
    };
    let bar = progress::bar(total.iter().sum(), "verifying");
    let mut show = |p: potamoi_rtl::verify::Progress| bar.set_position(p.done);
    let mut verifier = Verifier::new(&config, settings, &mut show);
    let done = scene.render_fixed(&config, &mut verifier);
    let failure = verifier.failure().cloned();
    let [vectors, elements] = [
        verifier.gather_report().samples,
        verifier.vector_report().elements,
    ];
    bar.finish_and_clear();
    if failure.is_some() {
        return Err(Failure::Check(
            "the Verilog of what was found differs from the golden models".to_owned(),
        ));
    }
    done?;
    if vectors + elements == 0 {
        return Err(Failure::Inconclusive("nothing was compared".to_owned()));
    }
    say!(
        "its Verilog was held against the golden models: no mismatch in any bit or cycle, {vectors} of the frame's {} feature vectors and {elements} of its {} elements",
        total[0],
        total[1]
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::knobs::Look;
    use super::*;
    use potamoi_base::precision::Precision;
    use potamoi_scene::Scene;

    /// Of both units, in the configuration that a setting makes.
    #[test]
    fn a_fault_of_what_was_found_is_not_proved() {
        let mut scene = Scene::open("lantern").unwrap();
        scene.set_size(Some(12), None).unwrap();
        let common = crate::args::Common::default();
        let setup = Setup::of_times(common.chosen_for(&scene).unwrap(), scene, None).unwrap();
        let bench = Bench::new(setup, 2).unwrap();
        let knobs = knobs::of(&bench.setup.scene);
        let iterations = knobs.iter().find(|knob| knob.name == "iterations").unwrap();
        let own = [&iterations.settings[0]];
        assert!(prove(&bench, &own, None).is_ok());
        for fault in [Injection::Bit, Injection::Bubble, Injection::Exp] {
            let proved = prove(&bench, &own, Some(fault));
            assert!(
                matches!(proved, Err(Failure::Check(_))),
                "{fault:?}: {proved:?}"
            );
        }
    }

    /// A knob that is added as docs/adding/knob.md says is measured, told and refused like others.
    #[test]
    fn an_added_knob_is_measured_like_the_others() {
        let mut scene = Scene::open("garden").unwrap();
        scene.set_size(Some(16), Some(16)).unwrap();
        let setup = Setup::of_times(
            potamoi_explore::Chosen::for_scene(&scene).unwrap(),
            scene,
            None,
        )
        .unwrap();
        let bits = |n: u32| Setting {
            label: n.to_string(),
            change: Change::Scene(Look::Precision(Precision {
                transmittance_bits: Some(n),
                ..Precision::default()
            })),
        };
        let added = Knob {
            name: "added",
            what: "a knob of this test",
            settings: vec![bits(8), bits(20), bits(99)],
        };
        let mut knobs = knobs::of(&setup.scene);
        knobs.push(added);
        let knobs = knobs::named(knobs, &["added".to_owned()]).unwrap();
        let bench = Bench::new(setup, 2).unwrap();
        let default = bench.point("default", "", &[]).unwrap();
        let (mut points, mut refused) = (vec![], vec![]);
        turn(&bench, &knobs[0], &mut points, &mut refused, &|| {});
        let db = |point: &Point| point.model.db.unwrap();
        assert_eq!(points.len(), 2);
        assert!(db(&points[0]) < db(&default) - 3.0, "{}", db(&points[0]));
        assert_eq!(db(&points[1]).to_bits(), db(&default).to_bits());
        assert_eq!((refused[0].knob, &*refused[0].setting), ("added", "99"));
        assert!(
            refused[0].why.contains("transmittance_bits"),
            "{}",
            refused[0].why
        );
    }
}
