//! Errors of documents, in a user's words.

use std::fmt;

use serde::de::{Error, Expected, Unexpected};

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
        Self::found(format_args!("\"{variant}\""), listed(expected))
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        Self::new(format!("no such field here: expected {}", listed(expected))).under(field)
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
