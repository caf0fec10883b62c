//! Broken rules of a configuration.

use std::fmt;

/// One broken rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RuleBreach {
    /// The rule's name.
    pub rule: &'static str,
    /// The field, as a TOML path.
    pub field: &'static str,
    /// The value in the configuration.
    pub value: String,
    /// The allowed values, and the reason.
    pub expected: String,
}

/// Broken rules in the order of their fields.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RuleBreaches(pub Vec<RuleBreach>);

impl RuleBreaches {
    /// Whether no rule is broken.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn require(
        &mut self,
        kept: bool,
        rule: &'static str,
        field: &'static str,
        value: impl fmt::Display,
        expected: impl fmt::Display,
    ) {
        if !kept {
            self.0.push(RuleBreach {
                rule,
                field,
                value: value.to_string(),
                expected: expected.to_string(),
            });
        }
    }

    pub(super) fn range(
        &mut self,
        rule: &'static str,
        field: &'static str,
        value: u32,
        low: u32,
        high: u32,
        why: &str,
    ) {
        self.require(
            (low..=high).contains(&value),
            rule,
            field,
            value,
            format_args!("{low} to {high}: {why}"),
        );
    }
}

impl fmt::Display for RuleBreach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "rule `{}`: {} = {}; expected {}",
            self.rule, self.field, self.value, self.expected
        )
    }
}

impl fmt::Display for RuleBreaches {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, breach) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{breach}")?;
        }
        Ok(())
    }
}
