//! Tables of predictions beside measurements: `cargo run -p potamoi-gpu --example rows`.

use std::error::Error;

use potamoi_gpu::programs::Kind;
use potamoi_gpu::rows::Measured;
use potamoi_gpu::validate::{By, Check, Summary, ablation, leave_one_out, with_one_count};

fn main() -> Result<(), Box<dyn Error>> {
    let all = Measured::all()?;
    let checks = |judged: bool| -> Result<Vec<Check>, Box<dyn Error>> {
        let chosen = all.iter().filter(|m| m.judged() == judged);
        Ok(chosen.map(Check::of).collect::<Result<_, _>>()?)
    };
    let (judged, beside) = (checks(true)?, checks(false)?);

    println!("Judged rows, frames a second");
    predictions(&judged);
    println!("\nBeside, not judged");
    predictions(&beside);
    println!("\nWhat rows lack, and what would close the gap");
    for check in judged.iter().chain(&beside) {
        lacks(&check.measured);
    }
    println!("\nWhat bounds the judged rows: share of the time, whole overlap / none");
    bounded_by(&judged);
    println!("\nMid with half / twice of one count, over mid");
    sensitivity(&judged)?;
    println!("\nErrors of the judged rows");
    heading();
    summary("all", &Summary::of(&judged));
    for (term, own) in ablation(&judged)? {
        summary(&format!("without {}", term.name()), &own);
    }
    for (by, word) in [(By::Device, "device"), (By::Program, "program")] {
        println!("\nBy {word}: its rows alone, then all others");
        heading();
        for (name, own, rest) in leave_one_out(&judged, by) {
            summary(&name, &own);
            summary("  all others", &rest);
        }
    }
    Ok(())
}

/// Below 100 columns: what is not documented or not modelled.
fn lacks(own: &Measured) {
    let lines = [
        ("undocumented", &own.beside),
        ("missing", &own.missing),
        ("closed by", &own.closes),
    ];
    for (word, text) in lines {
        let Some(text) = text else { continue };
        let mut line = format!("  {:24} {word}:", own.row.id);
        for part in text.split(' ') {
            if line.len() + part.len() > 97 {
                println!("{line}");
                line = " ".repeat(27);
            }
            line = format!("{line} {part}");
        }
        println!("{line}");
    }
}

/// Seven columns, of which two digits are fractions below 100.
fn rate(frames_s: f64) -> String {
    let digits = usize::from(frames_s < 100.0) + 1;
    format!("{frames_s:7.digits$}")
}

fn predictions(checks: &[Check]) {
    println!(
        "  {:24}{:>8}{:>7}{:>7}{:>7}{:>7}{:>7}{:>6} {:>13}",
        "row", "measured", "max", "mid", "sum", "half", "twice", "ratio", "range"
    );
    for check in checks {
        let bounds = &check.mid;
        let rates = [
            1.0 / bounds.max.seconds,
            check.frames_s(),
            1.0 / bounds.sum.seconds,
            check.at_half,
            check.at_twice,
        ];
        println!(
            "  {:24} {}{}{:6.2} {:>6.1}-{:<6.1}{}{}",
            check.measured.row.id,
            rate(check.measured.frames_s()),
            rates.map(rate).concat(),
            check.ratio(),
            check.slowest,
            check.fastest,
            if check.within_range() { "" } else { " out" },
            if check.within_twice() { "" } else { " >2x" },
        );
    }
}

fn bounded_by(checks: &[Check]) {
    for check in checks {
        let shares = |time: &potamoi_gpu::Time| {
            let largest = time.largest().into_iter().take(3);
            let one = |(term, s): (potamoi_gpu::Term, f64)| {
                format!("{} {:.0}%", term.name(), 100.0 * s / time.seconds)
            };
            largest.map(one).collect::<Vec<_>>().join(", ")
        };
        let [max, sum] = [&check.mid.max, &check.mid.sum].map(shares);
        println!("  {:25}{max:33}/ {sum}", check.measured.row.id);
    }
}

fn sensitivity(checks: &[Check]) -> Result<(), Box<dyn Error>> {
    for check in checks {
        let row = &check.measured.row;
        let mut parts = vec![];
        for count in row.program.counts() {
            if count.kind == Kind::Fixed {
                continue;
            }
            let over = |factor| -> Result<f64, Box<dyn Error>> {
                Ok(with_one_count(row, count.name, factor)? / check.frames_s())
            };
            parts.push(format!(
                "{} {:.2}/{:.2}",
                count.name,
                over(0.5)?,
                over(2.0)?
            ));
        }
        println!("  {}", row.id);
        for line in parts.chunks(4) {
            println!("    {}", line.join(", "));
        }
    }
    Ok(())
}

fn heading() {
    println!(
        "  {:25}{:>6}{:>8}{:>8}{:>8}{:>8}{:>10}{:>10}",
        "", "rows", "error", "bias", "spread", "worst", "in range", "within 2x"
    );
}

fn summary(name: &str, own: &Summary) {
    let range = if own.in_range == 0 {
        "-".to_owned()
    } else {
        own.in_range.to_string()
    };
    println!(
        "  {name:25}{:6}{:8.2}{:8.2}{:8.2}{:8.2}{range:>10}{:>10}",
        own.rows, own.error, own.bias, own.spread, own.worst, own.in_twice
    );
}
