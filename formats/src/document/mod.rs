//! Documents of named values (TOML and JSON files): one path from bytes to types, and one place for
//! the wording of errors.
//!
//! A document is read into a [`Value`], of which every key is once and in the file's order, and a
//! type is made of it by [`Value::read`]. More than serde's derived readers do by themselves:
//!
//! - a list has exactly as many values as its type has places;
//! - a key that its type does not have is refused, at every depth;
//! - whole numbers may be written `640.0` or `6.4e2`, and 640.5 is none;
//! - a number that its type cannot hold is refused;
//! - a byte-order mark, and Latin-1 in comments, do no harm.
//!
//! ```
//! use potamoi_formats::document;
//!
//! #[derive(serde::Deserialize)]
//! struct Size { sides: [u32; 2] }
//!
//! let size: Size = document::json(b"{\"sides\": [640.0, 480]}").unwrap().read().unwrap();
//! assert_eq!(size.sides, [640, 480]);
//! let wrong = document::toml(b"sides = [640, 480, 9]").unwrap().read::<Size>();
//! let wrong = wrong.err().unwrap().to_string();
//! assert_eq!(wrong, "field `sides`: found 3 values, expected 2");
//! ```

mod build;
mod decode;
#[cfg(test)]
mod tests;
mod wrong;

use std::fmt::Write as _;

use serde::Deserialize;

pub use build::{json, of_toml, to_toml, toml};
pub use wrong::{Wrong, foreign};

/// Longest quoted value in an error, in characters.
const TOLD: usize = 60;

/// A value of a document.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Null; JSON only.
    Null,
    /// A Boolean.
    Bool(bool),
    /// A number without a decimal point.
    Int(i64),
    /// A number above 2^63.
    Large(u64),
    /// A number with a decimal point or an exponent.
    Float(f64),
    /// A string.
    Text(Box<str>),
    /// A list.
    List(Box<[Value]>),
    /// Values by unique name, in the file's order.
    Map(Box<[(Box<str>, Value)]>),
}

impl Value {
    /// Deserialises a type.
    ///
    /// # Errors
    /// It is of another kind, or a part of it is missing, superfluous, unknown or out of range.
    pub fn read<'de, T: Deserialize<'de>>(&'de self) -> Result<T, Wrong> {
        T::deserialize(self)
    }

    /// The value of a name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Self> {
        let Self::Map(entries) = self else {
            return None;
        };
        let found = entries.iter().find(|(key, _)| **key == *name);
        found.map(|(_, value)| value)
    }

    /// The document in which one value stands at a path, such as `vu.lanes`, and nothing else.
    #[must_use]
    pub fn at(self, path: &str) -> Self {
        let parts = path.rsplit('.');
        parts.fold(self, |own, part| Self::Map([(part.into(), own)].into()))
    }

    /// The value at a path, such as `vu.lanes`.
    #[must_use]
    pub fn find(&self, path: &str) -> Option<&Self> {
        path.split('.').try_fold(self, |own, part| own.get(part))
    }

    /// The same document without the value at a path.
    #[must_use]
    pub fn without(self, path: &str) -> Self {
        let Self::Map(entries) = self else {
            return self;
        };
        let (first, rest) = match path.split_once('.') {
            Some((first, rest)) => (first, Some(rest)),
            None => (path, None),
        };
        let kept = entries.into_iter().filter_map(|(key, own)| match rest {
            _ if *key != *first => Some((key, own)),
            Some(rest) => Some((key, own.without(rest))),
            None => None,
        });
        Self::Map(kept.collect())
    }

    /// Merges this value over a base, section by section; its values win.
    #[must_use]
    pub fn over(self, base: Self) -> Self {
        match (self, base) {
            (Self::Map(own), Self::Map(base)) => {
                let mut all = base.into_vec();
                for (key, value) in own {
                    match all.iter_mut().find(|(known, _)| *known == key) {
                        None => all.push((key, value)),
                        Some((_, under)) => {
                            let base = std::mem::replace(under, Self::Null);
                            *under = value.over(base);
                        }
                    }
                }
                Self::Map(all.into())
            }
            (own, _) => own,
        }
    }

    /// The first key of this document that is missing in `kept`, the serialised form of a type read
    /// from it. Detects types whose reader silently skips keys.
    #[must_use]
    pub fn lost_in(&self, kept: &Self) -> Option<Wrong> {
        match (self, kept) {
            (Self::Map(own), _) => own.iter().find_map(|(key, value)| {
                let lost = match kept.get(key) {
                    None if *value == Self::Null => None,
                    None => Some(Wrong::new("no such field here")),
                    Some(kept) => value.lost_in(kept),
                };
                lost.map(|wrong| wrong.under(key))
            }),
            (Self::List(own), Self::List(kept)) => {
                let mut pairs = own.iter().zip(kept).enumerate();
                pairs.find_map(|(at, (own, kept))| own.lost_in(kept).map(|wrong| wrong.at(at)))
            }
            _ => None,
        }
    }

    /// The number, if it is one.
    #[must_use]
    pub const fn number(&self) -> Option<f64> {
        match self {
            Self::Int(value) => Some(*value as f64),
            Self::Large(value) => Some(*value as f64),
            Self::Float(value) => Some(*value),
            _ => None,
        }
    }

    /// The whole number in any notation, if it is one.
    #[must_use]
    pub fn whole(&self) -> Option<i128> {
        match self {
            Self::Int(value) => Some((*value).into()),
            Self::Large(value) => Some((*value).into()),
            // Past 2^64 no type here has room.
            Self::Float(value) if value.fract() == 0.0 && value.abs() <= 2f64.powi(64) => {
                Some(*value as i128)
            }
            _ => None,
        }
    }

    /// The text, if it is one.
    #[must_use]
    pub const fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The list, if it is one.
    #[must_use]
    pub const fn list(&self) -> Option<&[Self]> {
        match self {
            Self::List(values) => Some(values),
            _ => None,
        }
    }

    /// Text of the value in messages.
    #[must_use]
    pub fn shown(&self) -> String {
        match self {
            Self::Null => "null".to_owned(),
            Self::Bool(value) => value.to_string(),
            Self::Int(value) => value.to_string(),
            Self::Large(value) => value.to_string(),
            Self::Float(value) => format!("{value:?}"),
            Self::Text(text) => {
                let cut: String = text.chars().take(TOLD).collect();
                format!("\"{cut}\"")
            }
            Self::List(values) => match self.numbers() {
                Some(numbers) => numbers,
                None => format!("a list of {}", values.len()),
            },
            Self::Map(_) => "a section of named values".to_owned(),
        }
    }

    /// A short list of numbers, written out.
    fn numbers(&self) -> Option<String> {
        let values = self.list().filter(|values| values.len() <= 4)?;
        let mut text = "[".to_owned();
        for (at, value) in values.iter().enumerate() {
            value.number()?;
            let comma = if at == 0 { "" } else { ", " };
            // Writing to a text does not fail.
            let _ = write!(text, "{comma}{}", value.shown());
        }
        Some(text + "]")
    }
}
