//! Constants with their origins.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where a constant comes from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// The publication that states it, or that it follows from.
    Source(String),
    /// Why it is assumed.
    Assumed(String),
    /// Why it is not known.
    Unknown(String),
}

impl Origin {
    /// Its kind in a word.
    #[must_use]
    pub const fn word(&self) -> &'static str {
        match self {
            Self::Source(_) => "published",
            Self::Assumed(_) => "assumed",
            Self::Unknown(_) => "unknown",
        }
    }

    /// The publication or the reason.
    #[must_use]
    pub fn text(&self) -> &str {
        match self {
            Self::Source(text) | Self::Assumed(text) | Self::Unknown(text) => text,
        }
    }
}

/// A constant.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Constant {
    /// Its value; `None` where it is unknown.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// Where it comes from.
    pub origin: Origin,
}

/// A constant as a file has it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Entry {
    value: Option<f64>,
    unit: String,
    source: Option<String>,
    assumed: Option<String>,
    unknown: Option<String>,
}

impl Entry {
    /// The constant, or what is wrong with it.
    pub(crate) fn read(self) -> Result<Constant, String> {
        let origin = match (self.source, self.assumed, self.unknown) {
            (Some(text), None, None) => Origin::Source(text),
            (None, Some(text), None) => Origin::Assumed(text),
            (None, None, Some(text)) => Origin::Unknown(text),
            _ => return Err("expected one of `source`, `assumed` and `unknown`".to_owned()),
        };
        if origin.text().trim().is_empty() || self.unit.trim().is_empty() {
            return Err("expected a unit and the text of its origin".to_owned());
        }
        match (self.value, &origin) {
            (None, Origin::Unknown(_)) => {}
            (Some(value), Origin::Source(_) | Origin::Assumed(_)) if value > 0.0 => {
                if !value.is_finite() {
                    return Err(format!("{value} is not finite"));
                }
            }
            (None, _) => return Err("expected a `value`, or why it is `unknown`".to_owned()),
            (Some(value), Origin::Unknown(_)) => {
                return Err(format!(
                    "{value} is unknown: remove the value or name its origin"
                ));
            }
            (Some(value), _) => return Err(format!("{value}: expected a value above 0")),
        }
        Ok(Constant {
            value: self.value,
            unit: self.unit,
            origin,
        })
    }
}
