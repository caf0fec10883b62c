//! Overlays of configurations, as TOML.

use super::{Config, ConfigError};
use crate::document::Wrong;

/// Changes of a configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layer<'a> {
    /// Fields of `vu.exp` that are reset to their derived values.
    pub derived: &'a [&'a str],
    /// Fields with their values.
    pub toml: &'a str,
}

/// Merges `given` into `all`, table by table; given values win.
pub fn overlay(all: &mut toml::Table, given: toml::Table) {
    for (key, value) in given {
        match (all.get_mut(&key), value) {
            (Some(toml::Value::Table(own)), toml::Value::Table(value)) => overlay(own, value),
            (_, value) => {
                all.insert(key, value);
            }
        }
    }
}

impl Config {
    /// The configuration with layers applied in order; `origin` names the result in errors.
    ///
    /// # Errors
    /// As [`Config::from_toml`] for the result.
    pub fn with(&self, layers: &[Layer<'_>], origin: &str) -> Result<Self, ConfigError> {
        let parse = |problem: String| ConfigError::parse(origin, &Wrong::new(problem));
        let own = self.to_toml().map_err(|e| parse(e.to_string()))?;
        let mut all: toml::Table = own
            .parse()
            .map_err(|e: toml::de::Error| parse(e.to_string()))?;
        for Layer { derived, toml } in layers {
            let exp = all.get_mut("vu").and_then(|vu| vu.get_mut("exp"));
            if let Some(exp) = exp.and_then(toml::Value::as_table_mut) {
                exp.retain(|key, _| !derived.contains(&key));
            }
            let given: toml::Table = toml
                .parse()
                .map_err(|e: toml::de::Error| parse(e.message().to_owned()))?;
            overlay(&mut all, given);
        }
        let text = toml::to_string(&all).map_err(|e| parse(e.to_string()))?;
        Self::from_toml(&text, origin)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::config::PRESETS;

    #[test]
    fn tables_are_laid_part_by_part() {
        let mut all: toml::Table = "a = 1\n[t]\nb = 2\nc = 3".parse().unwrap();
        overlay(&mut all, "d = 4\n[t]\nc = 5".parse().unwrap());
        assert_eq!(all, "a = 1\nd = 4\n[t]\nb = 2\nc = 5".parse().unwrap());
    }

    #[test]
    fn layers_change_what_they_name_and_give_widths_back() {
        let mut fixed = Config::paper();
        fixed.vu.exp.accumulator_bits = Some(22);
        let tail = Layer {
            derived: &["accumulator_bits"],
            toml: "[vu.exp]\niterations = 9\ntail = true",
        };
        let twice = Layer {
            derived: &[],
            toml: "[vu.exp]\niterations = 10",
        };
        let made = fixed.with(&[tail, twice], "test").unwrap();
        let mut expected = Config::paper();
        (expected.vu.exp.iterations, expected.vu.exp.tail) = (10, true);
        assert_eq!(made, expected);
        let wrong = Layer {
            derived: &[],
            toml: "[gu]\nbanks = 0",
        };
        let error = fixed.with(&[wrong], "test").unwrap_err().to_string();
        assert!(
            error.contains("test") && error.contains("gu.banks"),
            "{error}"
        );
    }

    #[test]
    fn what_is_written_is_read_again() {
        for (name, text) in PRESETS {
            let config = Config::from_toml(text, name).unwrap();
            let again = Config::from_toml(&config.to_toml().unwrap(), name).unwrap();
            assert_eq!(again, config, "{name}");
        }
    }
}
