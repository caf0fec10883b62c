//! Summaries, and what the rows have to reach.
#![allow(clippy::unwrap_used)]

use super::*;

fn judged() -> Vec<Check> {
    let all = Measured::all().unwrap();
    let judged = all.iter().filter(|m| m.judged());
    judged.map(|m| Check::of(m).unwrap()).collect()
}

#[test]
fn a_summary_separates_bias_and_spread() {
    let own = Summary::of_ratios(&[2.0, 2.0]);
    assert!((own.error - 2.0).abs() < 1e-12 && (own.bias - 2.0).abs() < 1e-12);
    assert!((own.spread - 1.0).abs() < 1e-12);
    let own = Summary::of_ratios(&[2.0, 0.5]);
    assert!((own.error - 2.0).abs() < 1e-12 && (own.bias - 1.0).abs() < 1e-12);
    assert_eq!(own.in_twice, 2);
}

/// Acceptance of the model: a row that is off by more than twice names the missing term or count. A lower error comes from better counts alone: neither constants
/// nor the rule of overlap are changed to meet rows.
#[test]
fn judged_rows_are_reached() {
    let checks = judged();
    let all = Summary::of(&checks);
    assert!(all.rows >= 12, "{all:?}");
    assert!(all.in_range as f64 >= 0.9 * all.rows as f64, "{all:?}");
    assert!(all.error <= 1.6, "{all:?}");
    for check in &checks {
        let (id, ratio) = (&check.measured.row.id, check.ratio());
        let missing = check.measured.missing.is_some();
        assert_ne!(check.within_twice(), missing, "{id}: {ratio:.2}");
    }
    assert!(
        checks
            .iter()
            .filter(|c| c.measured.missing.is_some())
            .count()
            <= 1
    );
}

#[test]
fn ranges_hold_their_predictions_and_more_counts_take_longer() {
    for check in judged() {
        let id = &check.measured.row.id;
        let predicted = check.frames_s();
        assert!(
            check.slowest <= predicted && predicted <= check.fastest,
            "{id}"
        );
        assert!(
            check.at_twice < predicted && predicted < check.at_half,
            "{id}"
        );
    }
}

#[test]
fn views_cover_all_rows() {
    let checks = judged();
    for by in [By::Device, By::Program] {
        let views = leave_one_out(&checks, by);
        let rows: usize = views.iter().map(|(_, own, _)| own.rows).sum();
        assert_eq!(rows, checks.len());
        assert!(
            views
                .iter()
                .all(|(_, own, rest)| own.rows + rest.rows == checks.len())
        );
    }
}

/// Where DRAM or instructions cost nothing, the rows are missed by more.
#[test]
fn every_large_term_is_needed() {
    let checks = judged();
    let all = Summary::of(&checks);
    for (term, without) in ablation(&checks).unwrap() {
        if matches!(term, Term::Dram | Term::Issue) {
            assert!(without.error > all.error, "{term:?}: {without:?}");
        }
    }
}

/// The crate's front page states what the rows give.
#[test]
fn the_front_page_states_the_errors() {
    let page = include_str!("../lib.rs").replace("\n//! ", " ");
    let page: String = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let checks = judged();
    let all = Summary::of(&checks);
    let without = ablation(&checks).unwrap();
    let error = |term| without.iter().find(|(t, _)| *t == term).unwrap().1.error;
    let stated = [
        format!("Counts of {} judged rows", all.rows),
        format!("within twice on {} of {}", all.in_twice, all.rows),
        format!("(both bounds, all counts) on {}.", all.in_range),
        format!("geometric mean error is {:.2}", all.error),
        format!(
            "{:.2} times too fast; about that bias, {:.2} remain",
            all.bias, all.spread
        ),
        format!(
            "instructions {:.2}, memory {:.2}",
            error(Term::Issue),
            error(Term::Dram)
        ),
        format!("L1 {:.2}, L2 {:.2}", error(Term::L1), error(Term::L2)),
    ];
    for text in stated {
        assert!(page.contains(&text), "not on the front page: {text}");
    }
}
