//! The `potamoi` command line.
//!
//! Exit codes: 0 right, 1 a check failed, 2 usage or configuration, 3 a tool
//! is missing, 4 inconclusive.

mod characterise;
mod charts;
mod cli;
mod common;
mod cost;
mod doctor;
mod effects;
mod emit;
mod estimate;
mod failure;
mod files;
mod layouts;
mod model;
mod progress;
mod render;
mod say;
mod scene;
mod sequence;
mod setup;
mod synth;
mod tables;
mod trace;
mod verify;
mod warp;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let cli = cli::Cli::parse();
    let done = match &cli.command {
        cli::Command::Emit(args) => emit::run(&cli.common, args),
        cli::Command::Trace(args) => trace::run(&cli.common, args),
        cli::Command::Verify(args) => verify::run(&cli.common, args),
        cli::Command::Render(args) => render::run(&cli.common, args),
        cli::Command::Warp(args) => warp::run(args),
        cli::Command::Effects(args) => effects::run(&cli.common, args),
        cli::Command::Characterise(args) => characterise::run(&cli.common, args),
        cli::Command::Layouts(args) => layouts::run(&cli.common, args),
        cli::Command::Synth(args) => synth::run(&cli.common, args),
        cli::Command::Estimate(args) => estimate::run(&cli.common, args),
        cli::Command::Model(args) => model::run(&cli.common, args),
        cli::Command::Cost(args) => cost::run(&cli.common, args),
        cli::Command::Doctor(args) => doctor::run(args.json.as_deref()).map_err(Into::into),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            failure.exit_code()
        }
    }
}
