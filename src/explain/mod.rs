//! `potamoi explain`: what a field of a file or a knob is, and where it is explained.

pub(crate) mod fields;
mod rustdoc;

use clap::Args;
use potamoi_explore::accuracy::knobs::{self, Change, Knob};
use potamoi_scene::Scene;
use schemars::JsonSchema;
use serde::Serialize;

use crate::failure::Failure;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::stdout::say;
use crate::suggest;
use crate::tables;

use fields::Explained;

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "explain",
    version: FORMAT_VERSION,
    shape: shape::<Report<'_>>,
};
/// Scenes whose knobs are known without a file: one of splats and one of samples.
const SCENES: [&str; 2] = ["garden", "lantern"];

#[derive(Debug, Args)]
pub(crate) struct ExplainArgs {
    /// Field of a configuration, a system, a scene, a path or a machine, such as gu.banks, or a knob of
    /// `cost`; without one all fields are listed
    #[arg(value_name = "KNOB")]
    knob: Option<String>,
    #[command(flatten)]
    files: ReportFiles,
}

#[derive(Serialize, JsonSchema)]
struct Report<'a> {
    format_version: u32,
    command: &'static str,
    fields: Vec<&'a Explained>,
}

/// Knobs of `cost`, each once.
fn all_knobs() -> Result<Vec<Knob>, Failure> {
    let mut all: Vec<Knob> = vec![];
    for name in SCENES {
        let scene = Scene::open(name)?;
        for knob in knobs::of(&scene) {
            if all.iter().all(|own| own.name != knob.name) {
                all.push(knob);
            }
        }
    }
    Ok(all)
}

/// Whether a knob changes a field of a configuration.
fn turns(knob: &Knob, field: &str) -> bool {
    let (table, key) = field.rsplit_once('.').unwrap_or(("", field));
    knob.settings.iter().any(|setting| match &setting.change {
        Change::Config { toml, .. } => {
            let lines = || toml.lines().map(str::trim);
            let sets = |line: &str| line.split('=').next().map(str::trim) == Some(key);
            lines().any(|line| line == format!("[{table}]")) && lines().any(sets)
        }
        Change::Scene(_) | Change::Path(_) => false,
    })
}

pub(crate) fn run(args: &ExplainArgs) -> Result<(), Failure> {
    args.files.prepare([])?;
    let all = fields::all();
    let shown: Vec<&Explained> = match &args.knob {
        None => {
            list(&all);
            all.iter().collect()
        }
        Some(given) => one(given, &all)?,
    };
    if args.files.are_asked() {
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "explain",
            fields: shown,
        };
        args.files.write(&report)?;
    }
    Ok(())
}

/// Prints all fields, a line or more each.
fn list(all: &[Explained]) {
    let mut table = tables::wrapped();
    for own in all {
        table.add_row([&own.field, &own.meaning]);
    }
    say!("{}", table.trim_fmt());
}

/// Prints the fields of a name: those of the path, or of the last part of it, and the knob.
fn one<'a>(given: &str, all: &'a [Explained]) -> Result<Vec<&'a Explained>, Failure> {
    let is_same = |own: &&Explained| own.field == given;
    let ends_so = |own: &&Explained| own.field.rsplit('.').next() == Some(given);
    let mut found: Vec<_> = all.iter().filter(is_same).collect();
    if found.is_empty() {
        found = all.iter().filter(ends_so).collect();
    }
    let knobs = all_knobs()?;
    let knob = knobs.iter().find(|own| own.name == given);
    if found.is_empty() && knob.is_none() {
        let known = all.iter().map(|own| &*own.field);
        let last = all.iter().filter_map(|own| own.field.rsplit('.').next());
        let known = known.chain(last).chain(knobs.iter().map(|own| own.name));
        return Err(Failure::Usage(suggest::with_nearest(
            format!(
                "{given}: no field of a configuration, system, scene, path or machine, and no knob; \
                 potamoi explain lists all fields"
            ),
            given,
            known,
        )));
    }
    for own in &found {
        let costs = knobs.iter().filter(|knob| turns(knob, &own.field));
        print(own, &costs.map(|knob| knob.name).collect::<Vec<_>>());
    }
    if let Some(knob) = knob {
        let labels: Vec<&str> = knob.settings.iter().map(|own| &*own.label).collect();
        say!("{}, a knob of cost", knob.name);
        let mut table = tables::wrapped();
        table.add_row(["changes", knob.what]);
        table.add_row(["settings", &labels.join(", ")]);
        table.add_row([
            "costs",
            &format!("potamoi cost --knobs {} measures it", knob.name),
        ]);
        table.add_row(["page", "docs/explanation/cost.md"]);
        say!("{table}");
    }
    Ok(found)
}

fn print(own: &Explained, knobs: &[&str]) {
    say!("{}, of a {}", own.field, own.file);
    let mut table = tables::wrapped();
    let mut row = |name: &str, text: String| {
        table.add_row([name.to_owned(), text]);
    };
    row("meaning", own.meaning.clone());
    if let Some(kind) = &own.kind {
        row("kind", kind.clone());
    }
    if let Some(range) = &own.range {
        row("allowed", range.clone());
    }
    for (value, meaning) in &own.values {
        row("value", format!("{value}: {meaning}"));
    }
    let derived = "none: left out, or derived from other fields";
    row(
        "default",
        own.default.clone().unwrap_or_else(|| derived.to_owned()),
    );
    if !own.presets.is_empty() {
        let all: Vec<String> = own
            .presets
            .iter()
            .map(|(name, v)| format!("{name}: {v}"))
            .collect();
        row("presets", all.join("; "));
    }
    if !knobs.is_empty() {
        row(
            "costs",
            format!("potamoi cost --knobs {} measures it", knobs.join(",")),
        );
    }
    row("page", own.page.to_owned());
    say!("{table}");
}
