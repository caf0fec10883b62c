//! Every knob of a scene's frame on one scale.

use potamoi_base::outputs as files;
use potamoi_explore::Setup;
use potamoi_explore::accuracy::knobs::{self, Knob, Setting};
use potamoi_explore::accuracy::{Bench, Goal, Proof, Search, SearchResult, Sweep};
use potamoi_explore::system::rungs;
use schemars::JsonSchema;
use serde::Serialize;

use super::{CostArgs, FORMAT_VERSION, answers, pictures, tables};
use crate::args::Common;
use crate::charts;
use crate::failure::Failure;
use crate::found::Found;
use crate::progress::{self, Shown};
use crate::scene::left_open_of_files;
use crate::stdout::say;
use crate::suggest;

/// Default width of built-in scenes in pixels.
const WIDTH: u32 = 128;

#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    format_version: u32,
    command: &'static str,
    #[serde(flatten)]
    found: &'a Sweep,
    /// Items that the scene's files leave open.
    not_checked: Vec<String>,
}

pub(super) fn run(common: &Common, args: &CostArgs) -> Result<(), Failure> {
    let mut scene = args.scene.open(common)?;
    if !args.scene.looks_otherwise() {
        scene.set_size(Some(WIDTH), None)?;
    }
    let chosen = args.clock.chosen(common.chosen_for(&scene)?)?;
    let setup = Setup::new(
        chosen,
        &common.machine()?.system,
        scene,
        args.synth.as_deref(),
    )?;
    let knobs = knobs::named(knobs::of(&setup.scene), &args.knobs)
        .map_err(|error| Failure::Usage(misspelt(&format!("--knobs {error}"), &setup, args)))?;
    let iterations = setup.config.vu.exp.iterations;
    let bench = Bench::new(setup, args.frames)?;
    let bar = progress::bar(0, "rendering");
    let mut sweep = Sweep::of(&bench, &knobs, &Shown(&bar))?;
    if args.ladder {
        bar.set_message("three ways to the frame's time");
        sweep.ladder = rungs(&bench.setup)?;
    }
    bar.finish_and_clear();
    for line in answers::answers(&sweep, &knobs, iterations) {
        say!("{line}");
    }
    say!("");
    tables::print(&sweep, &knobs);
    if let Some(path) = &args.csv {
        files::write(path, &tables::csv(&sweep))?;
    }
    if let Some(path) = &args.plot {
        charts::write(path, &pictures::spec(&sweep))?;
    }
    let goal = match (args.target_psnr, args.budget_ms) {
        (Some(db), _) => Some(Goal::Quality(db)),
        (_, Some(ms)) => Some(Goal::Budget(ms * 1e6)),
        _ => None,
    };
    let sought = goal.map(|goal| seek(&bench, &knobs, goal, &sweep, args));
    let end = match sought {
        Some(Ok(found)) => {
            sweep.found = Some(found);
            Ok(())
        }
        Some(Err(failure)) => Err(failure),
        None => Ok(()),
    };
    if args.files.are_asked() {
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "cost",
            found: &sweep,
            not_checked: left_open_of_files(),
        };
        args.files.write(&report)?;
    }
    end
}

/// A message, with the knob that was meant.
fn misspelt(message: &str, setup: &Setup, args: &CostArgs) -> String {
    let known: Vec<&str> = knobs::of(&setup.scene).iter().map(|own| own.name).collect();
    let given = args.knobs.iter().find(|own| !known.contains(&&***own));
    suggest::with_nearest(message, given.map_or("", |own| own), known)
}

/// Searches, writes the result, and verifies its Verilog.
fn seek(
    bench: &Bench,
    knobs: &[Knob],
    goal: Goal,
    sweep: &Sweep,
    args: &CostArgs,
) -> Result<SearchResult, Failure> {
    let spinner = progress::spinner("searching");
    let search = Search {
        bench,
        knobs,
        sweep,
        goal,
        price: args.by.into(),
    };
    let file = Found::new(&args.found);
    let candidate = search.find(&Shown(&spinner), |text| {
        Ok::<_, Failure>(file.keep_unproved(text)?)
    });
    spinner.finish_and_clear();
    let candidate = candidate?;
    tables::found(
        &candidate.found,
        sweep.default_point(),
        sweep.reference.kind,
    );
    file.keep_unproved(&candidate.text)?;
    let settings: Vec<&Setting> = candidate.settings.iter().collect();
    let bar = progress::bar(0, "verifying");
    let proved = bench.prove(&settings, None, &Shown(&bar));
    bar.finish_and_clear();
    let Proof {
        vectors,
        elements,
        pixels,
    } = proved?;
    let splats = match pixels {
        [_, 0] => String::new(),
        [compared, all] => format!(", and {compared} of {all} pixels of the splat unit"),
    };
    say!(
        "its Verilog was verified against the golden models: no mismatch in any bit or cycle, {} \
         of the frame's {} feature vectors and {} of its {} elements{splats}",
        vectors[0],
        vectors[1],
        elements[0],
        elements[1]
    );
    file.write(&candidate.text)?;
    say!("written to {}", args.found.display());
    Ok(candidate.found)
}
