//! Errors of a snapshot's fields.

/// An invalid field: its name, its value, and the allowed values.
pub(super) struct Wrong {
    pub(super) field: String,
    pub(super) found: String,
    pub(super) expected: String,
}

/// Refuses NaN and infinity.
pub(super) fn finite(values: &[f32], field: &str) -> Result<(), Wrong> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(at) => {
            let found = format!("{} at number {at}", values[at]);
            let expected = "finite numbers alone: training has failed, or the file is damaged";
            check(false, field, found, expected)
        }
    }
}

/// Whether an optional text is absent or equals `wanted`.
pub(super) fn is(text: &Option<String>, wanted: &str) -> bool {
    text.as_ref().is_none_or(|t| t.eq_ignore_ascii_case(wanted))
}

/// Returns an error unless a condition holds.
pub(super) fn check(
    holds: bool,
    field: &str,
    found: impl ToString,
    expected: impl Into<String>,
) -> Result<(), Wrong> {
    if holds {
        return Ok(());
    }
    Err(Wrong {
        field: field.to_owned(),
        // Texts of the file may be long.
        found: found.to_string().chars().take(200).collect(),
        expected: expected.into(),
    })
}
