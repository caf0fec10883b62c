//! What `potamoi inspect` prints.

use potamoi_explore::inspection::{Beside, FrameWork, Inspected, Splats};
use potamoi_gaussians::{AxesFrom, Facts, Pairing};

use crate::stdout::{prose, say};
use crate::tables;

/// Prints what a model's file says and holds.
pub(super) fn print(own: &Inspected) {
    say!("{}: {}", own.name, own.algorithm);
    match &own.file {
        Some(file) => print_file(file),
        None if own.splats.is_some() => {
            say!("  format: - (no file of splats: built in, or Compact-3DGS)")
        }
        None => say!("  format, axes, degree and training flags: - (of files of splats alone)"),
    }
    if let Some(splats) = &own.splats {
        print_splats(splats);
    }
    for (what, all) in [("assumed", &own.assumed), ("not used", &own.not_used)] {
        if !all.is_empty() {
            prose!(2, "{what}: {}", all.join(", "));
        }
    }
}

fn print_file(file: &Facts) {
    let version = file
        .version
        .as_deref()
        .unwrap_or("- (the file states none)");
    say!("  format: {}", file.format);
    say!("  version: {version}");
    let writer = file
        .generator
        .as_deref()
        .unwrap_or("- (the file names none)");
    say!("  written by: {writer}");
    if let Some(axes) = file.axes {
        let from = match file.axes_from {
            AxesFrom::Format => "as usual for the format",
            AxesFrom::File => "as the file says",
            AxesFrom::User => "as the description says",
        };
        let turned = match axes.to_string().as_str() {
            "right-down-front" => "no turn",
            _ => "turned to right-down-front",
        };
        say!("  axes: {axes}, {from}; {turned}");
    }
    say!("  bytes: {}", file.bytes);
    for (name, value) in &file.more {
        say!("  {name}: {value}");
    }
    match file.clamped.is_empty() {
        true => say!("  held at a limit: no value"),
        false => {
            for (what, count) in &file.clamped {
                say!("  held at a limit: {count} {what}");
            }
        }
    }
}

fn print_splats(own: &Splats) {
    let trained = match own.antialiased {
        true => "with antialiasing",
        false => "without antialiasing",
    };
    say!(
        "  {} Gaussians of degree {}, trained {trained}",
        own.count,
        own.degree
    );
    if let Some(each) = own.bytes_each {
        say!("  bytes a Gaussian: {each:.1}");
    }
    if own.origin != [0.0; 3] {
        let [x, y, z] = own.origin;
        say!("  centres are from ({x}, {y}, {z}) on");
    }
    let mut table = tables::plain([" range of", "least", "most", "unit"]);
    for range in &own.ranges {
        table.add_row([
            format!(" {}", range.what),
            number(range.least),
            number(range.most),
            range.unit.to_owned(),
        ]);
    }
    say!("{}", trimmed(&table.to_string()));
}

/// Prints a model beside another.
pub(super) fn print_beside(own: &Beside) {
    let pictures = &own.pictures;
    let db = |own: Option<f64>| own.map_or("equal".to_owned(), |db| format!("{db:.2} dB"));
    let each: Vec<_> = pictures.each.iter().map(|own| db(own.db)).collect();
    say!("the first beside the second");
    prose!(
        2,
        "pictures (floating point, {} x {}, linear RGB): {} over all, {}",
        pictures.width,
        pictures.height,
        db(pictures.db),
        each.join(", ")
    );
    match (&own.differences, &own.no_differences) {
        (Some(found), _) => {
            let paired = match found.pairing {
                Pairing::Order => "in the order of the files".to_owned(),
                Pairing::Nearest => format!(
                    "with the nearest centre, {} of the other in one pair alone",
                    found.in_one_pair
                ),
            };
            say!("  Gaussians are compared {paired}");
            let mut table = tables::plain([" difference of", "largest", "RMS", "unit"]);
            for row in &found.properties {
                table.add_row([
                    format!(" {}", row.what),
                    number(row.most),
                    number(row.rms),
                    row.unit.to_owned(),
                ]);
            }
            say!("{}", trimmed(&table.to_string()));
        }
        (None, Some(why)) => say!("  differences of Gaussians: - ({why})"),
        (None, None) => {}
    }
    let mut table = tables::plain([" first picture", "first", "second", "ratio"]);
    for (what, of) in ROWS {
        let [a, b] = own.work.map(of);
        let ratio = match (a, b) {
            (Some(a), Some(b)) if b > 0 => format!("{:.3}", a as f64 / b as f64),
            _ => "-".to_owned(),
        };
        if [a, b] != [Some(0); 2] {
            let shown = [a, b].map(|own| own.map_or("-".to_owned(), |own| own.to_string()));
            let [a, b] = shown;
            table.add_row([format!(" {what}"), a, b, ratio]);
        }
    }
    say!("{}", trimmed(&table.to_string()));
    say!("  cycles: by the cycle model, with streams always ready");
}

type Row = (&'static str, fn(FrameWork) -> Option<u64>);

const ROWS: [Row; 5] = [
    ("pairs of tile and Gaussian", |own| own.tile_pairs),
    ("pairs of pixel and Gaussian", |own| own.pixel_pairs),
    ("cycles of the gathering unit", |own| Some(own.gather)),
    ("cycles of the vector unit", |own| Some(own.vector)),
    ("cycles of the splat unit", |own| Some(own.splats)),
];

/// A number with four digits that count.
fn number(value: f64) -> String {
    let size = value.abs();
    match () {
        () if value == 0.0 => "0".to_owned(),
        () if (1e-3..1e5).contains(&size) => {
            let before = size.log10().floor() as i32;
            let digits = (3 - before).clamp(0, 6) as usize;
            format!("{value:.digits$}")
        }
        () => format!("{value:.3e}"),
    }
}

/// A table whose lines end with their last letter.
fn trimmed(text: &str) -> String {
    let lines: Vec<_> = text.lines().map(str::trim_end).collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1.000"),
            (-12.3456, "-12.35"),
            (0.001_234_6, "0.001235"),
            (98765.4, "98765"),
            (1e-38, "1.000e-38"),
            (123_456.0, "1.235e5"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
