//! The table of the book.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fmt::Write;
use std::path::Path;

use potamoi_formats::config::Config;

use super::{Listed, Measured};

/// A case with the settings that it is shown with.
fn shown(own: &Listed) -> Measured {
    let config = Config::from_toml(own.shown, own.name).unwrap();
    match (own.measure)(&config) {
        Ok(case) => case.into(),
        Err(stop) => panic!("{}: {stop:?}", own.name),
    }
}

/// Checks that our form keeps the bound and the obvious form does not.
pub(super) fn holds(name: &str) {
    let own = super::all()
        .into_iter()
        .find(|own| own.name == name)
        .unwrap();
    let found = shown(&own);
    println!("{name}: {found:?}");
    assert!(found.passes, "{name}: {found:?}");
    assert!(found.is_hard, "{name} does not bite: {found:?}");
}

/// Two digits, which do not differ between machines.
fn number(value: f64) -> String {
    match value {
        f64::INFINITY => "no number".to_owned(),
        0.0 => "0".to_owned(),
        v if (10.0..1e6).contains(&v) => {
            let digits = format!("{v:.0}");
            let commas = digits.len().checked_sub(3).filter(|at| *at > 0);
            match commas {
                Some(at) => format!("{},{}", &digits[..at], &digits[at..]),
                None => digits,
            }
        }
        v if (0.01..10.0).contains(&v) => format!("{v:.2}"),
        v => format!("{v:.1e}"),
    }
}

fn table() -> String {
    let mut text =
        "| case | the obvious form | is off by | ours at most | why | measured | unit |\n\
                    |---|---|---|---|---|---|---|\n"
            .to_owned();
    for own in super::all() {
        let case = shown(&own);
        let [naive, ours] =
            [case.naive_error, case.error].map(|e| number(e.unwrap_or(f64::INFINITY)));
        writeln!(
            text,
            "| {} | {} | {naive} | {} | {} | {ours} | {} |",
            own.name,
            case.naive,
            number(case.bound),
            case.derivation,
            case.unit
        )
        .unwrap();
    }
    text
}

#[test]
fn the_table_of_the_book_is_current() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/explanation/hard-cases.md");
    let text = std::fs::read_to_string(&page).unwrap();
    let marks = ["<!-- units -->\n", "<!-- end of units -->\n"];
    let (before, rest) = text.split_once(marks[0]).unwrap();
    let (found, after) = rest.split_once(marks[1]).unwrap();
    let expected = table();
    if std::env::var_os("POTAMOI_REFRESH").is_some() {
        let whole = [before, marks[0], &expected, marks[1], after].concat();
        return potamoi_base::files::write(&page, whole.as_bytes()).unwrap();
    }
    let [found, expected] = [found, expected.as_str()].map(|t| t.lines().collect::<Vec<_>>());
    let same = found.len() == expected.len();
    for (found, expected) in found.iter().zip(&expected) {
        assert!(
            same && alike(found, expected),
            "{STALE}\nthere:    {found}\nmeasured: {expected}"
        );
    }
    assert!(same, "{STALE}");
}

const STALE: &str =
    "docs/explanation/hard-cases.md is not what is measured; make refresh writes it, then git diff";

/// Whether rows say the same: numbers to a tenth, or roundings of doubles to twice, since the last
/// bits of elementary functions differ between machines.
fn alike(a: &str, b: &str) -> bool {
    let value = |cell: &str| cell.replace(',', "").parse::<f64>().ok();
    let cells = |row: &str| row.split(" | ").map(str::to_owned).collect::<Vec<_>>();
    let (a, b) = (cells(a), cells(b));
    let near = |(a, b): (&String, &String)| match (value(a), value(b)) {
        (Some(a), Some(b)) if a.max(b) < 1e-14 => a <= 2.0 * b && b <= 2.0 * a,
        (Some(a), Some(b)) => (a - b).abs() <= 0.1 * a.max(b),
        _ => a == b,
    };
    a.len() == b.len() && a.iter().zip(&b).all(near)
}
