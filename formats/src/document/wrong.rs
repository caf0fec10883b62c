//! Errors of documents, in a user's words.

use std::fmt;

use serde::de::{Error, Expected, Unexpected};

use crate::nearest::nearest;

/// A step from a value to a part of it.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Step {
    Key(String),
    Index(usize),
}

/// An error with its position in the document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    /// Path from the value outwards.
    steps: Vec<Step>,
    problem: String,
}

/// Longest quoted problem, and longest key, in characters.
const TOLD: usize = 300;
const TOLD_KEY: usize = 60;
/// How the problem of an unknown key begins.
const NO_FIELD: &str = "no such field here";
/// How a suggestion begins.
const MEANT: &str = "; did you mean `";

impl Wrong {
    /// An error of a value as a whole.
    #[must_use]
    pub fn new(problem: impl Into<String>) -> Self {
        let problem: String = problem.into();
        Self {
            steps: vec![],
            problem: problem.chars().take(TOLD).collect(),
        }
    }

    /// An error of a value found instead of another.
    #[must_use]
    pub fn found(found: impl fmt::Display, expected: impl fmt::Display) -> Self {
        Self::new(format!("found {found}, expected {expected}"))
    }

    /// A text that is none of some names.
    #[must_use]
    pub fn unknown_value(found: &str, known: &[&str]) -> Self {
        let cut: String = found.chars().take(TOLD_KEY).collect();
        // A list of known names is never cut.
        Self {
            steps: vec![],
            problem: format!(
                "found \"{cut}\", expected {}{}",
                listed(known),
                meant(found, known)
            ),
        }
    }

    /// A key that is none of some names.
    #[must_use]
    pub fn unknown_key(found: &str, known: &[&str]) -> Self {
        let own = Self {
            steps: vec![],
            problem: format!(
                "{NO_FIELD}: expected {}{}",
                listed(known),
                meant(found, known)
            ),
        };
        own.under(found)
    }

    /// The error of an unknown key, where more keys are known than those that it lists. Other errors stay as
    /// they are.
    #[must_use]
    pub fn with_known(self, more: &[&str]) -> Self {
        let list = self.problem.strip_prefix(NO_FIELD);
        let list = list.and_then(|own| own.strip_prefix(": expected "));
        let (Some(list), Some(Step::Key(key))) = (list, self.steps.first()) else {
            return self;
        };
        let list = list.split(MEANT).next().unwrap_or_default();
        let list = list.strip_prefix("one of ").unwrap_or(list);
        let own = list.split(", ").map(|own| own.trim_matches('`'));
        let known: Vec<&str> = own
            .filter(|own| *own != "none")
            .chain(more.iter().copied())
            .collect();
        let problem = Self::unknown_key(key, &known).problem;
        Self { problem, ..self }
    }

    /// The error seen from the map that holds its value under `key`.
    #[must_use]
    pub fn under(mut self, key: &str) -> Self {
        let key = key.chars().take(TOLD_KEY).collect();
        self.steps.push(Step::Key(key));
        self
    }

    /// The error seen from the list that holds its value at `index`, from 0.
    #[must_use]
    pub fn at(mut self, index: usize) -> Self {
        self.steps.push(Step::Index(index));
        self
    }

    /// The problem without the name that may have been meant.
    #[must_use]
    pub fn without_suggestion(&self) -> &str {
        self.problem.split(MEANT).next().unwrap_or_default()
    }

    /// The error with one word of its problem replaced, where a type's name of a key is not that of
    /// files.
    #[must_use]
    pub fn reworded(mut self, word: &str, by: &str) -> Self {
        self.problem = self.problem.replace(word, by);
        self
    }

    /// Path of the value, such as `frames[3].fl_x`; empty for the whole document.
    #[must_use]
    pub fn field(&self) -> String {
        let mut text = String::new();
        for step in self.steps.iter().rev() {
            match step {
                Step::Index(index) => text += &format!("[{index}]"),
                Step::Key(key) if text.is_empty() => text += key,
                Step::Key(key) => text += &format!(".{key}"),
            }
        }
        text
    }

    /// Whether the value's key is not of its type.
    #[must_use]
    pub fn is_unknown_key(&self) -> bool {
        self.problem.starts_with(NO_FIELD)
    }

    /// The problem.
    #[must_use]
    pub fn problem(&self) -> &str {
        &self.problem
    }
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.steps.is_empty() {
            true => f.write_str(&self.problem),
            false => write!(f, "field `{}`: {}", self.field(), self.problem),
        }
    }
}

impl std::error::Error for Wrong {}

/// A clause with the known name that is nearest to a misspelt one; empty where none is near.
fn meant(found: &str, known: &[&str]) -> String {
    nearest(found, known.iter().copied())
        .map_or_else(String::new, |near| format!("{MEANT}{near}`?"))
}

fn listed(names: &[&str]) -> String {
    match names {
        [] => "none".to_owned(),
        [one] => format!("`{one}`"),
        _ => format!("one of {}", names.join(", ")),
    }
}

/// Wording of serde's derived readers.
impl Error for Wrong {
    fn custom<T: fmt::Display>(message: T) -> Self {
        let message = message.to_string();
        // Serde's own message holds a Rust type and no expectation.
        match message.starts_with("data did not match any variant") {
            true => Self::new("it has none of the forms that it may have"),
            false => Self::new(message),
        }
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::found(kind(found), plain(&expected.to_string()))
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::found(kind(found), plain(&expected.to_string()))
    }

    fn invalid_length(length: usize, _: &dyn Expected) -> Self {
        Self::found(format_args!("{length} values"), "more")
    }

    fn unknown_variant(variant: &str, expected: &'static [&'static str]) -> Self {
        Self::unknown_value(variant, expected)
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        Self::unknown_key(field, expected)
    }

    fn missing_field(field: &'static str) -> Self {
        Self::new("it is missing").under(field)
    }

    fn duplicate_field(field: &'static str) -> Self {
        Self::new("it stands twice: expected once").under(field)
    }
}

fn kind(found: Unexpected<'_>) -> String {
    match found {
        Unexpected::Bool(value) => value.to_string(),
        Unexpected::Unsigned(value) => value.to_string(),
        Unexpected::Signed(value) => value.to_string(),
        Unexpected::Float(value) => format!("{value:?}"),
        Unexpected::Str(text) => format!("\"{}\"", text.chars().take(TOLD_KEY).collect::<String>()),
        Unexpected::Seq => "a list".to_owned(),
        Unexpected::Map => "a section of named values".to_owned(),
        _ => "something else".to_owned(),
    }
}

/// Maximum number of characters of a value in an error.
const SHOWN: usize = 60;

/// A value, shortly: one of a damaged file may be long.
fn short(found: &str) -> String {
    let mut told: String = found.chars().take(SHOWN).collect();
    if told.len() < found.len() {
        told.push('\u{2026}');
    }
    told
}

/// Rewords the error of a lower reader, such as serde's for MessagePack.
#[must_use]
pub fn foreign(said: &str) -> String {
    if let Some(rest) = said.strip_prefix("missing field ") {
        return format!("{rest} is missing");
    }
    if let Some(rest) = said.strip_prefix("duplicate field ") {
        return format!("{rest} stands twice: expected once");
    }
    let both = ["invalid type: ", "invalid value: ", "invalid length "]
        .iter()
        .find_map(|start| said.strip_prefix(start)?.split_once(", expected "));
    if let Some((found, expected)) = both {
        return format!(
            "found {}, expected {}",
            short(&plain(found)),
            plain(expected)
        );
    }
    let lower = said.to_lowercase();
    let known = [
        ("array had incorrect length", "a list has too many values"),
        (
            "wrong msgpack marker",
            "a value of another kind than expected",
        ),
        ("out of range", "a number is out of range"),
        ("depth limit", "it is nested too deeply"),
        ("recursion", "it is nested too deeply"),
        ("recurse", "it is nested too deeply"),
        ("duplicate key", "a key stands twice: expected once"),
        (
            "string values must be quoted",
            "a value is missing, or a text stands without quotation marks",
        ),
        (
            "invalid key-value pair",
            "the line is none of TOML's: expected `key = value` or `[section]`",
        ),
        (
            "unexpected key or value",
            "something follows a value: expected the end of the line",
        ),
        (
            "key with no value",
            "a key has no value: expected `key = value`",
        ),
        ("io error", "the data ends in the middle, or is damaged"),
        ("failed to", "the data ends in the middle, or is damaged"),
    ];
    match known.iter().find(|(part, _)| lower.contains(part)) {
        Some((_, words)) => (*words).to_owned(),
        None => said.to_owned(),
    }
}

/// Names a kind of value in plain words.
fn plain(kind: &str) -> String {
    let first = kind.split(' ').next().unwrap_or_default();
    match first.trim_start_matches('a') {
        _ if kind.starts_with("struct") => "named values".to_owned(),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number from 0 on".to_owned(),
        "i8" | "i16" | "i32" | "i64" => "a whole number".to_owned(),
        "f32" | "f64" => "a number".to_owned(),
        _ => match kind {
            "sequence" | "a sequence" => "a list".to_owned(),
            "map" | "a map" => "named values".to_owned(),
            "a string" => "a text".to_owned(),
            "a boolean" => "true or false".to_owned(),
            "byte array" => "bytes".to_owned(),
            _ => kind
                .replace("string ", "")
                .replace("integer ", "")
                .replace("floating point ", "")
                .replace("boolean ", "")
                .replace("an array of length", "a list of length"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_key_is_led_to_the_nearest() {
        let wrong = Wrong::unknown_key("bnks", &["banks", "ports"]);
        let said = "no such field here: expected one of banks, ports; did you mean `banks`?";
        assert_eq!(wrong.problem(), said);
        let more = Wrong::unknown_key("stp", &["banks"]);
        let more = more.under("render").with_known(&["step"]);
        let said = "field `render.stp`: no such field here: expected one of banks, step; did you mean \
                    `step`?";
        assert_eq!(more.to_string(), said);
        let one = Wrong::unknown_key("x", &["banks"]).with_known(&["ports"]);
        assert_eq!(
            one.problem(),
            "no such field here: expected one of banks, ports"
        );
        let value = Wrong::unknown_value("radix4", &["radix-4", "literal"]);
        let said = "found \"radix4\", expected one of radix-4, literal; did you mean `radix-4`?";
        assert_eq!(value.problem(), said);
        assert_eq!(value.clone().with_known(&["x"]), value);
    }

    #[test]
    fn words_of_other_readers_are_put_into_ours() {
        for (said, ours) in [
            ("missing field `otype`", "`otype` is missing"),
            (
                "duplicate field `otype`",
                "`otype` stands twice: expected once",
            ),
            (
                "invalid type: string \"x\", expected u32",
                "found \"x\", expected a whole number from 0 on",
            ),
            (
                "invalid type: integer `3`, expected a string",
                "found `3`, expected a text",
            ),
            (
                "invalid type: map, expected f64",
                "found named values, expected a number",
            ),
            (
                "invalid type: sequence, expected struct Network",
                "found a list, expected named values",
            ),
            (
                "invalid value: integer `-1`, expected u32",
                "found `-1`, expected a whole number from 0 on",
            ),
            (
                "invalid length 2, expected an array of length 3",
                "found 2, expected a list of length 3",
            ),
            (
                "array had incorrect length, expected 3",
                "a list has too many values",
            ),
            (
                "IO error while reading marker: failed to fill",
                "the data ends in the middle, or is damaged",
            ),
            ("an empty list", "an empty list"),
            (
                "cannot recurse further; max recursion depth met",
                "it is nested too deeply",
            ),
            (
                "key with no value, expected `=`",
                "a key has no value: expected `key = value`",
            ),
        ] {
            assert_eq!(foreign(said), ours);
        }
        let long = format!(
            "invalid type: string \"{}\", expected byte array",
            "x".repeat(9000)
        );
        assert!(foreign(&long).len() < 120, "{}", foreign(&long));
    }
}
