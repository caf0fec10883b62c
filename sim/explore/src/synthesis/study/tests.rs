//! The report's tables by hand, and against the book.
#![allow(clippy::unwrap_used)]

use super::*;
use potamoi_synth::SynthReport;

/// A variant with a unit of the paper's report in its place.
fn row(variant: Variant, at: usize) -> Row {
    let raw = SynthReport::checked_in().unwrap()[0].clone().raw;
    let raw = Raw {
        units: vec![raw.units[at].clone()],
        memories: raw.memories,
    };
    of(variant, &raw)
}

fn of(variant: Variant, raw: &Raw) -> Row {
    Row {
        variant,
        config: variant.config().unwrap(),
        unit: raw.units[0].clone(),
        memories: raw.memories.clone().unwrap(),
        scaled: Scaled::new(raw, Some(7), 12),
    }
}

/// The line of docs/explanation/synthesis.md.
#[test]
fn the_paper_s_unit_is_as_the_book_has_it() {
    let text = units(&[row(GATHERING[0], 0)]);
    let line = "| paper | 0.0152 (0.0349) | 6868 | 1123 (1415) | 0.0584 | 0.0144 |";
    assert_eq!(text.lines().nth(2), Some(line), "{text}");
    let book = include_str!("../../../../../docs/explanation/synthesis.md");
    assert!(book.contains(&line.replace("6868", "6,868")));
    let text = modules(&row(GATHERING[0], 0).unit);
    assert!(
        text.contains("| `reducer` | 64 | 1483 | 31 | 180.5 | 75.8 % |"),
        "{text}"
    );
}

/// Of 24 lanes with 100 um^2 and 240 um^2 for all of them: 110 um^2, 1 ns and so many
/// clocks a result.
#[test]
fn area_and_time_are_of_a_lane_and_its_part() {
    let changed = |variant: Variant| {
        let mut row = row(variant, 1);
        row.unit.period_ps = 1000.0;
        for module in &mut row.unit.modules {
            module.area_um2 = match &*module.module {
                "vector_lane" => 100.0,
                "exp_constants" => 240.0,
                _ => 7.0,
            };
        }
        row
    };
    let [first, second] = [EXPONENTIALS[0], EXPONENTIALS[4]].map(changed);
    assert!(second.config.vu.exp.pipelined);
    let text = ways(&[first, second]);
    let lines: Vec<&str> = text.lines().skip(2).collect();
    assert!(
        lines[0].ends_with("| 100.0 | 240.0 | 1000 | 20 | 2200 | 1.00 |"),
        "{text}"
    );
    assert!(
        lines[1].ends_with("| 100.0 | 240.0 | 1000 | 1 | 110 | 0.05 |"),
        "{text}"
    );
}

/// Square micrometres that CACTI 7.0 gives these memories at 22 nm.
fn cacti(_: &str, shape: &Shape) -> Result<Figures, SynthError> {
    let ports = [shape.read_writes, shape.writes, shape.reads];
    let area_um2 = match (shape.words, shape.bits, ports) {
        (1024, 16, [0, 1, 2]) => 5634.56,
        (512, 16, [1, 0, 1]) => 1672.2,
        (512, 16, [1, 0, 0]) => 804.072,
        (128, 128, [0, 1, 1]) => 4385.84,
        (512, 96, [1, 0, 0]) => 4826.78,
        _ => unreachable!("{shape:?}"),
    };
    Ok(Figures {
        area_um2,
        read_pj: 1.0,
        write_pj: 1.0,
        leakage_mw: 1.0,
        access_ps: 1.0,
        cycle_ps: 1.0,
    })
}

/// A feature-major unit: memories as they are, of what joins them (arbiters, and of lanes
/// what is no register) areas that come to the book's.
fn feature_major(variant: Variant, banks: u64, lanes: u64, each_um2: [f64; 2]) -> Row {
    let mut raw = SynthReport::checked_in().unwrap()[0].clone().raw;
    raw.units.truncate(1);
    let unit = &mut raw.units[0];
    let modules = [("bank_arbiter", banks), ("gather_lane", lanes)];
    for ((module, own), um2) in unit.modules.iter_mut().zip(modules).zip(each_um2) {
        module.module = own.0.to_owned();
        module.count = own.1;
        module.flop_area_um2 = if own.0 == "gather_lane" { 500.0 } else { 7.0 };
        module.area_um2 = um2 + if own.0 == "gather_lane" { 500.0 } else { 0.0 };
    }
    unit.memories[0].count = 2 * banks;
    (unit.memories[0].read_writes, unit.memories[0].reads) = (1, 0);
    let own = &mut raw.memories.as_mut().unwrap().macros[0];
    own.count = 2 * banks;
    (own.shape.read_writes, own.shape.reads) = (1, 0);
    own.figures.area_um2 = 804.072;
    of(variant, &raw)
}

fn mac() -> UnitReport {
    let [paper, _] = SynthReport::checked_in().unwrap();
    paper.unit(UnitKind::ArrayMac).unwrap().clone()
}

fn all() -> Vec<Row> {
    let gathering = GATHERING.into_iter().enumerate().map(|(at, v)| match at {
        4 => feature_major(v, 16, 16, [27.22, 56.56]),
        5 => feature_major(v, 32, 64, [117.8, 89.7]),
        _ => row(v, 0),
    });
    gathering.chain(EXPONENTIALS.map(|v| row(v, 1))).collect()
}

/// The cells of a table's lines, but for names.
fn cells(text: &str, head: &str) -> Vec<Vec<String>> {
    let start = text.find(head).unwrap();
    let lines = text[start..].lines().skip(2);
    let lines = lines.take_while(|line| line.starts_with('|'));
    let own = |line: &str| {
        line.trim_matches('|')
            .split('|')
            .skip(1)
            .map(plain)
            .collect()
    };
    lines.map(own).collect()
}

fn plain(cell: &str) -> String {
    let cell = cell.trim().trim_end_matches(" bit");
    if cell == "0" {
        String::new()
    } else {
        cell.to_owned()
    }
}

/// Both tables of docs/explanation/synthesis.md, figure by figure: of the paper's unit with and without
/// its feature FIFO beside an NPU with array, features and weights; and of tables with
/// fewer ports beside a crossbar, all at 12 nm.
#[test]
fn memories_beside_logic_are_as_the_book_has_them() {
    let book = include_str!("../../../../../docs/explanation/synthesis.md");
    let text = text("origin", &all(), &mac(), &cacti).unwrap();
    let found = cells(&text, "| the paper's unit, mm^2 |");
    assert_eq!(found.len(), 4, "{text}");
    assert_eq!(found, cells(book, "| the paper's unit, mm^2 at 12 nm |"));
    let npu = "The NPU: 0.876 mm^2 (1.668 by a published cell), of which the array 0.229, the global feature buffer 0.610 (1.355), \
               the weight buffer 0.038 (0.085).";
    assert!(text.contains(npu), "{text}");
    let found = cells(&text, "| table of features |");
    assert_eq!(found.len(), 6, "{text}");
    assert_eq!(found, cells(book, "| MFT, at 12 nm |"));
}

/// The whole of it: where it is from, and five tables, a line for each variant.
#[test]
fn a_report_has_all_tables_and_variants() {
    let text = text("asap7, 7 nm.", &all(), &mac(), &cacti).unwrap();
    assert!(
        text.starts_with("asap7, 7 nm.\n\n| gathering unit |"),
        "{text}"
    );
    let mut from = 0;
    for (head, lines) in [
        ("| gathering unit |", GATHERING.len()),
        ("| module of the paper's unit |", 6),
        ("| the paper's unit, mm^2 |", 4),
        ("| table of features |", 6),
        ("| exponential |", EXPONENTIALS.len()),
    ] {
        let at = from + text[from..].find(head).unwrap();
        assert_eq!(cells(&text[at..], head).len(), lines, "{head}");
        from = at + 1;
    }
    for variant in GATHERING.iter().chain(&EXPONENTIALS) {
        assert!(
            text.contains(&format!("\n| {} |", variant.name)),
            "{}",
            variant.name
        );
    }
    assert!(text.ends_with("|\n\n"), "{text}");
}
