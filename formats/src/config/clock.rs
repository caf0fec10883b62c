//! The clock's key: GHz in files, MHz in a [`Config`].

use super::Config;
use crate::document::{Value, Wrong};

/// Key of the clock in files.
const KEY: &str = "clock_ghz";
/// Its key in the previous version, in MHz; also the name of the field.
const OLD: &str = "clock_mhz";
/// Largest clock that is converted, in GHz; [`super::rules`] have the range.
const MOST: f64 = 1e6;

/// A document with the clock in MHz, as the type has it, and a note where a file has the old key.
///
/// # Errors
/// Both keys, or a clock that is no multiple of 0.001 GHz.
pub(super) fn in_mhz(document: Value) -> Result<(Value, Option<String>), Wrong> {
    let note = document
        .get(OLD)
        .map(|_| format!("`{OLD}` is now `{KEY}`, in GHz; the old key goes with the next version"));
    let Value::Map(entries) = document else {
        return Ok((document, note));
    };
    let mut entries = entries.into_vec();
    if let Some((key, value)) = entries.iter_mut().find(|(key, _)| **key == *KEY) {
        let wrong = |found: String| {
            let expected = "a multiple of 0.001 GHz, such as 1.0";
            Wrong::found(found, expected).under(KEY)
        };
        if note.is_some() {
            let found = format!("`{OLD}`, its old name, beside it");
            let expected = format!("one of both: remove `{OLD}`");
            return Err(Wrong::found(found, &expected).under(KEY));
        }
        let ghz = value.number().ok_or_else(|| wrong(value.shown()))?;
        let mhz = (1e3 * ghz).round();
        if !(0.0..=MOST).contains(&ghz) || (1e3 * ghz - mhz).abs() > 1e-6 {
            return Err(wrong(value.shown()));
        }
        (*key, *value) = (OLD.into(), Value::Int(mhz as i64));
    }
    Ok((Value::Map(entries.into()), note))
}

/// The error of a document in the names of files: a list of keys has the new one.
pub(super) fn in_names_of_files(wrong: Wrong) -> Wrong {
    wrong.reworded(&format!("one of {OLD}"), &format!("one of {KEY}"))
}

impl Config {
    /// Assumed clock in GHz; `None`: the clock that synthesis reaches.
    #[must_use]
    pub fn clock_ghz(&self) -> Option<f64> {
        Some(f64::from(self.clock_mhz?) / 1e3)
    }

    /// All of it as TOML for [`Config::from_toml`].
    ///
    /// # Errors
    /// None known: every field has a form in TOML.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        let text = toml::to_string(self)?;
        let Some((mhz, ghz)) = self.clock_mhz.zip(self.clock_ghz()) else {
            return Ok(text);
        };
        let [old, new] = [format!("{OLD} = {mhz}\n"), format!("{KEY} = {ghz:?}\n")];
        Ok(text.replacen(&old, &new, 1))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::document;

    #[test]
    fn a_clock_is_read_and_written_in_ghz() {
        for (text, mhz) in [("1.0", 1000), ("1", 1000), ("0.333", 333), ("2.05", 2050)] {
            let config = Config::from_toml(&format!("clock_ghz = {text}"), "c").unwrap();
            assert_eq!(config.clock_mhz, Some(mhz), "{text}");
            let again = config.to_toml().unwrap();
            assert!(
                again.starts_with("clock_ghz = ") && !again.contains(OLD),
                "{again}"
            );
            assert_eq!(Config::from_toml(&again, "again").unwrap(), config);
        }
    }

    /// A configuration without the key has the clock that is reached; the hardware is the same.
    #[test]
    fn an_assumed_clock_changes_no_hardware() {
        let [own, assumed] = ["", "clock_ghz = 0.7"].map(|t| Config::from_toml(t, "c").unwrap());
        assert_eq!((own.clock_ghz(), assumed.clock_ghz()), (None, Some(0.7)));
        assert!(!own.to_toml().unwrap().contains("clock_ghz"));
        assert_eq!(own.hash(), assumed.hash());
        assert_eq!(assumed.without_clock(), own);
    }

    #[test]
    fn the_old_key_is_accepted_with_a_note() {
        let read = |text: &str| in_mhz(document::toml(text.as_bytes()).unwrap()).unwrap().1;
        assert!(read("clock_mhz = 500").unwrap().contains("`clock_ghz`"));
        assert_eq!(read("clock_ghz = 0.5"), None);
        let [old, new] = ["clock_mhz = 500", "clock_ghz = 0.5"]
            .map(|text| Config::from_toml(text, "c").unwrap());
        assert_eq!(old, new);
        assert_eq!(old.hash(), new.hash());
    }

    #[test]
    fn a_wrong_clock_is_named() {
        for (text, said) in [
            ("clock_ghz = 1.0\nclock_mhz = 1000", "remove `clock_mhz`"),
            ("clock_ghz = 1.0005", "1.0005"),
            ("clock_ghz = -1", "-1"),
            ("clock_ghz = nan", "NaN"),
            ("clock_ghz = \"fast\"", "fast"),
            ("[mft]\nrows = 3", "expected one of clock_ghz, mvoxel"),
            ("clock_ghz = 0", "clock_ghz = 0"),
            ("clock_ghz = 11", "0.001 to 10"),
        ] {
            let error = Config::from_toml(text, "c.toml").unwrap_err().to_string();
            assert!(
                error.contains("clock_ghz") && error.contains(said),
                "{error}"
            );
        }
    }
}
