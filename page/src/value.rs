//! Values of the document as text: nothing else of a run reaches the page.

use maud::{Markup, html};
use serde_json::Value;

/// How a number is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// About three digits.
    Short,
    /// A whole number with marks between thousands.
    Count,
    /// Two digits behind the point.
    Hundredths,
    /// A share as per cent.
    Percent,
    /// A small number with three digits, in powers of ten where it is below 0.001.
    Small,
}

impl Form {
    const fn name(self) -> &'static str {
        match self {
            Self::Short => "short",
            Self::Count => "count",
            Self::Hundredths => "hundredths",
            Self::Percent => "percent",
            Self::Small => "small",
        }
    }

    #[cfg(test)]
    pub(super) fn named(name: &str) -> Option<Self> {
        let all = [
            Self::Short,
            Self::Count,
            Self::Hundredths,
            Self::Percent,
            Self::Small,
        ];
        all.into_iter().find(|own| own.name() == name)
    }

    pub(super) fn text(self, value: f64) -> String {
        match self {
            Self::Short => potamoi_plots::figures::number(value),
            Self::Count => indicatif::HumanCount(value.max(0.0) as u64).to_string(),
            Self::Hundredths => format!("{value:.2}"),
            Self::Percent => match value {
                1.0 => "100 %".to_owned(),
                value => format!("{:.1} %", 100.0 * value),
            },
            Self::Small => match value {
                0.0 => "0".to_owned(),
                value if value.abs() < 1e-3 => format!("{value:.1e}"),
                value => format!("{value:.3}"),
            },
        }
    }
}

/// A place in the document.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    root: &'a Value,
    own: &'a Value,
}

/// A place with its path from the document's root.
#[derive(Clone)]
pub(super) struct Place<'a> {
    at: At<'a>,
    pointer: String,
}

impl<'a> Place<'a> {
    pub(super) fn root(root: &'a Value) -> Self {
        Self {
            at: At { root, own: root },
            pointer: String::new(),
        }
    }

    /// The value itself, for what is no number.
    pub(super) fn json(&self) -> &'a Value {
        self.at.own
    }

    /// A field, or an element by its number; null where there is none.
    pub(super) fn get(&self, key: &str) -> Self {
        static NONE: Value = Value::Null;
        let pointer = format!(
            "{}/{}",
            self.pointer,
            key.replace('~', "~0").replace('/', "~1")
        );
        let own = self.at.root.pointer(&pointer).unwrap_or(&NONE);
        Self {
            at: At { own, ..self.at },
            pointer,
        }
    }

    /// The elements of a list.
    pub(super) fn all(&self) -> Vec<Self> {
        let count = self.json().as_array().map_or(0, Vec::len);
        (0..count).map(|at| self.get(&at.to_string())).collect()
    }

    pub(super) fn text(&self) -> &'a str {
        self.json().as_str().unwrap_or("-")
    }

    pub(super) fn is_null(&self) -> bool {
        self.json().is_null()
    }

    pub(super) fn is_true(&self) -> bool {
        self.json().as_bool() == Some(true)
    }

    /// Why a value is not there, if it says so.
    pub(super) fn unknown(&self) -> Option<&'a str> {
        self.json()["unknown"].as_str()
    }

    /// The number, or a dash.
    pub(super) fn number(&self, form: Form) -> Markup {
        match self.json().as_f64() {
            None => html! { "-" },
            Some(value) => html! {
                data value=(self.json().to_string()) data-of=(self.pointer) data-as=(form.name()) {
                    (form.text(value))
                }
            },
        }
    }

    /// A figure at both bounds: from the lower to the higher, one number where they read alike.
    pub(super) fn range(&self) -> Markup {
        let [max, sum] = ["max", "sum"].map(|bound| self.get(bound));
        let value = |of: &Place<'_>| of.json().as_f64();
        match (value(&max), value(&sum)) {
            (Some(a), Some(b)) => {
                let (low, high) = if a <= b { (max, sum) } else { (sum, max) };
                match Form::Short.text(a) == Form::Short.text(b) {
                    true => low.number(Form::Short),
                    false => html! { (low.number(Form::Short)) " to " (high.number(Form::Short)) },
                }
            }
            _ => html! { "-" },
        }
    }
}
