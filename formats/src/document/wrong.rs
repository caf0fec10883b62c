//! What is wrong with a document, in a user's words.

use std::fmt;

use serde::de::{Error, Expected, Unexpected};

/// A step from a value to a part of it.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Step {
    Key(String),
    Index(usize),
}

/// What is wrong, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    /// From the part outwards.
    steps: Vec<Step>,
    problem: String,
}

/// Characters of a problem, and of a key, that are told.
const TOLD: usize = 300;
const TOLD_KEY: usize = 60;

impl Wrong {
    /// Of a value as a whole.
    #[must_use]
    pub fn new(problem: impl Into<String>) -> Self {
        let problem: String = problem.into();
        Self {
            steps: vec![],
            problem: problem.chars().take(TOLD).collect(),
        }
    }

    /// A value in the place of another.
    #[must_use]
    pub fn found(found: impl fmt::Display, expected: impl fmt::Display) -> Self {
        Self::new(format!("found {found}, expected {expected}"))
    }

    /// The same of the value that has this one under a name.
    #[must_use]
    pub fn under(mut self, key: &str) -> Self {
        let key = key.chars().take(TOLD_KEY).collect();
        self.steps.push(Step::Key(key));
        self
    }

    /// The same of the list that has this one at a place, from 0.
    #[must_use]
    pub fn at(mut self, index: usize) -> Self {
        self.steps.push(Step::Index(index));
        self
    }

    /// Where it is, such as `frames[3].fl_x`; empty of the whole.
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

    /// What is wrong there.
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

/// The words of readers that serde derives.
impl Error for Wrong {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(message.to_string())
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::found(kind(found), expected)
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::found(kind(found), expected)
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
