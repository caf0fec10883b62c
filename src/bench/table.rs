//! The table of a comparison.

use comfy_table::CellAlignment;
use potamoi_speed::{Comparison, Kind, Row, TimeSource};

use crate::bounds::number;
use crate::stdout::{prose, say};
use crate::tables;

/// A figure, or a dash.
fn figure(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), number)
}

fn beside(row: &Row) -> String {
    let kind = match row.beside.kind {
        Kind::Limit => "limit",
        Kind::Peer => "peer",
    };
    format!("{kind}: {}", row.beside.name)
}

/// Why figures are missing, each reason once, with what it is of.
fn reasons(rows: &[Row]) -> Vec<(&str, Vec<&str>)> {
    let mut found: Vec<(&str, Vec<&str>)> = vec![];
    for row in rows {
        let Some(why) = row.why.as_deref().or(row.beside.why.as_deref()) else {
            continue;
        };
        match found.iter_mut().find(|(known, _)| *known == why) {
            Some((_, all)) => all.push(&row.what),
            None => found.push((why, vec![&row.what])),
        }
    }
    found
}

fn text(rows: &[Row]) -> String {
    let mut table = tables::plain([
        "what",
        "peer or limit",
        "measured",
        "beside",
        "unit",
        "ratio",
    ]);
    if let Some(names) = table.column_mut(1) {
        names.set_cell_alignment(CellAlignment::Left);
    }
    for row in rows {
        table.add_row([
            row.what.clone(),
            beside(row),
            figure(row.measured),
            figure(row.beside.value),
            row.unit.to_owned(),
            figure(row.ratio),
        ]);
    }
    tables::fitted(&table, &["peer or limit"])
}

/// How times were taken, and what to make of them.
fn remarks(found: &Comparison) -> Vec<String> {
    let mut all = vec![];
    if !found.machine.is_optimised {
        all.push(
            "this program was built without optimisation: its figures say nothing of one that was; \
             build it with cargo build --release"
                .to_owned(),
        );
    }
    if found.times == TimeSource::ElapsedTimesThreads {
        all.push(
            "this system does not report processor times of threads: times are elapsed times, times \
             the threads of the work, and too long where the machine was busy"
                .to_owned(),
        );
    }
    if let (true, Some(share)) = (found.busy.is_busy, found.busy.waiting) {
        all.push(format!(
            "the machine was busy: threads waited for a core in {:.0} % of the time that they could \
             run; elapsed times were longer by as much, and processor times than on a quiet machine",
            100.0 * share
        ));
    }
    all
}

/// Prints the machine, the figures, and why some are missing.
pub(super) fn print(found: &Comparison) {
    let machine = &found.machine;
    let plural = |count: usize, of: &str| match count {
        1 => format!("1 {of}"),
        count => format!("{count} {of}s"),
    };
    prose!(
        0,
        "{}: {}, {}; {}; {}",
        machine.processor,
        plural(machine.cores, "core"),
        plural(machine.threads, "thread"),
        machine.vectors.join(", "),
        machine.system
    );
    let tools = found.tools.iter();
    // Some tools begin their version with their name.
    let tools = tools.filter_map(|tool| {
        let version = tool.version.as_ref()?;
        Some(match version.starts_with(tool.name) {
            true => version.clone(),
            false => format!("{} {version}", tool.name),
        })
    });
    let tools: Vec<String> = tools.collect();
    if !tools.is_empty() {
        prose!(0, "{}", tools.join("; "));
    }
    prose!(
        0,
        "processor time of all threads, the fastest of {}; ratio: measured over beside",
        plural(found.runs as usize, "run")
    );
    say!("{}", text(&found.rows));
    for (why, rows) in reasons(&found.rows) {
        prose!(2, "-: {}: {why}", rows.join(", "));
    }
    for remark in remarks(found) {
        prose!(2, "{remark}");
    }
}

#[cfg(test)]
mod tests {
    use potamoi_speed::{Beside, Section};

    use super::*;

    fn row(what: &str, measured: Option<f64>, value: Option<f64>, why: Option<&str>) -> Row {
        let beside = Beside {
            name: "JAX 0.10.2, 64 bits".to_owned(),
            kind: Kind::Peer,
            value,
            why: why.map(str::to_owned),
        };
        Row {
            section: Section::Fields,
            what: what.to_owned(),
            measured,
            unit: "ns a clock",
            why: None,
            beside,
            ratio: measured.zip(value).map(|(a, b)| a / b),
            counts: vec![],
            origin: String::new(),
        }
    }

    #[test]
    fn figures_are_within_a_line_and_missing_ones_are_dashes() {
        let none = Some("no JAX");
        let rows = [
            row(
                "verify garden 64 x 64, full",
                Some(12_345.0),
                Some(9_876.5),
                None,
            ),
            row("cairn:ngp 200 x 200", Some(412.0), None, none),
            row("cairn 200 x 200", Some(1.5), None, none),
        ];
        let text = text(&rows);
        assert!(
            text.lines().all(|line| line.chars().count() <= 98),
            "{text}"
        );
        assert!(!text.contains("left out"), "{text}");
        let lines: Vec<&str> = text.lines().collect();
        let has = |part: &str| lines.iter().any(|line| line.contains(part));
        assert!(has("12345") && has("1.25"), "{text}");
        let dashes = lines.iter().find(|line| line.contains("cairn:ngp"));
        let cells = dashes.map(|line| line.split_whitespace().filter(|cell| *cell == "-").count());
        assert_eq!(cells, Some(2), "{text}");
        let all = ["cairn:ngp 200 x 200", "cairn 200 x 200"];
        assert_eq!(reasons(&rows), [("no JAX", all.to_vec())]);
    }
}
