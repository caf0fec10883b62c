//! Figures at both bounds of the GPU's kernels, as text.

pub(crate) use potamoi_plots::figures::number;
use potamoi_system::system_model::AtBounds;

/// From the lower to the higher; one figure where both read alike.
pub(crate) fn range(of: &AtBounds<f64>) -> String {
    let [low, high] = [of.low(), of.high()].map(number);
    match low == high {
        true => low,
        false => format!("{low} to {high}"),
    }
}

/// As [`range`], for narrow tables.
pub(crate) fn tight(of: &AtBounds<f64>) -> String {
    range(of).replace(" to ", "-")
}

/// A range that may not be known.
pub(crate) fn known(of: Option<&AtBounds<f64>>) -> String {
    of.map_or_else(|| "-".to_owned(), range)
}

/// A range with its geometric mean.
pub(crate) fn with_mid(of: &AtBounds<f64>) -> String {
    let range = range(of);
    match range.contains(" to ") {
        true => format!("{range}, mid {}", number(of.mid())),
        false => range,
    }
}

/// A range of a speed-up, which says nothing where it includes 1.
pub(crate) fn ratio(of: &AtBounds<f64>) -> String {
    let is_one = of.max == 1.0 && of.sum == 1.0;
    match of.decides() || is_one {
        true => range(of),
        false => format!("{}: no conclusion", range(of)),
    }
}

/// As [`ratio`], for narrow tables: marked where it includes 1 and is not exactly that.
pub(crate) fn times(of: &AtBounds<f64>) -> String {
    let is_one = of.max == 1.0 && of.sum == 1.0;
    match of.decides() || is_one {
        true => tight(of),
        false => format!("{} ?", tight(of)),
    }
}

/// A saving of energy, which may not be known, and says nothing where it includes 1.
pub(crate) fn saving(of: Option<&AtBounds<f64>>) -> String {
    of.map_or_else(|| "-".to_owned(), ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_flips_is_said_to_be_no_conclusion() {
        let of = |max, sum| AtBounds { max, sum };
        assert_eq!(ratio(&of(0.9, 1.1)), "0.90 to 1.10: no conclusion");
        assert_eq!(ratio(&of(31.2, 2.0)), "2.00 to 31.2");
        assert_eq!(ratio(&of(1.0, 1.0)), "1.00");
        assert_eq!(with_mid(&of(200.0, 50.0)), "50.0 to 200, mid 100");
        assert_eq!(with_mid(&of(1.001, 1.002)), "1.00");
    }
}
