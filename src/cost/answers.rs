//! What accuracy costs, in one line for each knob that saves time, and the knobs worth a plot.

use potamoi_explore::accuracy::knobs::Knob;
use potamoi_explore::accuracy::{Point, Sweep};

/// Most lines, and most knobs in a plot.
const MOST: usize = 8;
/// Smallest share of the frame's time that is told as saved.
const LEAST: f64 = 0.005;

/// Number at the end of a setting's label.
fn number(setting: &str) -> Option<i64> {
    let start = setting
        .rfind(|c: char| !c.is_ascii_digit())
        .map_or(0, |at| at + 1);
    setting[start..].parse().ok()
}

/// A setting in words: iterations beside those of the default.
fn words(point: &Point, iterations: u32) -> String {
    let own = match &*point.knob {
        "iterations" => number(&point.setting).map(|n| i64::from(iterations) - n),
        _ => None,
    };
    match own {
        Some(fewer) if fewer > 0 => {
            let s = if fewer == 1 { "" } else { "s" };
            format!("{fewer} iteration{s} fewer")
        }
        _ => format!("{} {}", point.knob, point.setting)
            .trim_end()
            .to_owned(),
    }
}

/// Share of the default's time that a point saves.
fn saved(point: &Point, default: &Point) -> f64 {
    1.0 - point.frame_ns / default.frame_ns
}

/// The answers, the largest saving first. `iterations` are those of the default's exponential.
pub(super) fn answers(report: &Sweep, knobs: &[Knob], iterations: u32) -> Vec<String> {
    let default = report.default_point();
    let best = knobs
        .iter()
        .filter_map(|knob| report.best_setting(knob.name));
    let mut best: Vec<_> = best.map(|(p, lost)| (p, lost, saved(p, default))).collect();
    best.retain(|(.., saved)| *saved >= LEAST);
    best.sort_by(|a, b| b.2.total_cmp(&a.2));
    let line = |(point, lost, saved): &(&Point, f64, f64)| {
        let lost = if *lost == 0.0 { 0.0 } else { -lost };
        // What rounds to nothing has no sign.
        let db = match format!("{lost:+.2}") {
            own if ["+0.00", "-0.00"].contains(&&*own) => "0.00".to_owned(),
            own => own,
        };
        format!(
            "{}: {db} dB, saves {:.0} % of the frame's time",
            words(point, iterations),
            100.0 * saved
        )
    };
    let lines: Vec<String> = best.iter().take(MOST).map(line).collect();
    match lines.is_empty() {
        true => vec!["no setting alone saves half a percent of the frame's time".to_owned()],
        false => lines,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_end_with_their_number() {
        assert_eq!(number("n = 14"), Some(14));
        assert_eq!(number("14"), Some(14));
        assert_eq!(number("early"), None);
    }
}
