//! One vocabulary: a flag has one meaning and one unit in all commands, and the command line's
//! reference page agrees with the program.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::any::TypeId;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use clap::{Arg, Command, CommandFactory as _};
use clap_complete::Shell;

use crate::cli::Cli;
use crate::explain::fields::word_of_source;
use crate::refusals::WITHOUT_CONFIGURATION;
use crate::{refusals, renamed, roles};

/// Value placeholders in help, with their meanings. A list is written `NAME,...`.
const VALUES: &[(&str, &str)] = &[
    ("ADDRESS", "protocol, host and port"),
    ("AXES", "three directions"),
    ("CYCLES", "clock cycles"),
    ("DB", "dB"),
    ("DEG", "degrees"),
    ("DIR", "folder"),
    ("EFFECT", "name"),
    ("FIELD=VALUES", "a field and its values"),
    ("FILE", "file"),
    ("FPS", "frames a second"),
    ("GHZ", "GHz"),
    ("MJ", "millijoules"),
    ("MM2", "square millimetres"),
    ("MS", "milliseconds"),
    ("N", "whole number"),
    ("NAME", "name"),
    ("NM", "nanometres"),
    ("PIXELS", "pixels"),
    ("SCENE", "name or file"),
    ("SHARE", "share, 0 to 1"),
    ("SYSTEM", "name of a GPU, or file"),
];
/// Placeholders without a unit.
const UNITLESS: &[&str] = &[
    "ADDRESS",
    "AXES",
    "DIR",
    "EFFECT",
    "FIELD=VALUES",
    "FILE",
    "N",
    "NAME",
    "SCENE",
    "SYSTEM",
];

/// Units by quantity (clock, duration, angle), each with its spellings in lower case. Flags have one
/// unit of each.
const UNITS: [&[&[&str]]; 3] = [
    &[&["ghz", "gigahertz"], &["mhz", "megahertz"]],
    &[
        &["ms", "milliseconds"],
        &["s", "seconds"],
        &["us", "microseconds"],
    ],
    &[&["deg", "degrees"], &["rad", "radians"]],
];

/// A flag of one command.
struct Flag {
    command: String,
    name: String,
    meaning: String,
    /// Base of the value's placeholder, without the mark of a list; `None` for switches and
    /// enumerations.
    value: Option<String>,
    is_list: bool,
    /// Values of an enumeration with their meanings.
    choices: Vec<(String, String)>,
    default: Option<String>,
    is_number: bool,
}

impl Flag {
    fn of(command: &str, flag: &Arg) -> Self {
        let help = flag.get_help().map(ToString::to_string).unwrap_or_default();
        let (meaning, said) = match help.split_once(" [default: ") {
            Some((meaning, rest)) => (meaning.to_owned(), rest.strip_suffix(']')),
            None => (help, None),
        };
        let is_switch = !flag.get_action().takes_values();
        let choices: Vec<_> = match is_switch {
            true => vec![],
            false => (flag.get_possible_values().iter())
                .map(|v| {
                    let help = v.get_help().map(ToString::to_string);
                    (v.get_name().to_owned(), help.unwrap_or_default())
                })
                .collect(),
        };
        let name = flag.get_value_names().and_then(<[_]>::first);
        let name = name.map(ToString::to_string).filter(|_| !is_switch);
        let is_list = name.as_ref().is_some_and(|name| name.ends_with(",..."));
        let id = flag.get_id().as_str();
        let given = flag.get_default_values();
        let default = if !is_switch && !given.is_empty() {
            let given: Vec<_> = given.iter().map(|v| v.to_string_lossy()).collect();
            Some(format!("`{}`", given.join(",")))
        } else if let Some(said) = said {
            Some(said.to_owned())
        } else if is_switch {
            Some("off".to_owned())
        } else if flag.is_required_set() {
            Some("required".to_owned())
        } else if roles::is_output(id) {
            Some("not written".to_owned())
        } else {
            None
        };
        let types = [TypeId::of::<f64>(), TypeId::of::<f32>()];
        let own = flag.get_value_parser().type_id();
        Self {
            command: command.to_owned(),
            name: flag.get_long().unwrap_or_default().to_owned(),
            meaning,
            value: match choices.is_empty() {
                true => name.map(|name| name.trim_end_matches(",...").to_owned()),
                false => None,
            },
            is_list,
            choices,
            default,
            is_number: types.iter().any(|known| own == *known),
        }
    }
}

/// All flags of all commands; global flags are listed under the commands that use them.
fn flags(cli: &Command) -> BTreeMap<String, Vec<Flag>> {
    let mut found: BTreeMap<String, Vec<Flag>> = BTreeMap::new();
    let commands = cli.get_subcommands().map(|own| (own.get_name(), own));
    let all = format!("all but {}", WITHOUT_CONFIGURATION.join(", "));
    for (name, command) in std::iter::once((&*all, cli)).chain(commands) {
        for flag in command.get_arguments() {
            let is_shown = flag.get_long().is_some() && !flag.is_hide_set();
            if is_shown && !["help", "version"].contains(&flag.get_id().as_str()) {
                let flag = Flag::of(name, flag);
                found.entry(flag.name.clone()).or_default().push(flag);
            }
        }
    }
    found
}

/// Faults of the vocabulary.
fn faults(cli: &Command) -> Vec<String> {
    let mut faults = vec![];
    let flags = flags(cli);
    for (name, uses) in &flags {
        let first = &uses[0];
        let mut choices: BTreeMap<&str, &str> = BTreeMap::new();
        for flag in uses {
            let place = format!("{} --{name}", flag.command);
            if flag.meaning.is_empty() {
                faults.push(format!("{place} has no meaning"));
            }
            if (&flag.meaning, &flag.value) != (&first.meaning, &first.value) {
                faults.push(format!("{place} has another meaning in {}", first.command));
            }
            for (value, meaning) in &flag.choices {
                if choices
                    .insert(value, meaning)
                    .is_some_and(|known| known != meaning)
                {
                    faults.push(format!("{place} {value} has two meanings"));
                }
            }
            if let Some(value) = &flag.value {
                if VALUES.iter().all(|(known, _)| known != value) {
                    faults.push(format!("{place}: unknown kind of value {value}"));
                }
                if flag.is_number && UNITLESS.contains(&value.as_str()) {
                    faults.push(format!("{place}: {value} has no unit"));
                }
            }
            let is_named = |other: &&Flag| flag.meaning.contains(&format!("`{}`", other.command));
            if let Some(other) = uses.iter().filter(|_| uses.len() > 1).find(is_named) {
                faults.push(format!(
                    "{place} has a meaning of its own in {}",
                    other.command
                ));
            }
            if flag.default.is_none() {
                faults.push(format!("{place} does not tell what it is unless given"));
            }
        }
    }
    let told = |unit: &[&str]| {
        flags.values().flatten().find(|flag| {
            let value = flag.value.clone().unwrap_or_default();
            let told = [&flag.name, &flag.meaning, &value].map(|text| text.to_lowercase());
            let is_end = |c: char| !c.is_alphanumeric() && !['\'', '/'].contains(&c);
            let mut words = told.iter().flat_map(|text| text.split(is_end));
            words.any(|word| unit.contains(&word))
        })
    };
    for units in UNITS {
        let mut told = units.iter().filter_map(|unit| Some((unit, told(unit)?)));
        if let (Some((one, a)), Some((other, b))) = (told.next(), told.next()) {
            let (one, other) = (one[0], other[0]);
            faults.push(format!("--{} is in {one}, --{} in {other}", a.name, b.name));
        }
    }
    faults
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn command_table(cli: &Command) -> String {
    let mut text = "| command | what it does |\n|---|---|\n".to_owned();
    for command in cli.get_subcommands() {
        let about = command.get_about().map(ToString::to_string);
        text += &format!(
            "| `{}` | {} |\n",
            command.get_name(),
            about.unwrap_or_default()
        );
    }
    text
}

/// Placeholder of a flag's value, and its unit.
fn value_cell(uses: &[Flag]) -> String {
    // What holds for some of the commands alone names them.
    let some = |has: &dyn Fn(&Flag) -> bool| {
        let commands = uses.iter().filter(|flag| has(flag));
        let commands: Vec<_> = commands.map(|flag| &*flag.command).collect();
        match commands.len() == uses.len() {
            true => String::new(),
            false => format!(" ({})", commands.join(", ")),
        }
    };
    let mut text = match &uses[0].value {
        Some(value) => {
            let unit = VALUES.iter().find(|(known, _)| known == value).unwrap().1;
            match value.to_lowercase() == unit.to_lowercase() {
                true => format!("`{value}`"),
                false => format!("`{value}`, {unit}"),
            }
        }
        None => {
            let mut seen = BTreeSet::new();
            let all = uses.iter().flat_map(|flag| &flag.choices);
            let names = all.filter(|(name, _)| seen.insert(name)).map(|(name, _)| {
                let of = some(&|flag| flag.choices.iter().any(|(own, _)| own == name));
                format!("`{name}`{of}")
            });
            names.collect::<Vec<_>>().join(", ")
        }
    };
    if uses.iter().any(|flag| flag.is_list) {
        text += &format!("; several{}", some(&|flag| flag.is_list));
    }
    text
}

fn flag_table(flags: &BTreeMap<String, Vec<Flag>>) -> String {
    let head = "| flag | value, unit | default | meaning | commands |\n|---|---|---|---|---|\n";
    let mut text = head.to_owned();
    for (name, uses) in flags {
        let mut defaults: Vec<(&str, Vec<&str>)> = vec![];
        for flag in uses {
            let own = flag.default.as_deref().unwrap_or_default();
            match defaults.iter_mut().find(|(default, _)| *default == own) {
                Some((_, commands)) => commands.push(&flag.command),
                None => defaults.push((own, vec![&flag.command])),
            }
        }
        let default: Vec<_> = match &defaults[..] {
            [(one, _)] => vec![(*one).to_owned()],
            several => (several.iter())
                .map(|(default, commands)| format!("{}: {default}", commands.join(", ")))
                .collect(),
        };
        // A flag of the program as a whole is not named again for a command that declares its own.
        let is_whole = uses[0].command.starts_with("all but ");
        let listed = uses.iter().take(if is_whole { 1 } else { uses.len() });
        let commands: Vec<_> = listed.map(|flag| &*flag.command).collect();
        text += &format!(
            "| `--{name}` | {} | {} | {} | {} |\n",
            cell(&value_cell(uses)),
            cell(&default.join("; ")),
            cell(&uses[0].meaning),
            commands.join(", "),
        );
    }
    text
}

fn choice_table(flags: &BTreeMap<String, Vec<Flag>>) -> String {
    let mut text = "| flag | value | meaning |\n|---|---|---|\n".to_owned();
    for (name, uses) in flags {
        let mut seen = BTreeSet::new();
        for (value, meaning) in uses.iter().flat_map(|flag| &flag.choices) {
            if !meaning.is_empty() && seen.insert(value) {
                text += &format!("| `--{name}` | `{value}` | {} |\n", cell(meaning));
            }
        }
    }
    text
}

/// A page with one of its tables replaced.
fn with_table(page: &str, name: &str, table: &str) -> String {
    let start = format!("<!-- {name}: written by the program's own test -->\n");
    let (before, rest) = page.split_once(&start).unwrap();
    let (_, after) = rest.split_once("<!-- end -->").unwrap();
    format!("{before}{start}\n{table}\n<!-- end -->{after}")
}

#[test]
fn every_flag_has_one_meaning_one_unit_and_a_default() {
    let faults = faults(&Cli::command());
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Refusals name the unit of every number that has one.
#[test]
fn every_unit_is_known_to_refusals() {
    let own = VALUES.iter().filter(|(name, _)| !UNITLESS.contains(name));
    let units: Vec<_> = own.filter(|(name, _)| *name != "SHARE").copied().collect();
    assert_eq!(units, refusals::UNITS);
}

#[test]
fn no_help_has_words_of_the_source() {
    let cli = Cli::command();
    for own in cli.get_subcommands() {
        let mut own = own.clone();
        let name = own.get_name().to_owned();
        let text = own.render_long_help().to_string();
        assert_eq!(word_of_source(&text), None, "{name}: {text}");
    }
}

#[test]
fn faults_of_a_vocabulary_are_found() {
    let with = |flag: Arg| Cli::command().mut_subcommand("doctor", |doctor| doctor.arg(flag));
    let flag = |name: &'static str, value: &'static str, help: &'static str| {
        Arg::new(name).long(name).value_name(value).help(help)
    };
    let found = |flag: Arg| faults(&with(flag)).join("; ");
    let fps = "Frame rate of the scene's own camera path, or of a recorded motion [default: 30]";
    assert_eq!(found(flag("fps", "FPS", fps)), "");
    assert!(found(flag("fps", "FPS", "Another [default: 1]")).contains("another meaning"));
    assert!(found(flag("fps", "MS", fps)).contains("another meaning"));
    assert!(found(flag("far", "MILES", "How far [default: 1]")).contains("unknown kind"));
    let far = flag("far", "N", "How far [default: 1]").value_parser(clap::value_parser!(f64));
    assert!(found(far).contains("no unit"));
    assert!(found(flag("far", "N", "How far")).contains("unless given"));
    assert!(found(flag("bus-mhz", "N", "Clock of a bus [default: 1]")).contains("in mhz"));
    assert!(found(flag("wait-s", "N", "A wait [default: 1]")).contains("in s"));
    let both = "Seed of stalls (`doctor`) or of a placement (`synth`) [default: 1]";
    let both = |cli: Command| {
        ["doctor", "cache"].into_iter().fold(cli, |cli, command| {
            cli.mut_subcommand(command, |own| own.arg(flag("start", "N", both)))
        })
    };
    let said = faults(&both(Cli::command())).join("; ");
    assert!(said.contains("a meaning of its own in doctor"), "{said}");
    let local = clap::builder::PossibleValue::new("local").help("Another place");
    let scenario = "Where full frames are rendered [default: local]";
    let scenario = flag("scenario", "X", scenario).value_parser([local]);
    assert!(found(scenario).contains("two meanings"));
}

#[test]
fn the_reference_page_says_what_the_program_says() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/cli.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let cli = Cli::command();
    let flags = flags(&cli);
    let tables = [
        ("commands", command_table(&cli)),
        ("flags", flag_table(&flags)),
        ("values", choice_table(&flags)),
        ("renamed", renamed::table()),
    ];
    let now = (tables.iter()).fold(page.clone(), |page, (name, table)| {
        with_table(&page, name, table)
    });
    if std::env::var_os("POTAMOI_REFRESH").is_some() {
        std::fs::write(&path, now).unwrap();
        return;
    }
    assert!(
        page == now,
        "docs/reference/cli.md is not current; write it with\n\
         POTAMOI_REFRESH=1 cargo test --bin potamoi vocabulary"
    );
}

#[test]
fn every_command_has_a_manual_page_and_every_shell_its_completions() {
    let all = crate::shell_files::pages(Cli::command()).unwrap();
    assert_eq!(all.len(), Cli::command().get_subcommands().count() + 1);
    for (name, page) in &all {
        assert!(
            page.contains(".SH NAME") && page.len() > 300,
            "{name}: {page}"
        );
    }
    let cost = all.iter().find(|(name, _)| name == "potamoi-cost.1");
    let (_, cost) = cost.unwrap();
    assert!(cost.contains("target") && cost.contains("knobs"), "{cost}");
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
        let mut text = vec![];
        clap_complete::generate(shell, &mut Cli::command(), "potamoi", &mut text);
        let text = String::from_utf8(text).unwrap();
        assert!(
            text.contains("hard-cases") && text.contains("target-psnr"),
            "{shell}"
        );
    }
}
