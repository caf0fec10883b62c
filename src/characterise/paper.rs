//! The paper's figures as text.

use potamoi_explore::characterisation::PaperMotivation;

/// The share of conflicts of 16 rays on 16 banks, as text.
pub(super) fn conflicts_16(paper: &PaperMotivation) -> String {
    let average = percent(paper.conflicts_16_on_16_average);
    let own = paper.conflicts_16_on_16.map(percent);
    own.map_or(format!("{average} on average"), |own| own)
}

/// A whole number of per cent.
pub(super) fn percent(rate: f64) -> String {
    format!("{:.0} %", 100.0 * rate)
}
