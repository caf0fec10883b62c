//! Arguments that are refused before any command runs, in the words of all other errors.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};

/// Commands whose result no configuration changes.
pub(crate) const WITHOUT_CONFIGURATION: [&str; 13] = [
    "warp",
    "compare",
    "sweep",
    "explore",
    "explain",
    "init",
    "system",
    "schema",
    "completions",
    "man",
    "cache",
    "bench",
    "doctor",
];

/// Placeholders of values with a unit, and the unit as messages have it.
pub(crate) const UNITS: [(&str, &str); 10] = [
    ("CYCLES", "clock cycles"),
    ("DB", "dB"),
    ("DEG", "degrees"),
    ("FPS", "frames a second"),
    ("GHZ", "GHz"),
    ("MJ", "millijoules"),
    ("MM2", "square millimetres"),
    ("MS", "milliseconds"),
    ("NM", "nanometres"),
    ("PIXELS", "pixels"),
];
/// Units with which a number may be given by mistake, the placeholder of the unit that is expected, and the
/// factor to it.
const CONVERTED: [(&str, &str, f64); 6] = [
    ("mhz", "GHZ", 1e-3),
    ("hz", "GHZ", 1e-9),
    ("us", "MS", 1e-3),
    ("s", "MS", 1e3),
    ("j", "MJ", 1e3),
    ("rad", "DEG", 180.0 / std::f64::consts::PI),
];

/// The command line, with what is refused before a command runs: a number below zero is a value and no
/// flag, and commands that use no configuration do not list `--config`.
pub(crate) fn prepared(cli: Command) -> Command {
    let names: Vec<String> = cli
        .get_subcommands()
        .map(|own| own.get_name().to_owned())
        .collect();
    let cli = names.iter().fold(cli, |cli, name| {
        cli.mut_subcommand(name, |own| {
            own.mut_args(|flag| match takes_number(&flag) {
                true => flag.allow_negative_numbers(true),
                false => flag,
            })
        })
    });
    WITHOUT_CONFIGURATION.into_iter().fold(cli, |cli, name| {
        cli.mut_subcommand(name, |own| own.arg(refused_configuration(name)))
    })
}

/// Whether the value of a flag is a number.
fn takes_number(flag: &Arg) -> bool {
    let name = flag.get_value_names().and_then(<[_]>::first);
    let name = name.map(|own| own.trim_end_matches(",..."));
    let is_number = |own: &str| {
        let mut units = UNITS.iter().map(|(name, _)| *name);
        ["N", "SHARE"].contains(&own) || units.any(|name| name == own)
    };
    flag.get_action().takes_values() && name.is_some_and(is_number)
}

/// The text that refuses a configuration.
pub(crate) fn no_configuration(command: &str) -> String {
    format!("{command} uses no configuration: leave it out")
}

/// `--config` of a command that has no use for it.
fn refused_configuration(command: &'static str) -> Arg {
    Arg::new("config")
        .long("config")
        .value_name("FILE")
        .hide(true)
        .value_parser(move |_: &str| Err::<String, _>(no_configuration(command)))
}

/// Tells what to do instead of an unknown flag: clap would have it passed as a value.
pub(crate) fn guided(mut error: clap::Error, command: Option<&str>) -> clap::Error {
    if error.kind() != ErrorKind::UnknownArgument {
        return error;
    }
    let Some(ContextValue::String(flag)) = error.get(ContextKind::InvalidArg) else {
        return error;
    };
    let tip = match flag.as_str() {
        "--scene" if command == Some("report") => Some("scenes stand without a flag"),
        "--camera" if command == Some("report") => Some(
            "a scene's camera stands in its description, a TOML file: [camera] with \
             kind = \"opencv-json\" and path = \"FILE\"",
        ),
        _ => None,
    };
    let is_of_values = match error.get(ContextKind::Suggested) {
        Some(ContextValue::StyledStrs(own)) => {
            own.iter().any(|tip| tip.to_string().contains("as a value"))
        }
        _ => false,
    };
    if let Some(tip) = tip {
        error.insert(
            ContextKind::Suggested,
            ContextValue::StyledStrs(vec![tip.into()]),
        );
    } else if is_of_values {
        error.remove(ContextKind::Suggested);
    }
    error
}

/// The message of a value that is refused; `None` of other errors, which clap words well.
pub(crate) fn of_value(error: &clap::Error) -> Option<String> {
    if error.kind() != ErrorKind::ValueValidation {
        return None;
    }
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(own)) => Some(own.as_str()),
        _ => None,
    };
    let (flag, value) = (
        text(ContextKind::InvalidArg)?,
        text(ContextKind::InvalidValue)?,
    );
    let why = std::error::Error::source(error).map(ToString::to_string)?;
    // Some reasons begin with the value.
    let why = why.strip_prefix(&format!("{value}: ")).unwrap_or(&why);
    let (name, placeholder) = flag.split_once(' ').unwrap_or((flag, ""));
    let placeholder = placeholder.trim_matches(['<', '>']);
    let placeholder = placeholder.strip_suffix(",...").unwrap_or(placeholder);
    let shown = match value {
        "" => "\"\"",
        value => value,
    };
    Some(format!(
        "{name} {shown}: {}",
        expected(value, placeholder, why)
    ))
}

/// What was expected, from the reason that a parser of numbers gives; other reasons stay.
fn expected(value: &str, placeholder: &str, why: &str) -> String {
    let unit = UNITS.iter().find(|(own, _)| *own == placeholder);
    let of_unit = unit.map_or_else(String::new, |(_, unit)| format!(" of {unit}"));
    let kind = match why {
        "invalid digit found in string" | "cannot parse integer from empty string" => {
            "a whole number"
        }
        "invalid float literal" | "cannot parse float from empty string" => "a number",
        "number too large to fit in target type" => {
            return format!("the number is too large: expected a smaller whole number{of_unit}");
        }
        "number too small to fit in target type" => {
            return format!("expected a whole number{of_unit}, 0 or more");
        }
        why => return outside(value, why, &of_unit).unwrap_or_else(|| why.to_owned()),
    };
    let hint = match with_unit(value, placeholder) {
        Some(hint) => format!("; {hint}"),
        None => String::new(),
    };
    format!("expected {kind}{of_unit}{hint}")
}

/// A number outside a range, as clap tells it: `0 is not in 1..=4294967295`.
fn outside(value: &str, why: &str, of_unit: &str) -> Option<String> {
    let (_, range) = why.split_once(" is not in ")?;
    let (low, high) = range.split_once("..")?;
    let high: i128 = match high.strip_prefix('=') {
        Some(high) => high.parse().ok()?,
        None => high.parse::<i128>().ok()? - 1,
    };
    // No more than the type's limit.
    let is_open = [u32::MAX.into(), u64::MAX.into(), i64::MAX.into()].contains(&high);
    if is_open && value.parse::<i128>().is_ok_and(|own| own > high) {
        return Some(format!(
            "the number is too large: expected a smaller whole number{of_unit}"
        ));
    }
    Some(match is_open {
        true => format!("expected a whole number{of_unit}, {low} or more"),
        false => format!("expected a whole number{of_unit}, {low} to {high}"),
    })
}

/// What to write in place of a number with a unit behind it.
fn with_unit(value: &str, placeholder: &str) -> Option<String> {
    let at = value.rfind(|c: char| c.is_ascii_digit() || c == '.')? + 1;
    let (number, unit) = (&value[..at], value[at..].trim().to_lowercase());
    let number: f64 = number.trim().parse().ok()?;
    if unit.is_empty() || !unit.chars().all(|c| c.is_ascii_alphanumeric()) {
        return None;
    }
    let known = CONVERTED
        .iter()
        .find(|(own, of, _)| *own == unit && *of == placeholder);
    Some(match known {
        Some((_, _, factor)) => {
            let own = (number * factor * 1e9).round() / 1e9;
            format!("the unit is fixed and not written: write {own}")
        }
        None => format!("a unit is not written: write {number}"),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use clap::CommandFactory as _;

    use super::*;

    fn said(line: &str) -> String {
        let words = std::iter::once("potamoi").chain(line.split(' '));
        let error = prepared(crate::cli::Cli::command())
            .try_get_matches_from(words)
            .unwrap_err();
        of_value(&error).unwrap_or_else(|| error.to_string())
    }

    #[test]
    fn unknown_flags_are_not_offered_as_values() {
        for (flag, tip) in [
            ("--scene", Some("scenes stand without a flag")),
            ("--camera", Some("stands in its description")),
            ("--colour", None),
        ] {
            let words = ["potamoi", "report", flag, "a", "--out", "x.html"];
            let error = prepared(crate::cli::Cli::command()).try_get_matches_from(words);
            let text = guided(error.unwrap_err(), Some("report")).to_string();
            assert!(!text.contains("as a value"), "{text}");
            assert!(tip.is_none_or(|tip| text.contains(tip)), "{text}");
        }
    }

    #[test]
    fn values_are_refused_in_words() {
        for (line, expected) in [
            (
                "render --width ten --out p.png",
                "--width ten: expected a whole number of pixels",
            ),
            (
                "render --width 64px --out p.png",
                "--width 64px: expected a whole number of pixels; a unit is not written: write 64",
            ),
            (
                "render --width -3 --out p.png",
                "--width -3: expected a whole number of pixels, 0 or more",
            ),
            (
                "render --frames 0 --out p.png",
                "--frames 0: expected a whole number, 1 or more",
            ),
            (
                "render --width 99999999999 --out p.png",
                "--width 99999999999: the number is too large: expected a smaller whole number of pixels",
            ),
            (
                "compare paper --assume-clock 500MHz",
                "--assume-clock 500MHz: expected a number of GHz; the unit is fixed and not written: \
                 write 0.5",
            ),
            (
                "effects --pairs 100",
                "--pairs 100: expected a whole number, 0 to 99",
            ),
            (
                "warp --config small",
                "--config small: warp uses no configuration: leave it out",
            ),
        ] {
            assert_eq!(said(line), expected, "{line}");
        }
        assert!(said("render --witdh 3 --out p.png").contains("'--width'"));
    }

    #[test]
    fn commands_without_a_configuration_do_not_list_it() {
        let mut cli = prepared(crate::cli::Cli::command());
        cli.build();
        for own in cli.get_subcommands() {
            let is_listed = own
                .get_arguments()
                .any(|flag| flag.get_long() == Some("config") && !flag.is_hide_set());
            let has_use = !WITHOUT_CONFIGURATION.contains(&own.get_name());
            assert!(
                own.get_name() == "help" || is_listed == has_use,
                "{}",
                own.get_name()
            );
        }
    }
}
