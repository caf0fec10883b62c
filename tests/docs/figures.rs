//! Figures in the documents are those of the program.
//!
//! ```text
//! <!-- figures: render --scene garden --json g.json; model --scenes cairn:ngp
//! g.json /float/db .1
//! skip 2
//! cairn:ngp | potamoi
//! -->
//! The picture is 90.9 dB from floating point. Of 200 x 200 pixels, the system is 3.66 (4.95) ...
//! <!-- end -->
//! ```
//!
//! After `figures:` (or `slow figures:`, for tests that run with `--ignored`) stand the program's
//! arguments, `;` between commands, or `files` where all figures are of reports in the repository.
//! Each further line names what the next numbers of the body are:
//!
//! - `FILE /POINTER FORMAT`: a number of a JSON report, which a command wrote or the repository has;
//!   `[key=value]` in the pointer finds the entry of a list, `[key=value&key=value]` one by two keys;
//!   `.2` keeps two decimals, `.1e-3` one of a thousandth, `.1Mi` and `.1Gi` one of 2^20 and 2^30, `,` puts commas between thousands.
//!   `/POINTER + /POINTER` is a sum, `*` and `/` in its place a product and a quotient;
//! - `ROW | COLUMN; COLUMN`: the numbers in cells of a table that the last command prints, or, with
//!   `first: ` before the row, the first one;
//! - `skip N`: numbers of the text itself;
//! - `output` or `output from TEXT`: the body is a block of code with all that the last command
//!   prints, from the line that begins so.
//!
//! A command may name files below `$POTAMOI_SHARED`, a folder of real scenes that the repository does not have.
//! Without it the passage is skipped, and counted as skipped.
//!
//! Numbers in code and in targets of links are none. With `POTAMOI_REFRESH` set the body is
//! written, otherwise it is compared.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

use serde_json::Value;

use super::{folder_with_docs, name, pages, read, root};
use crate::common::{run, shared, stderr, stdout};

const END: &str = "<!-- end -->";
/// The folder of real scenes in a command.
const SHARED: &str = "$POTAMOI_SHARED";

/// A marked passage: what comes before its body, and the body.
struct Passage<'a> {
    is_slow: bool,
    commands: Vec<&'a str>,
    values: Vec<&'a str>,
    body: std::ops::Range<usize>,
}

fn passages(text: &str) -> Vec<Passage<'_>> {
    let mut found = vec![];
    let mut at = 0;
    while let Some(start) = text[at..].find("<!-- ").map(|n| at + n) {
        let Some(stop) = text[start..].find("-->").map(|n| start + n) else {
            break;
        };
        // Marks begin lines; elsewhere they are quoted.
        let line = text[..start].rsplit('\n').next().unwrap_or_default();
        if !line.trim().is_empty() {
            at = start + 5;
            continue;
        }
        at = stop + 3;
        let comment = text[start + 5..stop].trim();
        let (is_slow, rest) = match comment.strip_prefix("slow ") {
            Some(rest) => (true, rest),
            None => (false, comment),
        };
        let Some(rest) = rest.strip_prefix("figures: ") else {
            continue;
        };
        let mut lines = rest.lines();
        let commands = lines.next().unwrap_or_default().split("; ").collect();
        let length = text[at..].find(END).expect("an end to each passage");
        found.push(Passage {
            is_slow,
            commands,
            values: lines.map(str::trim).collect(),
            body: at..at + length,
        });
        at += length;
    }
    found
}

/// Where the numbers of a text are, but for those in code, in targets of links and in names.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let bytes = text.as_bytes();
    let mut found = vec![];
    let (mut at, mut code, mut target) = (0, false, false);
    while at < bytes.len() {
        let before = at.checked_sub(1).map_or(b' ', |n| bytes[n]);
        match bytes[at] {
            b'`' => code = !code,
            b'(' if before == b']' => target = true,
            b')' => target = false,
            byte if byte.is_ascii_digit() && !code && !target => {
                let mut end = at + 1;
                while end < bytes.len() {
                    let goes_on = match bytes[end] {
                        b'.' | b',' => bytes.get(end + 1).is_some_and(u8::is_ascii_digit),
                        byte => byte.is_ascii_digit(),
                    };
                    if !goes_on {
                        break;
                    }
                    end += 1;
                }
                let after = bytes.get(end).copied().unwrap_or(b' ');
                let is_name = |byte: u8| byte.is_ascii_alphanumeric() || b"_^".contains(&byte);
                // As in `SpaRW-6`.
                let earlier = at.checked_sub(2).map_or(b' ', |n| bytes[n]);
                let is_joined = before == b'-' && is_name(earlier);
                if !is_name(before) && !is_name(after) && !is_joined {
                    let is_negative = before == b'-';
                    found.push(at - usize::from(is_negative)..end);
                }
                at = end;
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    found
}

/// A value by a pointer whose steps may be `[key=value]`.
fn pointed<'a>(value: &'a Value, pointer: &str) -> Option<&'a Value> {
    let mut value = value;
    let mut rest = pointer.strip_prefix('/')?;
    while !rest.is_empty() {
        if let Some(inner) = rest.strip_prefix('[') {
            let (conditions, after) = inner.split_once(']')?;
            let holds = |own: &Value, condition: &str| {
                let (key, expected) = condition.split_once('=')?;
                let found = pointed(own, &format!("/{key}")).and_then(Value::as_str);
                (found == Some(expected)).then_some(())
            };
            let is_it = |own: &&Value| conditions.split('&').all(|one| holds(own, one).is_some());
            value = value.as_array()?.iter().find(is_it)?;
            rest = after.strip_prefix('/').unwrap_or(after);
        } else {
            let (step, after) = rest.split_once('/').unwrap_or((rest, ""));
            value = match step.parse::<usize>() {
                Ok(n) if value.is_array() => value.get(n)?,
                _ => value.get(step)?,
            };
            rest = after;
        }
    }
    Some(value)
}

/// A number of a report: a value by its pointer, or several that are added, multiplied or divided
/// from left to right.
fn number(report: &Value, expression: &str) -> Option<f64> {
    let of = |pointer: &str| pointed(report, pointer).and_then(Value::as_f64);
    // Names in brackets may have blanks; a pointer begins with a slash.
    let next = |text: &str| {
        let operators = [" + /", " * /", " / /"];
        operators.iter().filter_map(|own| text.find(own)).min()
    };
    let end = next(expression).unwrap_or(expression.len());
    let mut value = of(&expression[..end])?;
    let mut rest = &expression[end..];
    while !rest.is_empty() {
        let (operator, other) = (&rest[1..2], &rest[3..]);
        let end = next(other).unwrap_or(other.len());
        let operand = of(&other[..end])?;
        value = match operator {
            "+" => value + operand,
            "*" => value * operand,
            _ => value / operand,
        };
        rest = &other[end..];
    }
    Some(value)
}

/// A number as the documents have it.
fn formatted(value: f64, format: &str) -> String {
    if let Some(rest) = format.strip_prefix('.') {
        let (decimals, scale) = if let Some((decimals, power)) = rest.split_once('e') {
            (decimals, format!("1e{power}").parse().unwrap())
        } else if let Some(decimals) = rest.strip_suffix("Mi") {
            (decimals, 2f64.powi(-20))
        } else if let Some(decimals) = rest.strip_suffix("Gi") {
            (decimals, 2f64.powi(-30))
        } else {
            (rest, 1.0)
        };
        return format!("{:.*}", decimals.parse().unwrap(), value * scale);
    }
    let digits = format!("{value:.0}");
    if format != "," {
        return digits;
    }
    let mut text = String::new();
    for (n, digit) in digits.chars().enumerate() {
        if n > 0 && digit != '-' && (digits.len() - n) % 3 == 0 && !text.ends_with('-') {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Cells of a line of a printed table with the columns of text that they take; cells are two blanks
/// apart.
fn cells(line: &str) -> Vec<(std::ops::Range<usize>, &str)> {
    let mut found = vec![];
    let mut at = 0;
    for part in line.split("  ") {
        let own = part.trim_matches([' ', '|']);
        if !own.is_empty() {
            let lead = part.find(own).unwrap_or_default();
            let start = at + part[..lead].chars().count();
            found.push((start..start + own.chars().count(), own));
        }
        at += part.chars().count() + 2;
    }
    found
}

/// A cell of the first printed table that has the row and the column, which stands above the cell.
fn cell<'a>(printed: &'a str, row: &str, column: &str) -> Option<&'a str> {
    let lines: Vec<_> = printed.lines().map(cells).collect();
    for (n, head) in lines.iter().enumerate() {
        let Some((above, _)) = head.iter().find(|(_, own)| *own == column) else {
            continue;
        };
        // A table ends with an empty line.
        let mut rows = lines[n + 1..].iter().take_while(|cells| !cells.is_empty());
        if let Some(cells) = rows.find(|cells| cells[0].1 == row) {
            let mut below = cells.iter().skip(1);
            let found = below.find(|(own, _)| own.start < above.end && above.start < own.end);
            return found.map(|(_, cell)| *cell);
        }
    }
    None
}

/// What commands print and write, run one after another in an empty folder.
pub(super) struct Printed {
    /// Contents by name.
    files: BTreeMap<String, Vec<u8>>,
    texts: Vec<String>,
}

impl Printed {
    /// Writes the files into a folder.
    pub(super) fn write_files(&self, folder: &Path) {
        for (name, bytes) in &self.files {
            std::fs::write(folder.join(name), bytes).unwrap();
        }
    }
}

type Said = Arc<OnceLock<Result<Printed, String>>>;

/// The same of each sequence of commands, which runs once for all tests. `is_wide`: tables have all their
/// columns.
fn said(commands: &[&str], is_wide: bool) -> Said {
    static KEPT: Mutex<BTreeMap<(String, bool), Said>> = Mutex::new(BTreeMap::new());
    let mut all = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    let own = Arc::clone(all.entry((commands.join("; "), is_wide)).or_default());
    drop(all);
    own.get_or_init(|| {
        let start = Instant::now();
        let said = printed(commands, is_wide);
        println!(
            "{:6.1} s  potamoi {}",
            start.elapsed().as_secs_f64(),
            commands.join("; ")
        );
        said
    });
    own
}

/// What a command gave that a quick passage has figures of, which it needs no file for.
pub(super) fn of_command(command: &str) -> Option<Said> {
    let all = pages();
    let has = |page: &std::path::PathBuf| {
        let text = read(page);
        let mut quick = passages(&text).into_iter().filter(|own| !own.is_slow);
        quick.any(|own| own.commands == [command])
    };
    all.iter().any(has).then(|| said(&[command], true))
}

fn printed(commands: &[&str], is_wide: bool) -> Result<Printed, String> {
    let folder = folder_with_docs();
    let mut texts = vec![];
    for command in commands.iter().filter(|command| **command != "files") {
        let command = command.replace(SHARED, "shared");
        let words = shell_words::split(&command).map_err(|error| format!("{command}: {error}"))?;
        let mut arguments: Vec<&str> = words.iter().map(String::as_str).collect();
        arguments.extend(is_wide.then_some("--wide"));
        let done = run(folder.path(), &arguments);
        if !done.status.success() {
            return Err(format!("potamoi {command}: {}", stderr(&done)));
        }
        // Work that another command has counted is not counted again.
        texts.push(stdout(&done).replace("counted earlier", "counted now"));
    }
    let mut files = BTreeMap::new();
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let path = entry.unwrap().path();
        if let (Some(name), Ok(bytes)) = (path.file_name(), std::fs::read(&path)) {
            files.insert(name.to_string_lossy().into_owned(), bytes);
        }
    }
    Ok(Printed { files, texts })
}

/// The same with `2.1 to 2.3` as one, which reads `2.2` where both ends are alike.
fn ranges(text: &str) -> Vec<std::ops::Range<usize>> {
    let mut found: Vec<std::ops::Range<usize>> = vec![];
    for own in numbers(text) {
        match found.last_mut() {
            Some(last) if text[last.end..own.start] == *" to " => last.end = own.end,
            _ => found.push(own),
        }
    }
    found
}

/// Finds numbers, or ranges, in a text.
type Places = fn(&str) -> Vec<std::ops::Range<usize>>;

/// What the numbers of a body are; none of those that stay as they stand.
fn values(
    passage: &Passage<'_>,
    last: &str,
    printed: &Printed,
    places: Places,
) -> Result<Vec<Option<String>>, String> {
    let mut values: Vec<Option<String>> = vec![];
    for line in &passage.values {
        if let Some(count) = line.strip_prefix("skip ") {
            let count: usize = count.parse().map_err(|_| format!("{line}: a count"))?;
            values.extend(std::iter::repeat_n(None, count));
        } else if let Some((row, columns)) = line.split_once(" | ") {
            let (row, text) = match row.strip_prefix("first: ") {
                Some(row) => (row, &*printed.texts[0]),
                None => (row, last),
            };
            for column in columns.split("; ") {
                let cell = cell(text, row, column);
                let cell = cell.ok_or_else(|| format!("{row} | {column}: no such cell"))?;
                let own = places(cell).into_iter().map(|n| Some(cell[n].to_owned()));
                let before = values.len();
                values.extend(own);
                if values.len() == before {
                    return Err(format!("{row} | {column}: `{cell}` has no number"));
                }
            }
        } else {
            let parts = line.split_once(' ').and_then(|(file, rest)| {
                let (pointer, format) = rest.rsplit_once(' ')?;
                Some((file, pointer, format))
            });
            let Some((file, pointer, format)) = parts else {
                return Err(format!("{line}: FILE /POINTER FORMAT"));
            };
            let report = match printed.files.get(file) {
                Some(made) => serde_json::from_slice(made).unwrap(),
                None => crate::common::json(&root().join(file)),
            };
            let value = number(&report, pointer);
            let value = value.ok_or_else(|| format!("{line}: no such number"))?;
            values.push(Some(formatted(value, format)));
        }
    }
    Ok(values)
}

/// The body as the program has it.
fn current(passage: &Passage<'_>, body: &str, printed: &Printed) -> Result<String, String> {
    let last = printed.texts.last().map_or("", String::as_str);
    let block = passage
        .values
        .iter()
        .find_map(|line| line.strip_prefix("output"));
    if let Some(from) = block {
        let from = from.strip_prefix(" from ").unwrap_or_default();
        let lines = last.lines().skip_while(|line| !line.starts_with(from));
        let lines: Vec<_> = lines.map(str::trim_end).collect();
        let text = lines.join("\n");
        return Ok(format!("\n```text\n{}\n```\n", text.trim_end()));
    }
    // A range may have become one number, or the other way round.
    let ways: [Places; 2] = [numbers, ranges];
    let mut fitting = None;
    for way in ways {
        let (values, places) = (values(passage, last, printed, way)?, way(body));
        if values.len() == places.len() {
            fitting = Some((values, places));
            break;
        }
    }
    let Some((values, places)) = fitting else {
        let own: Vec<_> = numbers(body).iter().map(|n| &body[n.clone()]).collect();
        let named = values(passage, last, printed, numbers)?.len();
        return Err(format!("{named} figures are named, the text has {own:?}"));
    };
    let (mut text, mut at) = (String::new(), 0);
    for (place, value) in places.into_iter().zip(values) {
        text.push_str(&body[at..place.start]);
        text.push_str(value.as_deref().unwrap_or(&body[place.clone()]));
        at = place.end;
    }
    text.push_str(&body[at..]);
    Ok(text)
}

/// Compares or writes all passages that are slow, or all that are not; gives their count.
fn check(slow: bool) -> usize {
    let is_refresh = std::env::var_os("POTAMOI_REFRESH").is_some();
    // Of one page alone, where they are written; all are compared.
    let only = std::env::var("POTAMOI_PAGE").ok().filter(|_| is_refresh);
    let is_chosen = |page: &std::path::PathBuf| match &only {
        Some(word) => name(page).contains(word.as_str()),
        None => true,
    };
    let (mut count, mut skipped, mut wrong) = (0, 0, String::new());
    for page in pages().into_iter().filter(is_chosen) {
        let text = read(&page);
        let mut now = text.clone();
        // From the last, so that places before it stay.
        for passage in passages(&text).iter().rev().filter(|p| p.is_slow == slow) {
            count += 1;
            let is_real = passage.commands.iter().any(|own| own.contains(SHARED));
            if is_real && shared().is_none() {
                skipped += 1;
                continue;
            }
            let body = &text[passage.body.clone()];
            // A block of output is what a user sees.
            let is_wide = !passage
                .values
                .iter()
                .any(|value| value.starts_with("output"));
            let own = match said(&passage.commands, is_wide).get() {
                Some(Ok(said)) => current(passage, body, said),
                Some(Err(why)) => Err(why.clone()),
                None => unreachable!("it was run"),
            };
            match own {
                Ok(own) => now.replace_range(passage.body.clone(), &own),
                Err(why) => {
                    let _ = writeln!(wrong, "{}: {why}", name(&page));
                }
            }
        }
        if now == text {
            continue;
        }
        if is_refresh {
            std::fs::write(&page, &now).unwrap();
            continue;
        }
        for (old, new) in text
            .lines()
            .zip(now.lines())
            .filter(|(old, new)| old != new)
        {
            let _ = writeln!(wrong, "{}\n- {old}\n+ {new}", name(&page));
        }
        let _ = writeln!(
            wrong,
            "{} is not current: make figures writes it",
            name(&page)
        );
    }
    println!("{count} passages, {skipped} of them skipped for lack of {SHARED}");
    assert!(wrong.is_empty(), "{wrong}");
    count
}

#[test]
fn figures_in_the_documents_are_the_programs() {
    let is_one = std::env::var_os("POTAMOI_PAGE").is_some();
    assert!(check(false) >= 5 || is_one);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn slow_figures_in_the_documents_are_the_programs() {
    let is_one = std::env::var_os("POTAMOI_PAGE").is_some();
    assert!(check(true) >= 2 || is_one);
}

#[test]
fn numbers_are_told_from_names_and_code() {
    let text = "Of 3DGS `12` DS-2 [a](b1.md) at -1.5 dB, 15,232 (2.0) x4 and 5, 6.";
    let found: Vec<_> = numbers(text).into_iter().map(|n| &text[n]).collect();
    assert_eq!(found, ["-1.5", "15,232", "2.0", "5", "6"]);
    assert_eq!(formatted(1_234_567.4, ","), "1,234,567");
    assert_eq!(formatted(-123_456.0, ","), "-123,456");
    assert_eq!(formatted(0.126, ".2"), "0.13");
    assert_eq!(formatted(1234.0, ".1e-3"), "1.2");
    let report = serde_json::json!({"a": [{"n": {"m": "x"}, "v": 1}, {"n": {"m": "y"}, "v": 2}]});
    assert_eq!(pointed(&report, "/a/[n/m=y]/v").unwrap(), 2);
    assert_eq!(pointed(&report, "/a/0/v").unwrap(), 1);
    assert!(pointed(&report, "/a/[n/m=z]/v").is_none());
    assert_eq!(number(&report, "/a/1/v * /a/1/v / /a/0/v"), Some(4.0));
    assert_eq!(number(&report, "/a/0/v + /a/1/v * /a/1/v"), Some(6.0));
    assert_eq!(number(&report, "/a/[n/m=x]/v / /a/[n/m=y]/v"), Some(0.5));
    assert_eq!(number(&report, "/a/1/v - /a/1/v"), None);
    assert_eq!(formatted(1.5 * 1024.0 * 1024.0, ".1Mi"), "1.5");
    let table = "words\n\n| name  speed-up  gap  dB |\n| one   2.00 (3)        1 |\n| two    4.0 (5)    8   7 |\n\n two  8\n";
    assert_eq!(cell(table, "two", "speed-up"), Some("4.0 (5)"));
    assert_eq!(cell(table, "one", "dB"), Some("1"));
    assert_eq!(cell(table, "one", "gap"), None);
    assert_eq!(cell(table, "three", "dB"), None);
}

/// A figure that is not the program's is corrected, and nothing else of the passage.
#[test]
fn a_wrong_figure_is_found() {
    let text = "<!-- figures: doctor --json d.json\nd.json /format_version 0\nskip 1\n-->\n\
                Version 77 of 5 kinds.\n<!-- end -->";
    let found = passages(text);
    let said = printed(&found[0].commands, true).unwrap();
    let body = &text[found[0].body.clone()];
    let now = current(&found[0], body, &said).unwrap();
    assert!(
        now.starts_with("\nVersion ") && now.ends_with(" of 5 kinds.\n"),
        "{now}"
    );
    assert!(!now.contains("77"), "{now}");
    let quoted = "between `<!-- figures: COMMAND` and `<!-- end -->`";
    assert!(passages(quoted).is_empty());
    let more = format!("{body} 9");
    let refused = current(&found[0], &more, &said).unwrap_err();
    assert!(refused.contains("2 figures are named"), "{refused}");
}
