//! `potamoi init`: a machine's file with every field and its default, and a plan of a sweep.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use potamoi_base::outputs as files;

use crate::explain::fields::{self, Explained};
use crate::failure::Failure;
use crate::stdout::say;
use crate::tables;

/// Names of the two files.
const MACHINE: &str = "machine.toml";
const PLAN: &str = "plan.toml";

/// The plan: small enough for a minute.
const PLAN_TEXT: &str = "\
# A sweep: potamoi sweep plan.toml --work-dir out/sweep --front fps,mm2
# Every field of a machine can vary; potamoi explain FIELD tells what it is.
machines = [\"machine.toml\"]
scenes = [\"garden\"]
width = 64

[workload]
frames = 4

[vary]
\"vu.lanes\" = [12, 24, 48]
\"gu.ports\" = [1, 2]
";

#[derive(Debug, Args)]
pub(crate) struct InitArgs {
    /// Folder for the files; it is created if missing [default: this one]
    #[arg(value_name = "DIR", default_value = ".", hide_default_value = true)]
    dir: PathBuf,
}

pub(crate) fn run(args: &InitArgs) -> Result<(), Failure> {
    let [machine, plan] = [MACHINE, PLAN].map(|name| args.dir.join(name));
    for path in [&machine, &plan] {
        if path.symlink_metadata().is_ok() {
            return Err(Failure::Usage(format!(
                "{} exists and stays as it is: name another folder, or move it away",
                path.display()
            )));
        }
    }
    files::write(&machine, &machine_text(&fields::all()))?;
    files::write(&plan, PLAN_TEXT)?;
    say!(
        "{}: a machine, that of the paper; each field has its default",
        machine.display()
    );
    say!("{}: a plan that varies two of its fields", plan.display());
    say!(
        "next: potamoi compare paper {} --scene garden --width 64",
        machine.display()
    );
    say!(
        "      potamoi sweep {} --work-dir out/sweep",
        plan.display()
    );
    Ok(())
}

/// A comment, broken at words.
fn comment(text: &mut String, words: &str) {
    text.push_str(&tables::broken_at_words(words, "# ", "# "));
    text.push('\n');
}

/// The file: the preset, and every field as a comment, tables as the fields' paths have them. A line that
/// begins with `#` and no space sets a default.
fn machine_text(all: &[Explained]) -> String {
    let mut text = String::new();
    comment(
        &mut text,
        "A machine: hardware, system, rendering and path. A line that begins with # and no space is a \
         field with its default: take the # away, of its table's line too, and change it.",
    );
    text.push_str("preset = \"paper\"\n");
    // A table stands once, with the fields of tables in it behind its own.
    let own: Vec<&Explained> = all.iter().filter(|own| is_of_machine(own)).collect();
    let place = |own: &Explained| {
        own.field
            .rsplit_once('.')
            .map_or("", |(place, _)| place)
            .to_owned()
    };
    let mut places: Vec<String> = vec![];
    for own in &own {
        if !places.contains(&place(own)) {
            places.push(place(own));
        }
    }
    let own_of = |at: &str| {
        own.iter()
            .copied()
            .filter(move |own| place(own) == at)
            .collect::<Vec<_>>()
            .into_iter()
    };
    let by_place = places.iter().flat_map(|at| {
        let of = own.iter().filter(move |own| place(own) == *at);
        of.enumerate().map(move |(i, own)| (i == 0, at, *own))
    });
    for (is_first, at, own) in by_place {
        let key = own.field.rsplit('.').next().unwrap_or_default();
        if is_first && !at.is_empty() {
            // Writing to a string does not fail.
            let is_there = own_of(at).any(is_settable);
            let _ = match is_there {
                true => write!(text, "\n#[{at}]\n"),
                false => write!(text, "\n# [{at}]: a table that is not there unless given\n"),
            };
        }
        comment(&mut text, &own.meaning);
        if let Some(range) = &own.range {
            comment(&mut text, &format!("Allowed: {range}."));
        }
        let _ = match &own.default {
            Some(default) if is_settable(own) => {
                writeln!(text, "#{key} = {default}")
            }
            Some(default) => writeln!(text, "# {key}: {default} unless given"),
            None => writeln!(text, "# {key}: derived, or that of the scene, unless given"),
        };
    }
    text
}

/// Whether a field has a default that can be written.
fn is_settable(own: &Explained) -> bool {
    own.default.is_some() && (own.kind.is_some() || own.file == "configuration")
}

/// Whether a field stands in a machine's file.
fn is_of_machine(own: &Explained) -> bool {
    match own.file {
        "configuration" | "system" => true,
        "machine" => own.field != "preset",
        "plan" => false,
        // Of descriptions of scenes a machine has the table [render].
        _ => own.field.starts_with("render."),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::config::Config;
    use potamoi_system::system_model::System;

    use super::*;

    /// With every default taken in, the file is the machine of the paper.
    #[test]
    fn every_default_that_the_file_tells_is_the_program_s() {
        let text = machine_text(&fields::all());
        let taken: Vec<&str> = text
            .lines()
            .map(|line| match line.strip_prefix('#') {
                Some(own) if !own.is_empty() && !own.starts_with(' ') => own,
                _ => line,
            })
            .collect();
        let mut table: toml::Table = taken.join("\n").parse().unwrap();
        assert_eq!(table.remove("preset").unwrap().as_str(), Some("paper"));
        let system = table.remove("system").unwrap();
        for section in ["render", "path"] {
            if let Some(own) = table.remove(section) {
                assert!(own.as_table().unwrap().is_empty(), "{own}");
            }
        }
        let config = Config::from_toml(&table.to_string(), "init").unwrap();
        assert_eq!(config, Config::paper());
        let system = System::from_toml(&toml::to_string(&system).unwrap(), "init").unwrap();
        assert_eq!(system, System::default());
        assert_eq!(fields::word_of_source(&text), None);
        assert_eq!(fields::word_of_source(PLAN_TEXT), None);
        assert!(
            text.lines().all(|line| line.chars().count() <= 124),
            "{text}"
        );
    }

    #[test]
    fn files_that_exist_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let args = InitArgs {
            dir: folder.path().join("new"),
        };
        run(&args).unwrap();
        let file = args.dir.join(PLAN);
        std::fs::write(&file, "mine").unwrap();
        assert!(
            run(&args)
                .unwrap_err()
                .to_string()
                .contains("stays as it is")
        );
        assert_eq!(std::fs::read_to_string(file).unwrap(), "mine");
    }
}
