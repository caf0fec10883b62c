//! Wavefront OBJ: lines `v` and `f`; all others are listed or refused. The reader is our own,
//! since no library reports the line of an error.

use super::keys::OBJ;
use super::{Parts, judged, wrong};
use crate::mesh::{Mesh, MeshError};
use potamoi_base::file_keys::{FileKeys, Notes};

/// Maximum length of a value in messages, in characters.
const SHOWN: usize = 40;
/// Maximum number of first words that are listed.
const MAX_WORDS: usize = 64;
/// The byte order mark that some editors prepend.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Reads a mesh and its unused parts; `origin` names the bytes in errors. Faces become triangle
/// fans from their first corner.
///
/// # Errors
/// A vertex does not have three finite coordinates, a face has fewer than three corners or refers
/// to a vertex that the file does not have, there is no face, or a line describes the surface in
/// a way that is not supported. Vertices may follow the faces that refer to them.
pub fn read_obj(bytes: &[u8], origin: &str) -> Result<(Mesh, Notes), MeshError> {
    let mut parts = Parts::default();
    let mut record = FileKeys::new(&OBJ, []);
    let mut joined = vec![];
    let mut farthest = None;
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let mut lines = lines(bytes).enumerate().peekable();
    while let Some((number, line)) = lines.next() {
        // A backslash at its end: the line goes on, if any follows.
        let begun = line.strip_suffix(b"\\");
        joined.extend_from_slice(begun.unwrap_or(line));
        if begun.is_some() && lines.peek().is_some() {
            joined.push(b' ');
            continue;
        }
        let line = Line {
            origin,
            number: number + 1,
        };
        line.take(&joined, &mut parts, &mut record, &mut farthest)?;
        joined.clear();
    }
    if let Some(ahead) = farthest.filter(|own| own.vertex as usize >= parts.vertices.len()) {
        let (number, there) = (ahead.line, parts.vertices.len());
        let expected = format!("the number of one of the {there} vertices");
        return Err(Line { origin, number }.wrong(CORNER, ahead.word, &expected));
    }
    let notes = judged(record, origin)?;
    Ok((parts.finish(origin)?, notes))
}

/// Lines without their ends: line feed, carriage return, or both.
fn lines(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = Some(bytes);
    std::iter::from_fn(move || {
        let all = rest?;
        let Some(end) = all.iter().position(|b| matches!(b, b'\n' | b'\r')) else {
            return rest.take();
        };
        let both = all[end..].starts_with(b"\r\n");
        rest = all.get(end + 1 + usize::from(both)..);
        Some(&all[..end])
    })
}

/// Adds a first word once.
fn list(record: &mut FileKeys<()>, word: String) {
    if record.keys().count() < MAX_WORDS && !record.has(&word) {
        record.add(word, ());
    }
}

/// What errors call a corner.
const CORNER: &str = "vertex of a face";

/// The last of the vertices that faces name before it is there.
struct Ahead {
    /// From 0.
    vertex: u32,
    line: usize,
    word: String,
}

struct Line<'a> {
    origin: &'a str,
    number: usize,
}

impl Line<'_> {
    /// Processes a line.
    fn take(
        &self,
        line: &[u8],
        parts: &mut Parts,
        record: &mut FileKeys<()>,
        farthest: &mut Option<Ahead>,
    ) -> Result<(), MeshError> {
        let mut halves = line.splitn(2, |b| *b == b'#');
        let mut words = halves
            .next()
            .unwrap_or_default()
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty());
        match words.next() {
            Some(b"v") => {
                let mut at = [0.0; 3];
                let mut each = vec![];
                for (to, name) in at.iter_mut().zip(["x", "y", "z"]) {
                    let word = words.next();
                    *to = self.coordinate(name, word)?;
                    each.push(word.unwrap_or_default());
                }
                parts.vertex(at).map_err(|axis| {
                    let field = format!("coordinate {}", ["x", "y", "z"][axis]);
                    self.wrong(&field, shown(each[axis]), "a finite number")
                })?;
                let more: Result<Vec<f64>, _> = words
                    .map(|word| self.coordinate("behind z", Some(word)))
                    .collect();
                match more?[..] {
                    [] | [1.0] => {}
                    [_] => list(record, "weight of v".to_owned()),
                    _ => list(record, "colour of v".to_owned()),
                }
            }
            Some(b"f") => {
                let there = parts.vertices.len();
                let mut corners = vec![];
                for word in words {
                    let vertex = self.corner(word, there, record)?;
                    let last = farthest.as_ref().map(|own| own.vertex);
                    if vertex as usize >= there && last.is_none_or(|last| last < vertex) {
                        let (line, word) = (self.number, shown(word));
                        *farthest = Some(Ahead { vertex, line, word });
                    }
                    corners.push(vertex);
                }
                if corners.len() < 3 {
                    let found = format!("{} corners", corners.len());
                    return Err(self.wrong("face", found, "3 or more"));
                }
                if !parts.polygon(&corners) {
                    return Err(self.wrong("faces", "too many", "at most 2^27 triangles"));
                }
            }
            Some(word) => list(record, shown(word)),
            None => {}
        }
        if halves.next().is_some() {
            list(record, "# (comments)".to_owned());
        }
        Ok(())
    }

    fn wrong(&self, field: &str, value: impl ToString, expected: &str) -> MeshError {
        let field = format!("line {}, {field}", self.number);
        wrong(self.origin, field, value, expected)
    }

    fn coordinate(&self, name: &str, word: Option<&[u8]>) -> Result<f64, MeshError> {
        let parsed = word
            .and_then(|w| std::str::from_utf8(w).ok())
            .and_then(|w| w.parse::<f64>().ok())
            .filter(|v| v.is_finite());
        parsed.ok_or_else(|| {
            let field = format!("coordinate {name}");
            self.wrong(&field, shown(word.unwrap_or(b"missing")), "a finite number")
        })
    }

    /// The vertex of `7`, `7/1`, `7//3` or `7/1/3`, from 0; -1 is the last of those `there`. It may
    /// be one that comes later. The other numbers are of textures and normals.
    fn corner(
        &self,
        word: &[u8],
        there: usize,
        record: &mut FileKeys<()>,
    ) -> Result<u32, MeshError> {
        let number = |part: &[u8]| std::str::from_utf8(part).ok()?.parse::<i64>().ok();
        let mut parts = word.split(|b| *b == b'/');
        let vertex = parts.next().and_then(number).and_then(|own| match own {
            1.. => u32::try_from(own - 1).ok(),
            _ => {
                let back = usize::try_from(own.checked_neg()?).ok()?;
                let vertex = there.checked_sub(back).filter(|own| *own < there)?;
                u32::try_from(vertex).ok()
            }
        });
        let vertex = vertex.ok_or_else(|| {
            let expected = format!("the number of one of the {there} vertices before");
            self.wrong(CORNER, shown(word), &expected)
        })?;
        let mut names = ["texture of f", "normal of f"].into_iter();
        for part in parts {
            let name = names.next();
            // Nothing between two strokes says nothing.
            let is_right = part.is_empty() || number(part).is_some_and(|own| own != 0);
            let Some(name) = name.filter(|_| is_right) else {
                let expected = "numbers of a vertex, a texture and a normal: 7, 7/1, 7//3 or 7/1/3";
                return Err(self.wrong("corner of a face", shown(word), expected));
            };
            if !part.is_empty() {
                list(record, name.to_owned());
            }
        }
        Ok(vertex)
    }
}

fn shown(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(word);
    let short: String = text.chars().take(SHOWN).collect();
    short.escape_debug().to_string()
}
