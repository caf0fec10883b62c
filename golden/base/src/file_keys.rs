//! Bookkeeping of a file's keys: each key is honoured, refused or listed.
//!
//! A reader puts the keys of its file into a [`FileKeys`] and takes out those that it uses.
//! [`FileKeys::finish`] treats the rest by the format's table: a key that changes the picture is
//! refused, any other is listed in [`Notes`], which every report prints as "not checked". So no
//! reader can drop a key silently.
//!
//! ```
//! use potamoi_base::file_keys::{Fate, Format, Key, Notes, FileKeys};
//!
//! static FORMAT: Format = Format {
//!     name: "example",
//!     files: "`.example`",
//!     keys: &[
//!         Key { name: "size", fate: Fate::Honoured, about: "edge in metres" },
//!         Key { name: "lens_*", fate: Fate::Refused, about: "only pinholes are rendered" },
//!         Key { name: "author", fate: Fate::Listed, about: "no part of the picture" },
//!     ],
//!     others: Fate::Listed,
//! };
//! let entries = [("size".to_owned(), 2.0), ("author".to_owned(), 0.0)];
//! let mut record = FileKeys::new(&FORMAT, entries);
//! assert_eq!(record.take("size"), Some(2.0));
//! let mut notes = Notes::default();
//! record.finish(&mut notes).unwrap();
//! assert_eq!(notes.not_used(), ["author"]);
//!
//! let bent = FileKeys::new(&FORMAT, [("lens_k1".to_owned(), 0.1)]);
//! let error = bent.finish(&mut notes).unwrap_err().to_string();
//! assert_eq!(error, "`lens_k1` cannot be honoured: only pinholes are rendered");
//! ```

use thiserror::Error;

/// The treatment of a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It is used. The reader refuses invalid values.
    Honoured,
    /// It is one of a family of which every member is used, such as the layers of a
    /// perceptron: one that the reader leaves is refused.
    Whole,
    /// It changes the picture in a way that no renderer here supports. A reader may take it to
    /// accept a value without effect, such as a distortion of 0.
    Refused,
    /// It is not used and does not change the picture; reports name it.
    Listed,
}

impl Fate {
    /// The word for it in the table of formats.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Honoured | Self::Whole => "honoured",
            Self::Refused => "refused",
            Self::Listed => "listed",
        }
    }
}

/// A row of a format's table: a key, or a family of keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    /// Its name; each `*` matches any number of characters.
    pub name: &'static str,
    /// Its treatment.
    pub fate: Fate,
    /// Its meaning, or the reason for refusing it.
    pub about: &'static str,
}

/// A row of a table.
#[must_use]
pub const fn key(name: &'static str, fate: Fate, about: &'static str) -> Key {
    Key { name, fate, about }
}

impl Key {
    fn matches(&self, key: &str) -> bool {
        let mut parts = self.name.split('*');
        let Some(mut rest) = parts.next().and_then(|head| key.strip_prefix(head)) else {
            return false;
        };
        let mut parts = parts.peekable();
        if parts.peek().is_none() {
            return rest.is_empty();
        }
        while let Some(part) = parts.next() {
            if parts.peek().is_none() {
                return rest.ends_with(part);
            }
            match rest.find(part) {
                Some(at) => rest = &rest[at + part.len()..],
                None => return false,
            }
        }
        true
    }
}

/// A file format with its keys.
#[derive(Debug, PartialEq, Eq)]
pub struct Format {
    /// Its usual name.
    pub name: &'static str,
    /// Names of its files, for the table of formats.
    pub files: &'static str,
    /// Its keys. If several match, the first applies.
    pub keys: &'static [Key],
    /// Treatment of keys without a row: refused or listed.
    pub others: Fate,
}

impl Format {
    /// The row that matches a key.
    #[must_use]
    pub fn row(&self, key: &str) -> Option<&'static Key> {
        self.keys.iter().find(|row| row.matches(key))
    }
}

/// A key that cannot be honoured.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum KeyError {
    /// The row of the key refuses it.
    #[error("`{key}` cannot be honoured: {why}{}", valued(value.as_deref()))]
    Refused {
        /// The key.
        key: String,
        /// Its value, shortened, if it can be shown.
        value: Option<String>,
        /// The reason, and a remedy.
        why: &'static str,
    },
    /// A numbered key beyond a gap in its sequence, or one that leaves a member incomplete.
    #[error(
        "`{key}` is out of sequence ({about}): expected parts that are numbered without a gap, \
         each complete"
    )]
    Left {
        /// The key.
        key: String,
        /// Meaning of the numbered keys.
        about: &'static str,
    },
    /// The format has no such key.
    #[error("`{key}` is not a key of {format}: expected {expected}")]
    Unknown {
        /// The key.
        key: String,
        /// The format.
        format: &'static str,
        /// The keys of the format.
        expected: String,
    },
}

fn valued(value: Option<&str>) -> String {
    value.map_or_else(String::new, |value| format!("; its value is {value}"))
}

/// Unused keys of files, and assumptions for missing ones.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Notes {
    not_used: Vec<String>,
    assumed: Vec<String>,
}

/// Maximum length of a key in messages, in characters.
const TOLD: usize = 60;

/// A name from a file, shortened, since names and values in a damaged file can be long.
pub fn told(text: &str) -> String {
    told_within(text, TOLD)
}

/// A text shortened to at most `most` characters.
pub fn told_within(text: &str, most: usize) -> String {
    let mut told: String = text.chars().take(most).collect();
    if told.len() < text.len() {
        told.push('\u{2026}');
    }
    told
}

impl Notes {
    /// Adds an unused key or part of one.
    pub fn list(&mut self, key: impl Into<String>) {
        let key: String = key.into();
        if !self.not_used.contains(&key) {
            self.not_used.push(key);
        }
    }

    /// Adds an assumption, for instance "axes: right, down, front".
    pub fn assume(&mut self, what: impl Into<String>) {
        let what: String = what.into();
        if !self.assumed.contains(&what) {
            self.assumed.push(what);
        }
    }

    /// Adds the notes of another file.
    pub fn extend(&mut self, other: Self) {
        other.not_used.into_iter().for_each(|key| self.list(key));
        other.assumed.into_iter().for_each(|what| self.assume(what));
    }

    /// The notes of a part of a file, with `prefix` before the keys.
    #[must_use]
    pub fn under(self, prefix: &str) -> Self {
        let told = |key| format!("{prefix}{key}");
        Self {
            not_used: self.not_used.into_iter().map(told).collect(),
            ..self
        }
    }

    /// The notes of a file other than the scene's, with its name before keys and assumptions.
    #[must_use]
    pub fn of_file(self, path: &std::path::Path) -> Self {
        let name = path.file_name().unwrap_or(path.as_os_str());
        let prefix = format!("{}: ", name.display());
        let told = |what| format!("{prefix}{what}");
        let assumed = self.assumed.iter().map(told).collect();
        Self {
            assumed,
            ..self.under(&prefix)
        }
    }

    /// Unused keys.
    #[must_use]
    pub fn not_used(&self) -> &[String] {
        &self.not_used
    }

    /// Assumptions.
    #[must_use]
    pub fn assumed(&self) -> &[String] {
        &self.assumed
    }

    /// At most two sentences for reports: all assumptions, and all unused keys.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let mut all = vec![];
        if !self.assumed.is_empty() {
            all.push(format!("assumed of the file: {}", self.assumed.join(", ")));
        }
        if !self.not_used.is_empty() {
            all.push(format!(
                "not used of the file: {}",
                self.not_used.join(", ")
            ));
        }
        all
    }
}

/// The keys of a file that no reader has taken yet, with their values.
#[derive(Debug)]
pub struct FileKeys<V> {
    format: &'static Format,
    left: Vec<(String, V)>,
}

impl<V> FileKeys<V> {
    /// All keys of a file, in its order. Of two equal keys the reader sees the first; the second
    /// remains and is treated by the table.
    pub fn new(format: &'static Format, entries: impl IntoIterator<Item = (String, V)>) -> Self {
        Self {
            format,
            left: entries.into_iter().collect(),
        }
    }

    /// Adds a key after the others.
    pub fn add(&mut self, key: String, value: V) {
        self.left.push((key, value));
    }

    /// Whether a key is present and not taken.
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        self.left.iter().any(|(name, _)| name == key)
    }

    /// The value of a key that is present and not taken, without taking it.
    #[must_use]
    pub fn peek(&self, key: &str) -> Option<&V> {
        let found = self.left.iter().find(|(name, _)| name == key);
        found.map(|(_, value)| value)
    }

    /// Keys that are present and not taken.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.left.iter().map(|(name, _)| name.as_str())
    }

    /// Takes the value of a key, which must have a row in the format's table.
    pub fn take(&mut self, key: &str) -> Option<V> {
        debug_assert!(
            self.format.row(key).is_some(),
            "{} has no row for `{key}`",
            self.format.name
        );
        let at = self.left.iter().position(|(name, _)| name == key)?;
        Some(self.left.remove(at).1)
    }

    /// Takes refused keys whose values have no effect.
    pub fn take_neutral(&mut self, is_neutral: impl Fn(&V) -> bool) {
        let refused = |key: &str| {
            self.format
                .row(key)
                .is_some_and(|r| r.fate == Fate::Refused)
        };
        self.left
            .retain(|(key, value)| !(refused(key) && is_neutral(value)));
    }

    /// Treats the remaining keys by the table, and lists them in `notes` without values.
    ///
    /// # Errors
    /// The first key that is refused.
    pub fn finish(self, notes: &mut Notes) -> Result<(), KeyError> {
        self.finish_valued(notes, |_| None)
    }

    /// As [`FileKeys::finish`]; `shown` formats the value of a key that is refused.
    ///
    /// # Errors
    /// The first key that is refused.
    pub fn finish_valued(
        self,
        notes: &mut Notes,
        shown: impl Fn(&V) -> Option<String>,
    ) -> Result<(), KeyError> {
        for (key, value) in self.left {
            let told = told(&key);
            match self.format.row(&key) {
                Some(row) if row.fate == Fate::Refused => {
                    return Err(KeyError::Refused {
                        key: told,
                        value: shown(&value).map(|value| self::told(&value)),
                        why: row.about,
                    });
                }
                Some(row) if row.fate == Fate::Whole => {
                    let about = row.about;
                    return Err(KeyError::Left { key: told, about });
                }
                None if self.format.others == Fate::Refused => {
                    let names: Vec<_> = self.format.keys.iter().map(|row| row.name).collect();
                    return Err(KeyError::Unknown {
                        key: told,
                        format: self.format.name,
                        expected: names.join(", "),
                    });
                }
                _ => notes.list(told),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const KEYS: &[Key] = &[
        key("x", Fate::Honoured, "a reason"),
        key("rest_*", Fate::Honoured, "a reason"),
        key("k_*_end", Fate::Refused, "a reason"),
        key("note", Fate::Listed, "a reason"),
        key("layer.*", Fate::Whole, "a reason"),
    ];
    static OPEN: Format = Format {
        name: "open",
        files: "",
        keys: KEYS,
        others: Fate::Listed,
    };
    static CLOSED: Format = Format {
        name: "closed",
        files: "",
        keys: KEYS,
        others: Fate::Refused,
    };

    fn finished(format: &'static Format, keys: &[&str]) -> Result<Notes, KeyError> {
        let mut record = FileKeys::new(format, keys.iter().map(|k| ((*k).to_owned(), ())));
        record.take("x");
        let mut notes = Notes::default();
        record.finish(&mut notes).map(|()| notes)
    }

    #[test]
    fn every_key_is_taken_listed_or_refused() {
        let listed = finished(&OPEN, &["x", "rest_1", "note", "new"]).unwrap();
        assert_eq!(listed.not_used(), ["rest_1", "note", "new"]);
        assert!(finished(&OPEN, &["x"]).unwrap().sentences().is_empty());
        for format in [&OPEN, &CLOSED] {
            let error = finished(format, &["note", "k_7_end"]).unwrap_err();
            let (why, value) = ("a reason", None);
            let key = "k_7_end".to_owned();
            assert_eq!(error, KeyError::Refused { key, value, why });
            let error = finished(format, &["layer.2"]).unwrap_err();
            let (key, about) = ("layer.2".to_owned(), "a reason");
            assert_eq!(error, KeyError::Left { key, about });
        }
        let record = FileKeys::new(&OPEN, [("k_7_end".to_owned(), 7)]);
        let error = record.finish_valued(&mut Notes::default(), |v| Some(v.to_string()));
        let expected = "`k_7_end` cannot be honoured: a reason; its value is 7";
        assert_eq!(error.unwrap_err().to_string(), expected);
        let error = finished(&CLOSED, &["x", "new"]).unwrap_err().to_string();
        let expected = "`new` is not a key of closed: expected x, rest_*, k_*_end, note, layer.*";
        assert_eq!(error, expected);
    }

    #[test]
    fn the_second_of_two_alike_is_judged() {
        assert_eq!(finished(&OPEN, &["x", "x"]).unwrap().not_used(), ["x"]);
    }

    #[test]
    fn stars_stand_for_any_characters_but_do_not_overlap() {
        assert!(KEYS[2].matches("k__end") && !KEYS[2].matches("k_end"));
        assert!(KEYS[1].matches("rest_") && !KEYS[1].matches("rest"));
        let both = key("*mid*end", Fate::Listed, "a reason");
        assert!(both.matches("midend") && both.matches("a mid b end"));
        assert!(!both.matches("end mid") && !both.matches("mid"));
        let all = key("*mid*", Fate::Listed, "a reason");
        assert!(all.matches("mid") && all.matches("a mid b") && !all.matches("mi d"));
    }

    #[test]
    fn values_that_change_nothing_are_taken_of_refused_keys_alone() {
        let entries = [("k_1_end", 0), ("k_2_end", 7), ("note", 0), ("new", 0)];
        let entries = entries.map(|(key, value)| (key.to_owned(), value));
        let mut record = FileKeys::new(&OPEN, entries);
        record.take_neutral(|value| *value == 0);
        let left: Vec<_> = record.keys().collect();
        assert_eq!(left, ["k_2_end", "note", "new"]);
    }

    #[test]
    fn long_keys_are_cut_and_each_is_named() {
        let keys: Vec<_> = (0..100)
            .map(|i| format!("{i}{}", "k".repeat(500)))
            .collect();
        let keys: Vec<_> = keys.iter().map(String::as_str).collect();
        let said = finished(&OPEN, &keys).unwrap().sentences().join("");
        assert!(said.len() < 100 * 68, "{said}");
        assert_eq!(said.matches(", ").count(), 99);
    }
}
