//! Wavefront OBJ: lines `v` and `f`; all others are read past. Read here and not
//! by a library, none of which tells in which line something is wrong.

use super::{Parts, wrong};
use crate::mesh::{Mesh, MeshError};

/// Most characters of a value that an error tells.
const SHOWN: usize = 40;

/// Reads a mesh; `origin` names the bytes in errors. Faces are fanned into
/// triangles from their first corner; texture coordinates, normals, materials,
/// groups and curves are read past.
///
/// # Errors
/// A vertex without three finite coordinates, a face of fewer than three
/// corners or of a vertex that has not come yet, or no face.
pub fn read_obj(bytes: &[u8], origin: &str) -> Result<Mesh, MeshError> {
    let mut parts = Parts::default();
    let mut corners = vec![];
    let mut joined = vec![];
    for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
        // A backslash at its end: the line goes on.
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if let Some(begun) = line.strip_suffix(b"\\") {
            joined.extend_from_slice(begun);
            joined.push(b' ');
            continue;
        }
        joined.extend_from_slice(line);
        let line = Line {
            origin,
            number: number + 1,
        };
        let mut words = joined
            .split(|b| *b == b'#')
            .next()
            .unwrap_or_default()
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty());
        match words.next() {
            Some(b"v") => {
                let mut at = [0.0; 3];
                for (to, name) in at.iter_mut().zip(["x", "y", "z"]) {
                    *to = line.coordinate(name, words.next())?;
                }
                parts.vertices.push(at);
            }
            Some(b"f") => {
                corners.clear();
                for word in words {
                    corners.push(line.corner(word, parts.vertices.len())?);
                }
                if corners.len() < 3 {
                    let found = format!("{} corners", corners.len());
                    return Err(line.wrong("face", found, "3 or more"));
                }
                if !parts.polygon(&corners) {
                    return Err(line.wrong("faces", "too many", "at most 2^27 triangles"));
                }
            }
            _ => {}
        }
        joined.clear();
    }
    parts.finish(origin)
}

struct Line<'a> {
    origin: &'a str,
    number: usize,
}

impl Line<'_> {
    fn wrong(&self, field: &str, value: impl ToString, expected: &str) -> MeshError {
        let field = format!("line {}, {field}", self.number);
        wrong(self.origin, field, value, expected)
    }

    fn coordinate(&self, name: &str, word: Option<&[u8]>) -> Result<f32, MeshError> {
        let parsed = word
            .and_then(|w| std::str::from_utf8(w).ok())
            .and_then(|w| w.parse::<f32>().ok())
            .filter(|v| v.is_finite());
        parsed.ok_or_else(|| {
            let field = format!("coordinate {name}");
            self.wrong(&field, shown(word.unwrap_or(b"missing")), "a finite number")
        })
    }

    /// The vertex of `7`, `7/1`, `7//3` or `7/1/3`; -1 is the last so far.
    fn corner(&self, word: &[u8], vertices: usize) -> Result<u32, MeshError> {
        let number = word.split(|b| *b == b'/').next().unwrap_or_default();
        let parsed = std::str::from_utf8(number).ok();
        let parsed = parsed.and_then(|w| w.parse::<i64>().ok());
        let vertex = parsed.and_then(|n| match n {
            1.. => usize::try_from(n - 1).ok(),
            _ => vertices.checked_sub(usize::try_from(n.checked_neg()?).ok()?),
        });
        let there = vertex.filter(|v| *v < vertices);
        there.and_then(|v| u32::try_from(v).ok()).ok_or_else(|| {
            let expected = format!("the number of one of the {vertices} vertices before");
            self.wrong("vertex of a face", shown(word), &expected)
        })
    }
}

fn shown(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(word);
    let short: String = text.chars().take(SHOWN).collect();
    short.escape_debug().to_string()
}
