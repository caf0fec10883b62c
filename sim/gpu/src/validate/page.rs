//! Tables of `docs/explanation/trust.md`, compared with the page, or written into it.

use std::fmt::Write as _;
use std::path::Path;

use super::{By, Check, Summary, ablation, leave_one_out, with_one_count};
use crate::rows::Measured;

fn checks(judged: bool) -> Vec<Check> {
    let all = Measured::all().unwrap();
    let chosen = all.iter().filter(|m| m.judged() == judged);
    chosen.map(|m| Check::of(m).unwrap()).collect()
}

/// The device, in its power mode where it has several.
fn device(own: &Measured) -> String {
    let device = &own.row.device;
    match device.title.starts_with("Jetson") {
        true => format!("{}, {}", device.title, device.mode),
        false => device.title.clone(),
    }
}

/// Three significant digits.
fn rate(frames_s: f64) -> String {
    let digits = (2.0 - frames_s.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{frames_s:.digits$}")
}

fn predictions(checks: &[Check]) -> String {
    let mut text = "| program, scene | device | measured, frames/s | predicted: max to sum | mid | mid over measured | \
                    half to twice the counts | full range |\n|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for check in checks {
        let own = &check.measured;
        let [max, sum] = [&check.mid.max, &check.mid.sum].map(|time| rate(1.0 / time.seconds));
        let outside = if check.within_range() { "" } else { ", missed" };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {max} to {sum} | {} | {:.2} | {} to {} | {} to {}{outside} |",
            own.row.title,
            device(own),
            rate(own.frames_s()),
            rate(check.frames_s()),
            check.ratio(),
            rate(check.at_half),
            rate(check.at_twice),
            rate(check.slowest),
            rate(check.fastest),
        );
    }
    text
}

/// Mid at half and at twice each count by itself; counts fixed by picture or program are left out.
fn each_count(checks: &[Check]) -> String {
    let mut text = "| program, scene | device | mid | at half to at twice each count by itself |\n|---|---|---|---|\n".to_owned();
    for check in checks {
        let own = &check.measured.row;
        let mut all = vec![];
        for name in own.counts.keys() {
            let [half, twice] = [0.5, 2.0].map(|by| rate(with_one_count(own, name, by).unwrap()));
            if half != twice {
                all.push(format!("{name} {half} to {twice}"));
            }
        }
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} |",
            own.title,
            device(&check.measured),
            rate(check.frames_s()),
            all.join("; "),
        );
    }
    text
}

fn lacking(checks: &[Check]) -> String {
    let mut text = "| program, scene | device | not documented | what would close the gap |\n|---|---|---|---|\n".to_owned();
    for own in checks.iter().map(|check| &check.measured) {
        let or_none = |text: &Option<String>| text.clone().unwrap_or_else(|| "-".to_owned());
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} |",
            own.row.title,
            device(own),
            or_none(&own.beside),
            or_none(&own.closes),
        );
    }
    text
}

fn line(name: &str, own: &Summary) -> String {
    let range = match own.in_range {
        0 => "-".to_owned(),
        count => count.to_string(),
    };
    format!(
        "| {name} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {range} | {} |\n",
        own.rows, own.error, own.bias, own.spread, own.worst, own.in_twice
    )
}

fn errors(checks: &[Check]) -> String {
    let mut text =
        "| rows | number | error | bias | spread | worst | in the full range | within 2 times |\n\
                    |---|---|---|---|---|---|---|---|\n"
            .to_owned();
    text += &line("all judged rows", &Summary::of(checks));
    for by in [By::Device, By::Program] {
        for (name, own, _) in leave_one_out(checks, by) {
            text += &line(&format!("`{name}` alone"), &own);
        }
    }
    for (term, own) in ablation(checks).unwrap() {
        text += &line(&format!("all, without the term \"{}\"", term.name()), &own);
    }
    text
}

#[test]
fn the_table_of_the_book_has_today_s_predictions() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/explanation/trust.md");
    let mut text = std::fs::read_to_string(&page).unwrap();
    let (judged, beside) = (checks(true), checks(false));
    let tables = [
        ("judged", predictions(&judged)),
        ("counts", each_count(&judged)),
        ("errors", errors(&judged)),
        ("beside", predictions(&beside)),
        ("lacking", lacking(&beside)),
    ];
    let is_refreshed = std::env::var_os("POTAMOI_REFRESH").is_some();
    for (name, expected) in tables {
        let marks = [
            format!("<!-- rows: {name} -->\n"),
            "<!-- end of rows -->\n".to_owned(),
        ];
        let (before, rest) = text.split_once(&*marks[0]).unwrap();
        let (found, after) = rest.split_once(&*marks[1]).unwrap();
        assert!(
            is_refreshed || found == expected,
            "table {name} of {} is not what the model says; again: POTAMOI_REFRESH=1 cargo test -p potamoi-gpu the_table_of_the_book",
            page.display()
        );
        text = [before, &marks[0], &expected, &marks[1], after].concat();
    }
    if is_refreshed {
        std::fs::write(&page, text).unwrap();
    }
}
