//! The `potamoi` command line.
//!
//! Exit codes: 0 success, 1 failed check, 2 usage, configuration, input or output, 3 missing or
//! broken tool, 4 inconclusive check.

mod args;
mod bench;
mod bounds;
mod cache;
mod characterise;
mod charts;
mod cli;
mod compare;
mod cost;
mod doctor;
mod effects;
mod emit;
mod emit_exponential;
mod emit_unit;
mod estimate;
mod explain;
mod explore;
mod exponential_price;
mod failure;
mod found;
mod front_fields;
mod given_syntheses;
mod hard_cases;
mod init;
mod inspect;
mod layouts;
mod model;
mod mutate;
mod progress;
mod prove;
mod published;
mod reasons;
mod refusals;
mod renamed;
mod render;
mod report;
mod report_files;
mod roles;
mod scene;
mod schemas;
mod shell_files;
mod stdout;
mod suggest;
mod sweep;
mod synth;
mod system;
mod tables;
mod trace;
mod verify;
#[cfg(test)]
mod vocabulary;
mod warp;

use std::io::Write as _;
use std::process::ExitCode;

use clap::{CommandFactory as _, FromArgMatches as _};

use potamoi_base::{file_set, memory_limit};
use potamoi_verilated::child;

use failure::Failure;

/// Prints a failure, and returns its exit code.
fn parting(failure: &Failure) -> ExitCode {
    match suggest::of(failure) {
        Some(name) => stdout::error(format_args!("{failure}; did you mean `{name}`?")),
        None => stdout::error(format_args!("{failure}")),
    }
    failure.exit_code()
}

/// Prints clap's answer: an error, help or a version.
fn answer(error: &clap::Error) -> ExitCode {
    if let Some(message) = refusals::of_value(error) {
        return parting(&Failure::Usage(message));
    }
    let printed = error.print().and_then(|()| std::io::stdout().flush());
    match printed {
        Err(why) if why.kind() != std::io::ErrorKind::BrokenPipe => {
            parting(&Failure::Output(why.to_string()))
        }
        // 0 of help, 2 of errors.
        _ => ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2)),
    }
}

fn main() -> ExitCode {
    if let Some(done) = file_set::finish_if_asked() {
        return match done {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => Failure::from(error).exit_code(),
        };
    }
    let arguments = renamed::with_values(std::env::args_os());
    let parsed = refusals::prepared(renamed::accept(cli::Cli::command()))
        .try_get_matches_from(&arguments)
        .and_then(|matches| Ok((cli::Cli::from_arg_matches(&matches)?, matches)));
    let (cli, matches) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => {
            let command = arguments.get(1).and_then(|own| own.to_str());
            return answer(&refusals::guided(error, command));
        }
    };
    match memory_limit::run_within() {
        None => {}
        Some(Ok(code)) => return ExitCode::from(code),
        Some(Err(error)) => return parting(&error.into()),
    }
    let arguments = &arguments[1.min(arguments.len())..];
    for note in renamed::notes(matches.subcommand_name().unwrap_or_default(), arguments) {
        stdout::remark(format_args!("{note}"));
    }
    let done = child::check_limit()
        .map_err(|error| Failure::Usage(error.to_string()))
        .and_then(|()| {
            cli.common
                .check(matches.subcommand_name().unwrap_or_default())
        })
        .and_then(|()| roles::check(&matches, arguments))
        .and_then(|()| run(&cli));
    if done.as_ref().err().is_none_or(Failure::is_failed_check) {
        scene::say_what_is_left_open();
    }
    let done = match (done, stdout::lost()) {
        (Ok(()), Some(why)) => Err(Failure::Output(why)),
        (done, _) => done,
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => parting(&failure),
    }
}

fn run(cli: &cli::Cli) -> Result<(), Failure> {
    if cli.common.wide {
        tables::show_all_columns();
    }
    match &cli.command {
        cli::Command::Emit(args) => emit::run(&cli.common, args),
        cli::Command::Trace(args) => trace::run(&cli.common, args),
        cli::Command::Verify(args) => verify::run(&cli.common, args),
        cli::Command::Prove(args) => prove::run(&cli.common, args),
        cli::Command::Mutate(args) => mutate::run(&cli.common, args),
        cli::Command::Render(args) => render::run(&cli.common, args),
        cli::Command::Warp(args) => warp::run(args),
        cli::Command::Effects(args) => effects::run(&cli.common, args),
        cli::Command::HardCases(args) => hard_cases::run(&cli.common, args),
        cli::Command::Characterise(args) => characterise::run(&cli.common, args),
        cli::Command::Layouts(args) => layouts::run(&cli.common, args),
        cli::Command::Synth(args) => synth::run(&cli.common, args),
        cli::Command::Estimate(args) => estimate::run(&cli.common, args),
        cli::Command::Model(args) => model::run(&cli.common, args),
        cli::Command::Compare(args) => compare::run(args),
        cli::Command::Sweep(args) => sweep::run(args),
        cli::Command::Explore(args) => explore::run(args),
        cli::Command::Report(args) => report::run(args),
        cli::Command::Cost(args) => cost::run(&cli.common, args),
        cli::Command::Inspect(args) => inspect::run(&cli.common, args),
        cli::Command::Explain(args) => explain::run(args),
        cli::Command::Init(args) => init::run(args),
        cli::Command::System(args) => system::run(args),
        cli::Command::Completions(args) => {
            shell_files::completions(args, refusals::prepared(cli::Cli::command()));
            Ok(())
        }
        cli::Command::Man(args) => shell_files::man(args, refusals::prepared(cli::Cli::command())),
        cli::Command::Cache(args) => cache::run(args),
        cli::Command::Schema(args) => schemas::run(args.of.as_deref()),
        cli::Command::Bench(args) => bench::run(args),
        cli::Command::Doctor(args) => doctor::run(&args.files),
    }
}
