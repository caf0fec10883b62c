//! Renamed flags. The old name is accepted for one version, with a note.

use std::ffi::OsString;

use clap::Command;

/// A flag that was renamed in one command.
struct Renamed {
    command: &'static str,
    old: &'static str,
    new: &'static str,
}

/// Names of the previous version; removed in the next.
const RENAMED: &[Renamed] = &[
    renamed("emit", "out", "out-dir"),
    renamed("warp", "out", "out-dir"),
    renamed("warp", "trace", "chrome-trace"),
    renamed("model", "trace", "chrome-trace"),
    renamed("model", "energy", "plot-energy"),
    renamed("model", "roofline", "plot-roofline"),
    renamed("cost", "unit", "study"),
    renamed("cost", "table", "csv"),
    renamed("estimate", "grid", "fit-to"),
    renamed("effects", "rtl", "run-rtl"),
];

/// Values of old flags that could stand without one, by command and flag.
const UNNAMED: &[(&str, &str, &str)] = &[("cost", "table", "exp-table.csv")];

const fn renamed(command: &'static str, old: &'static str, new: &'static str) -> Renamed {
    Renamed { command, old, new }
}

/// The command line with old names as hidden aliases.
pub(crate) fn accept(mut cli: Command) -> Command {
    for one in RENAMED {
        cli = cli.mut_subcommand(one.command, |command| {
            command.mut_arg(one.new.replace('-', "_"), |flag| flag.alias(one.old))
        });
    }
    cli
}

/// The arguments, with a value for each old flag that could stand without one.
pub(crate) fn with_values(arguments: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut all: Vec<OsString> = vec![];
    for word in arguments.into_iter().map(Some).chain([None]) {
        let is_value = word
            .as_ref()
            .is_some_and(|word| !word.to_string_lossy().starts_with('-'));
        let unnamed = UNNAMED.iter().find(|(command, old, _)| {
            let is_last = all.last().is_some_and(|last| **last == *format!("--{old}"));
            is_last && all.iter().any(|own| own == command)
        });
        if let (Some((_, _, value)), false) = (unnamed, is_value) {
            all.push(value.into());
        }
        all.extend(word);
    }
    all
}

/// One note for each old name among the arguments of `command`.
pub(crate) fn notes(command: &str, arguments: &[OsString]) -> Vec<String> {
    let used = used(command, arguments).into_iter();
    used.map(|one| {
        format!(
            "--{} of potamoi {command} is now --{}; the old name goes with the next version",
            one.old, one.new
        )
    })
    .collect()
}

/// A flag of `command` by the name that the arguments give it, with its dashes.
pub(crate) fn as_given(command: &str, name: &str, arguments: &[OsString]) -> String {
    let used = used(command, arguments).into_iter();
    let old = used.filter(|one| one.new == name).map(|one| one.old).next();
    format!("--{}", old.unwrap_or(name))
}

/// The old names among the arguments of `command`.
fn used(command: &str, arguments: &[OsString]) -> Vec<&'static Renamed> {
    let words: Vec<_> = arguments
        .iter()
        .map(|word| word.to_string_lossy())
        .collect();
    let flags: Vec<&str> = words
        .iter()
        .take_while(|word| *word != "--")
        .filter_map(|word| word.strip_prefix("--"))
        .map(|word| word.split('=').next().unwrap_or(word))
        .collect();
    let used = RENAMED.iter().filter(|one| {
        // clap takes no value that begins with a dash, so that such a word is a flag.
        one.command == command && flags.contains(&one.old)
    });
    used.collect()
}

/// Commands, old names and new names, in Markdown.
#[cfg(test)]
pub(crate) fn table() -> String {
    let mut text = "| command | old name | new name |\n|---|---|---|\n".to_owned();
    for one in RENAMED {
        text += &format!(
            "| `{}` | `--{}` | `--{}` |\n",
            one.command, one.old, one.new
        );
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use clap::CommandFactory as _;

    use super::*;

    /// An old name must not be a flag of the command, or it would have two meanings.
    #[test]
    fn old_names_are_free_and_lead_to_the_new_ones() {
        let cli = accept(crate::cli::Cli::command());
        for one in RENAMED {
            let command = cli.find_subcommand(one.command).unwrap();
            let named = |name: &str| {
                let mut flags = command.get_arguments();
                flags.any(|flag| flag.get_long() == Some(name))
            };
            assert!(!named(one.old), "{} --{}", one.command, one.old);
            assert!(named(one.new), "{} --{}", one.command, one.new);
        }
    }

    #[test]
    fn a_note_names_the_new_flag_and_only_where_the_old_one_stands() {
        let notes = |command, words: &[&str]| {
            let words: Vec<OsString> = words.iter().map(OsString::from).collect();
            notes(command, &words)
        };
        let said = notes("emit", &["emit", "--out=rtl"]);
        assert_eq!(said.len(), 1);
        assert!(said[0].contains("--out-dir"), "{said:?}");
        assert!(notes("emit", &["emit", "--out-dir", "out"]).is_empty());
        assert!(notes("render", &["render", "--out", "p.png"]).is_empty());
        assert_eq!(notes("cost", &["cost", "--unit", "exp"]).len(), 1);
        assert_eq!(notes("cost", &["cost", "--table", "e.csv"]).len(), 1);
        let given = |words: [&str; 3]| as_given("estimate", "fit-to", &words.map(OsString::from));
        assert_eq!(given(["estimate", "--grid", "g.json"]), "--grid");
        assert_eq!(given(["estimate", "--fit-to", "g.json"]), "--fit-to");
    }

    #[test]
    fn an_old_flag_without_a_value_gets_its_own() {
        for (given, expected) in [
            ("cost --table", "cost --table exp-table.csv"),
            (
                "cost --table --json r",
                "cost --table exp-table.csv --json r",
            ),
            ("cost --table e.csv", "cost --table e.csv"),
            ("cost --csv e.csv", "cost --csv e.csv"),
            ("verify --table", "verify --table"),
        ] {
            let [given, expected] = [given, expected]
                .map(|line| -> Vec<OsString> { line.split(' ').map(OsString::from).collect() });
            assert_eq!(with_values(given), expected);
        }
    }
}
