//! Sensitivity of the results to figures of the GPUs, and results without a GPU.

use std::collections::BTreeMap;

use potamoi_explore::system::{Conclusion, CountedScene, Sensitivity, SensitivityRow};
use potamoi_system::system_model::{AtBounds, Clock, Scenario, System};

use super::ModelArgs;
use super::clock;
use super::report::Report;
use crate::args::Common;
use crate::bounds::{known, ratio};
use crate::failure::Failure;
use crate::stdout::say;
use crate::tables;

pub(super) fn run(
    common: &Common,
    args: &ModelArgs,
    system: &System,
    names: &[String],
) -> Result<(), Failure> {
    let mut counted = vec![];
    for name in names {
        let mut setup = args.setup(common, system, args.scene.open_named(name, common)?)?;
        let path = args.count(&mut setup, &common.machine()?)?.0;
        counted.push(CountedScene {
            name: name.clone(),
            setup,
            path,
        });
    }
    let scenarios = args.scenario.all();
    let found = Sensitivity::of(
        &counted,
        system,
        &args.variants(&common.machine()?)?,
        scenarios,
    )?;
    print(&found, args);
    args.files
        .write(&Report::new("model --sensitivity", system, vec![found]))
}

fn print(found: &Sensitivity, args: &ModelArgs) {
    say!(
        "speed-up (energy saving) over the baseline of the same system at both bounds of the GPU's \
         kernels, means of {}",
        clock::listed(named(found))
    );
    for scenario in args.scenario.all() {
        let of = |row: &SensitivityRow| -> Vec<String> {
            let own = row.means.iter();
            own.filter(|m| m.scenario == *scenario && m.variant != "baseline")
                .map(|m| format!("{} ({})", ratio(&m.speed_up), known(m.saving.as_ref())))
                .collect()
        };
        let names = found.rows.iter().take(1).flat_map(|row| &row.means);
        let names = names.filter(|m| m.scenario == *scenario && m.variant != "baseline");
        let heading = std::iter::once(place(*scenario).to_owned());
        let mut table = tables::plain(
            heading
                .chain(names.map(|m| m.variant.to_owned()))
                .collect::<Vec<_>>(),
        );
        for row in &found.rows {
            let figures = of(row);
            if !figures.is_empty() {
                let name = clock::marked_mean(row.change, &found.clocks);
                table.add_row([vec![name], figures].concat());
            }
        }
        say!("{}", tables::fitted(&table, &[]));
    }
    print_conclusions(found);
}

/// Scenes, each with its clock.
fn named(found: &Sensitivity) -> impl Iterator<Item = (&str, &Clock)> {
    found.scenes.iter().map(String::as_str).zip(&found.clocks)
}

const fn place(scenario: Scenario) -> &'static str {
    match scenario {
        Scenario::Local => "local rendering",
        Scenario::Remote => "remote rendering",
    }
}

/// What holds within the model's own error, scene by scene.
fn print_conclusions(found: &Sensitivity) {
    say!(
        "conclusions: each holds at both bounds and under each error of the model, or is open. The \
         errors, one at a time:"
    );
    for error in &found.errors {
        say!("  {}: {}", error.name, error.means);
    }
    let headings = [
        "conclusion",
        "times as fast",
        "within the error",
        "says",
        "state",
    ];
    let mut table = tables::plain(headings.map(str::to_owned));
    for own in &found.conclusions {
        let remote = match own.scenario {
            Scenario::Local => "",
            Scenario::Remote => ", remote",
        };
        let clock = named(found).find(|(scene, _)| *scene == own.scene);
        let scene = clock.map_or_else(|| own.scene.clone(), |(name, own)| clock::marked(name, own));
        table.add_row([
            format!("{scene}{remote}: {}", own.of),
            known(own.ratio.as_ref()),
            within(own),
            own.says.clone(),
            state(own),
        ]);
    }
    say!("{}", tables::fitted(&table, &[]));
}

fn within(own: &Conclusion) -> String {
    let range = own.within.map(|[max, sum]| AtBounds { max, sum });
    known(range.as_ref())
}

/// `holds`, or which errors change it.
fn state(own: &Conclusion) -> String {
    if own.holds() {
        return "holds".to_owned();
    }
    let mut by: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (error, says) in &own.open_by {
        by.entry(says).or_default().push(error);
    }
    let by = by
        .iter()
        .map(|(says, errors)| format!("{says} with {}", errors.join(", ")));
    match own.open_by.is_empty() {
        true => "open: the bounds differ".to_owned(),
        false => format!("open: {}", by.collect::<Vec<_>>().join("; ")),
    }
}
