//! `potamoi schema`: JSON schemas of the reports.

#[cfg(test)]
mod tests;

use crate::failure::Failure;
use crate::published::Published;
use crate::stdout::say;
use crate::suggest;
use crate::{
    bench, cache, characterise, compare, cost, doctor, effects, emit, estimate, explain, explore,
    hard_cases, inspect, layouts, model, mutate, prove, render, report, sweep, synth, tables,
    trace, verify, warp,
};

/// The reports of all commands that have `--json`, in the order of the commands.
pub(crate) const ALL: &[&[Published]] = &[
    &[
        emit::REPORT,
        trace::REPORT,
        verify::REPORT,
        prove::REPORT,
        mutate::REPORT,
        render::REPORT,
        warp::REPORT,
        effects::REPORT,
        hard_cases::REPORT,
        characterise::REPORT,
        layouts::REPORT,
        synth::REPORT,
        synth::FPGA,
        estimate::REPORT,
    ],
    &model::REPORTS,
    &[
        compare::REPORT,
        compare::RIVALS,
        sweep::REPORT,
        explore::REPORT,
        cost::REPORT,
        inspect::REPORT,
        report::REPORT,
        explain::REPORT,
        cache::REPORT,
        bench::REPORT,
        doctor::REPORT,
    ],
];

fn all() -> impl Iterator<Item = &'static Published> {
    ALL.iter().copied().flatten()
}

/// Prints the schema of a report; without a name all are listed.
pub(crate) fn run(name: Option<&str>) -> Result<(), Failure> {
    let Some(given) = name else {
        let mut table = tables::plain(["schema", "format_version"]);
        for own in all() {
            table.add_row([own.name(), own.version.to_string()]);
        }
        say!("{}", table.trim_fmt());
        return Ok(());
    };
    let names: Vec<String> = all().map(Published::name).collect();
    let Some(own) = all().find(|own| own.name() == given) else {
        return Err(Failure::Usage(suggest::with_nearest(
            format!("schema {given}: no report has this name; potamoi schema lists them"),
            given,
            names.iter().map(|own| &**own),
        )));
    };
    say!("{}", own.text()?.trim_end());
    Ok(())
}
