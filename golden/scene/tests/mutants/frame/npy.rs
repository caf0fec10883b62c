//! NPY arrays.

use super::flat::{self, Kind};
use super::{Rng, pickle};

/// Bytes before the header of version 1: magic, version, length.
const HEAD: usize = 10;

/// Changes an array of version 1: a number of it, its header, or what it weighs. Objects are
/// pickles.
pub(crate) fn mutate(bytes: &mut Vec<u8>, rng: &mut Rng) {
    let length = bytes
        .get(8..HEAD)
        .map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])));
    let begin = HEAD + length.unwrap_or_default();
    if !bytes.starts_with(b"\x93NUMPY\x01") || begin > bytes.len() {
        return rng.damage(bytes);
    }
    let text = String::from_utf8_lossy(&bytes[HEAD..begin]).into_owned();
    if rng.one_in(4) {
        let text = header(text.trim_end(), rng);
        let length = (HEAD + text.len() + 1).next_multiple_of(64) - HEAD;
        let told = if rng.one_in(8) { length + 1 } else { length } as u16;
        let text = format!("{text:0$}\n", length - 1);
        bytes
            .splice(8..begin, told.to_le_bytes().into_iter().chain(text.bytes()))
            .for_each(drop);
        return;
    }
    let mut body = bytes.split_off(begin);
    if text.contains("'|O'") {
        body = pickle::mutate(&body, rng);
    } else if rng.one_in(5) {
        flat::change(&mut body, rng, &[width(&text)]);
    } else {
        flat::number(&mut body, kind(&text), rng);
    }
    bytes.append(&mut body);
}

fn width(header: &str) -> usize {
    let at = header.find("'descr': '").map_or(0, |at| at + 12);
    let digit = header.get(at..=at).and_then(|d| d.parse().ok());
    digit.filter(|n| [1, 2, 4, 8].contains(n)).unwrap_or(1)
}

fn kind(header: &str) -> Kind {
    match (
        header.contains("'<f") || header.contains("'|f"),
        width(header),
    ) {
        (true, 2) => Kind::Half,
        (true, 4) => Kind::Float,
        (true, 8) => Kind::Double,
        (_, bytes) => Kind::Whole(bytes),
    }
}

/// Another type, order or shape.
fn header(text: &str, rng: &mut Rng) -> String {
    const TYPES: [&str; 10] = [
        "'<f4'", "'<f8'", "'<f2'", "'>f4'", "'|u1'", "'<i8'", "'<i4'", "'|b1'", "'|O'", "'<U5'",
    ];
    match rng.below(4) {
        0 => {
            let from = text.find("'descr': ").map_or(0, |at| at + 9);
            let to = text[from..].find(',').map_or(text.len(), |at| from + at);
            format!("{}{}{}", &text[..from], rng.pick(&TYPES), &text[to..])
        }
        1 => text.replace("False", "True"),
        2 => {
            let from = text.find("'shape': (").map_or(0, |at| at + 10);
            let to = text[from..].find(')').map_or(text.len(), |at| from + at);
            let mut sides: Vec<String> = text[from..to]
                .split(',')
                .map(|s| s.trim().to_owned())
                .collect();
            let at = rng.below(sides.len());
            match rng.below(4) {
                0 => sides.insert(at, "1".to_owned()),
                1 => sides.reverse(),
                _ => {
                    let near = sides[at].parse().unwrap_or(1);
                    sides[at] = rng.integer(near).to_string();
                }
            }
            format!("{}{}{}", &text[..from], sides.join(", "), &text[to..])
        }
        _ => rng.text(text).replace('\0', " "),
    }
}
