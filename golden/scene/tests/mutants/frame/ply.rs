//! PLY files by their header's lines and their elements' numbers.

use super::Rng;
use super::flat::{self, Kind};

const TYPES: [&str; 14] = [
    "char",
    "uchar",
    "short",
    "ushort",
    "int",
    "uint",
    "float",
    "double",
    "int8",
    "uint8",
    "float32",
    "float64",
    "half",
    "list uchar int",
];

fn kind(name: &str) -> Option<Kind> {
    Some(match name {
        "char" | "uchar" | "int8" | "uint8" => Kind::Whole(1),
        "short" | "ushort" | "int16" | "uint16" => Kind::Whole(2),
        "int" | "uint" | "int32" | "uint32" => Kind::Whole(4),
        "float" | "float32" => Kind::Float,
        "double" | "float64" => Kind::Double,
        _ => return None,
    })
}

/// Places of numbers: offset from the header's end, and kind; of elements without lists.
fn places(lines: &[String]) -> Vec<(usize, Kind)> {
    let (mut at, mut all) = (0, vec![]);
    let mut elements: Vec<(usize, Vec<Kind>)> = vec![];
    for line in lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        match (words.as_slice(), elements.last_mut()) {
            (["element", _, count], _) => elements.push((count.parse().unwrap_or(0), vec![])),
            (["property", name, _], Some((_, kinds))) => kinds.extend(kind(name)),
            _ => {}
        }
    }
    for (count, kinds) in elements {
        for _ in 0..count {
            for kind in &kinds {
                all.push((at, *kind));
                at += kind.bytes();
            }
        }
    }
    all
}

/// A mutant of a whole binary file, little-endian.
pub(crate) fn mutate(bytes: &[u8], rng: &mut Rng) -> Vec<u8> {
    let end = b"end_header\n";
    let at = bytes
        .windows(end.len())
        .position(|w| w == end)
        .expect("a header")
        + end.len();
    let text = String::from_utf8_lossy(&bytes[..at]).into_owned();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut body = bytes[at..].to_vec();
    let places = places(&lines);
    for _ in 0..rng.few() {
        match rng.below(12) {
            0..=4 if !places.is_empty() => flat::field(&mut body, &places, rng),
            5 => flat::change(&mut body, rng, &[1, 4]),
            _ => header(&mut lines, rng),
        }
    }
    let ending = if rng.one_in(20) { "\r\n" } else { "\n" };
    let mut out = (lines.join(ending) + ending).into_bytes();
    out.extend(body);
    if rng.one_in(30) {
        rng.damage(&mut out);
    }
    out
}

fn header(lines: &mut Vec<String>, rng: &mut Rng) {
    // Not the first line, seldom the last.
    let count = lines.len();
    let (at, other) = (
        1 + rng.below(count.max(3) - 2),
        1 + rng.below(count.max(3) - 2),
    );
    let mut words: Vec<String> = lines[at].split(' ').map(str::to_owned).collect();
    match rng.below(10) {
        0 => lines.swap(at, other),
        1 => drop(lines.remove(at)),
        2 => lines.insert(at, lines[other].clone()),
        3 => {
            const COMMENTS: [&str; 6] = [
                "comment SplatRenderMode: mip",
                "comment Vertical Axis: z",
                "comment \u{e9}\u{1f600}",
                "comment",
                "obj_info num_cols 3",
                "nonsense",
            ];
            lines.insert(at, (*rng.pick(&COMMENTS)).to_owned());
        }
        4 => {
            let comment = format!("comment {}", "x".repeat(*rng.pick(&[100, 70_000])));
            lines.insert(at, comment);
        }
        5 => lines.insert(at, "property float unheard_of".to_owned()),
        6 => lines.insert(count - 1, "element more 0".to_owned()),
        _ => {
            let last = words.len() - 1;
            match words[0].as_str() {
                "element" => {
                    words[last] = rng.integer(words[last].parse().unwrap_or(1)).to_string()
                }
                "property" if rng.one_in(2) => words[1] = (*rng.pick(&TYPES)).to_owned(),
                "format" => {
                    const FORMATS: [&str; 4] =
                        ["ascii", "binary_big_endian", "binary_little_endian", "half"];
                    words[1] = (*rng.pick(&FORMATS)).to_owned();
                }
                _ => words[last] = rng.text(&words[last]).replace('\n', " "),
            }
            lines[at] = words.join(" ");
        }
    }
}
