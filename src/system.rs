//! `potamoi system`: a system as a description to start from.

use std::path::{Path, PathBuf};

use clap::Args;
use potamoi_system::system_model::System;

use crate::explain::fields;
use crate::failure::Failure;
use crate::stdout::say;
use crate::tables;

/// Name of the paper's system.
const PAPER: &str = "paper";

#[derive(Debug, Args)]
pub(crate) struct SystemArgs {
    /// System to print as a description, with every field and its meaning: `paper`, the name of a GPU, or a file
    #[arg(long, value_name = "SYSTEM", required = true)]
    print: PathBuf,
}

pub(crate) fn run(args: &SystemArgs) -> Result<(), Failure> {
    let system = match args.print == Path::new(PAPER) {
        true => System::default(),
        false => System::named(&args.print)?,
    };
    say!("{}", text(&system)?.trim_end());
    Ok(())
}

/// The description, each field below its meaning.
fn text(system: &System) -> Result<String, Failure> {
    let fail = |error: toml::ser::Error| Failure::Output(error.to_string());
    let plain = toml::to_string(system).map_err(fail)?;
    let known = fields::all();
    let (mut text, mut table) = (String::new(), String::new());
    for line in plain.lines() {
        if let Some(name) = line.strip_prefix('[').and_then(|own| own.strip_suffix(']')) {
            table = format!("{name}.");
        } else if let Some((key, _)) = line.split_once(" = ") {
            let field = format!("system.{table}{key}");
            if let Some(own) = known.iter().find(|own| own.field == field) {
                text += &tables::broken_at_words(&own.meaning, "# ", "# ");
                text.push('\n');
            }
        }
        text += line;
        text.push('\n');
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_is_printed_is_the_system() {
        for name in ["xavier", "orin-nx"] {
            let system = System::named(Path::new(name)).unwrap();
            let text = text(&system).unwrap();
            assert_eq!(System::from_toml(&text, name).unwrap(), system, "{text}");
            assert!(
                text.contains("# Rows of the MAC array.\narray_rows"),
                "{text}"
            );
        }
    }
}
