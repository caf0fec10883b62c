//! Figures as text, as tables, plots and pages have them.

/// Digits behind the point: about three in all.
fn digits(value: f64) -> usize {
    match value.abs() {
        value if value < 10.0 => 2,
        value if value < 100.0 => 1,
        _ => 0,
    }
}

/// A number with about three digits.
///
/// ```
/// assert_eq!(potamoi_plots::figures::number(31.4159), "31.4");
/// ```
#[must_use]
pub fn number(value: f64) -> String {
    format!("{value:.0$}", digits(value))
}
