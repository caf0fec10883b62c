//! The table of pictures in the book.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::{pictures, sampled, sheet, voxels};

fn decibels(value: Option<f64>) -> String {
    match value {
        None => "no number".to_owned(),
        Some(f64::INFINITY) => "equal".to_owned(),
        Some(value) => format!("{value:.0} dB"),
    }
}

fn table() -> String {
    let mut text =
        "| scene | case | the obvious form | is at | ours is at | farthest pixel | may be |\n\
                    |---|---|---|---|---|---|---|\n"
            .to_owned();
    let mut row = |scene, case, form, levels: [Option<f64>; 2], off: [f64; 2]| {
        let [naive, ours] = levels.map(decibels);
        let [off, bound] = off.map(|v| match v {
            0.0 => "0".to_owned(),
            v => format!("{v:.0e}"),
        });
        writeln!(
            text,
            "| {scene} | {case} | {form} | {naive} | {ours} | {off} | {bound} |"
        )
        .unwrap();
    };
    for scene in potamoi_analysis::hard_cases::pictures::all() {
        let found = pictures::measure(&scene);
        let levels = [found.naive, Some(found.fixed)];
        let off = [found.worst, found.bound];
        row(scene.name, scene.case, scene.form.text(), levels, off);
    }
    for shown in sampled::all() {
        let off = [shown.farthest, shown.bound];
        row(shown.scene, shown.case, shown.form, shown.levels(), off);
    }
    let found = voxels::measure();
    for (form, naive) in [
        ("slabs by division", found.divided),
        (
            "samples counted in every MVoxel that holds them",
            found.owned_twice,
        ),
    ] {
        row(
            "voxels",
            "rays in faces and along an axis, samples on faces",
            form,
            [naive, found.fixed].map(Some),
            [found.farthest, found.bound],
        );
    }
    text
}

/// Compares a part of the page with what is measured, or writes it if that is asked for.
pub(crate) fn compare(marks: [&str; 2], expected: &str, refresh: impl Fn()) {
    // Tests run side by side, and each writes the whole page.
    static PAGE: Mutex<()> = Mutex::new(());
    let _one = PAGE.lock().unwrap_or_else(PoisonError::into_inner);
    let text = std::fs::read_to_string(page()).unwrap();
    let (before, rest) = text.split_once(marks[0]).unwrap();
    let (found, after) = rest.split_once(marks[1]).unwrap();
    if std::env::var_os("POTAMOI_REFRESH").is_some() {
        refresh();
        let whole = [before, marks[0], expected, marks[1], after].concat();
        return potamoi_base::files::write(&page(), whole.as_bytes()).unwrap();
    }
    let [found, expected] = [found, expected].map(|t| t.lines().collect::<Vec<_>>());
    let same = found.len() == expected.len();
    for (found, expected) in found.iter().zip(&expected) {
        assert!(
            same && alike(found, expected),
            "{STALE}\nthere:    {found}\nmeasured: {expected}"
        );
    }
    assert!(same, "{STALE}");
}

fn page() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/explanation/hard-cases.md")
}

/// Names of the page's first table, whose rows are measured.
pub(crate) fn cases_at_the_unit() -> Vec<String> {
    let text = std::fs::read_to_string(page()).unwrap();
    let (_, rest) = text.split_once("<!-- units -->\n").unwrap();
    let (rows, _) = rest.split_once("<!-- end of units -->").unwrap();
    let first = |row: &str| row.split(" | ").next().unwrap()[2..].to_owned();
    rows.lines().skip(2).map(first).collect()
}

#[test]
fn the_table_of_the_book_is_current() {
    compare(
        ["<!-- pictures -->\n", "<!-- end of pictures -->\n"],
        &table(),
        || {
            let image = page().with_file_name("../images/hard-cases.png");
            sheet::sheet().write_png(&image).unwrap();
        },
    );
}

const STALE: &str =
    "docs/explanation/hard-cases.md is not what is measured; make refresh writes it, then git diff";

/// Whether rows say the same: decibels to one, other numbers to a quarter, since elementary functions
/// differ between machines and may flip a decision.
fn alike(a: &str, b: &str) -> bool {
    let cells = |row: &str| row.split(" | ").map(str::to_owned).collect::<Vec<_>>();
    let level = |cell: &str| cell.strip_suffix(" dB").and_then(|v| v.parse::<f64>().ok());
    let value = |cell: &str| cell.trim_end_matches(" |").parse::<f64>().ok();
    let (a, b) = (cells(a), cells(b));
    let near = |(a, b): (&String, &String)| match ((level(a), level(b)), (value(a), value(b))) {
        ((Some(a), Some(b)), _) => (a - b).abs() <= 1.0,
        (_, (Some(a), Some(b))) => (a - b).abs() <= 0.25 * a.max(b),
        _ => a == b,
    };
    a.len() == b.len() && a.iter().zip(&b).all(near)
}

/// Every guard that tools/hard-case-guards takes out is still there, once, and every case at the unit
/// has one.
#[test]
fn every_guard_is_where_the_list_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| std::fs::read_to_string(root.join(path)).unwrap();
    let list: toml::Table = read("tests/hard_cases/guards.toml").parse().unwrap();
    let guards = list["guard"].as_array().unwrap();
    let mut guarded = BTreeSet::new();
    for guard in guards {
        let field = |name: &str| guard[name].as_str().unwrap();
        let found = read(field("file")).matches(field("text")).count();
        assert_eq!(found, 1, "{}: {}", field("file"), field("text"));
        guarded.extend(
            guard
                .get("test")
                .and_then(|t| t.as_str())
                .map(str::to_owned),
        );
    }
    let mut cases = BTreeSet::new();
    for file in std::fs::read_dir(root.join("golden/analysis/src/hard_cases")).unwrap() {
        let path = file.unwrap().path();
        if path.is_dir() {
            continue;
        }
        let (file, text) = (path.file_stem().unwrap(), std::fs::read_to_string(&path));
        let text = text.unwrap();
        let names = text.split("\nfn ").skip(1);
        let names = names.filter_map(|rest| rest.split_once("Config) -> Measuring {"));
        let names = names.filter_map(|(head, _)| head.split_once('('));
        let names = names.filter(|(_, argument)| ["under: &", "_: &"].contains(argument));
        cases.extend(names.map(|(name, _)| {
            let file = file.to_str().unwrap();
            format!("hard_cases::{file}::holds::{name}")
        }));
    }
    assert_eq!(guarded, cases);
}
