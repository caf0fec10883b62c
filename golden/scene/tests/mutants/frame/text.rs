//! Lines of words.

use super::Rng;

/// Where words begin and end: runs of what is no blank, bracket or mark.
fn words(line: &str) -> Vec<std::ops::Range<usize>> {
    let marks = |c: char| c.is_whitespace() || "(){}:;,\"=".contains(c);
    let mut found = vec![];
    let mut from = None;
    for (at, c) in line.char_indices().chain([(line.len(), ' ')]) {
        match (from, marks(c)) {
            (None, false) => from = Some(at),
            (Some(start), true) => {
                found.push(start..at);
                from = None;
            }
            _ => {}
        }
    }
    found
}

/// Another word in place of one.
fn word(text: &str, rng: &mut Rng) -> String {
    match text.parse::<f64>() {
        Ok(near) if rng.one_in(3) => rng.integer(near as i128).to_string(),
        Ok(near) => rng.float(near).to_string(),
        Err(_) => rng.text(text),
    }
}

/// A mutant of a text.
pub(crate) fn mutate(text: &str, rng: &mut Rng) -> Vec<u8> {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for _ in 0..rng.few() {
        if lines.is_empty() {
            break;
        }
        let (at, other) = (rng.below(lines.len()), rng.below(lines.len()));
        match rng.below(16) {
            0 => drop(lines.remove(at)),
            1 => lines.insert(at, lines[other].clone()),
            2 => lines.swap(at, other),
            3 => lines.truncate(at),
            4 => lines.insert(at, "# a word".to_owned()),
            5 => lines.insert(at, String::new()),
            6 => lines[at] = rng.text(&lines[at]),
            more => {
                let words = words(&lines[at]);
                if words.is_empty() {
                    continue;
                }
                let range = words[rng.below(words.len())].clone();
                let own = lines[at][range.clone()].to_owned();
                let new = match more {
                    7 => String::new(),
                    8 => format!("{own} {own}"),
                    _ => word(&own, rng),
                };
                lines[at].replace_range(range, &new);
            }
        }
    }
    let bytes = (lines.join("\n") + "\n").into_bytes();
    super::tree::around(bytes, rng)
}
