//! Declarations of modules and their ports in the text of a Verilog file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A port as declared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Declared {
    pub(super) output: bool,
    /// Bits; `None` if they are not written as numbers.
    pub(super) width: Option<u32>,
}

/// A module in a file.
#[derive(Debug, Clone)]
pub(super) struct Source {
    pub(super) path: PathBuf,
    pub(super) ports: BTreeMap<String, Declared>,
    /// Words of its text, the names of the modules that it uses among them.
    pub(super) words: BTreeSet<String>,
}

/// The modules of a file by name.
pub(super) fn modules(path: &Path, text: &str) -> Vec<(String, Source)> {
    let tokens = tokens(text);
    let mut found = vec![];
    let mut rest = &tokens[..];
    while let Some(begin) = rest.iter().position(|t| *t == "module") {
        let end = rest[begin..].iter().position(|t| *t == "endmodule");
        let end = end.map_or(rest.len(), |end| begin + end);
        if let Some(name) = rest.get(begin + 1) {
            let body = &rest[(begin + 2).min(end)..end];
            let source = Source {
                path: path.to_owned(),
                ports: ports(body),
                words: body
                    .iter()
                    .filter(|t| is_name(t))
                    .map(|t| (*t).to_owned())
                    .collect(),
            };
            found.push(((*name).to_owned(), source));
        }
        rest = &rest[end..];
    }
    found
}

/// Words, numbers and signs without comments, attributes and strings.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = vec![];
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let skip = |end: &str| rest.find(end).map_or(rest.len(), |at| at + end.len());
        let taken = if rest.starts_with("//") {
            skip("\n")
        } else if rest.starts_with("/*") {
            skip("*/")
        } else if rest.starts_with("(*") && !rest.starts_with("(*)") {
            skip("*)")
        } else if first == '"' {
            2 + rest[1..].find('"').unwrap_or(rest.len().saturating_sub(2))
        } else if first.is_whitespace() {
            first.len_utf8()
        } else {
            let is_word = |c: char| c.is_alphanumeric() || "_$'".contains(c);
            let length = match first {
                // An escaped name ends with a space.
                '\\' => rest.find(char::is_whitespace).unwrap_or(rest.len()),
                _ if is_word(first) => rest.find(|c| !is_word(c)).unwrap_or(rest.len()),
                _ => first.len_utf8(),
            };
            tokens.push(rest[..length].trim_start_matches('\\'));
            length
        };
        rest = rest.get(taken..).unwrap_or_default();
    }
    tokens
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Ports that are declared in the list of ports, or in the body.
fn ports(body: &[&str]) -> BTreeMap<String, Declared> {
    const KINDS: [&str; 5] = ["wire", "reg", "logic", "signed", "var"];
    let mut ports = BTreeMap::new();
    let mut open: Option<Declared> = None;
    let mut i = 0;
    // A task or function has inputs of its own.
    let mut inner = false;
    while i < body.len() {
        let token = body[i];
        i += 1;
        match token {
            "function" | "task" => inner = true,
            "endfunction" | "endtask" => inner = false,
            _ if inner => {}
            "input" | "output" => {
                let mut own = Declared {
                    output: token == "output",
                    width: Some(1),
                };
                while body.get(i).is_some_and(|t| KINDS.contains(t)) {
                    i += 1;
                }
                if body.get(i) == Some(&"[") {
                    let end = body[i..]
                        .iter()
                        .position(|t| *t == "]")
                        .map_or(body.len(), |e| i + e);
                    own.width = width(&body[i + 1..end]);
                    i = (end + 1).min(body.len());
                }
                open = Some(own);
            }
            "," => {}
            ";" | ")" => open = None,
            name if is_name(name) => {
                if let Some(own) = open {
                    ports.insert(name.to_owned(), own);
                }
            }
            _ => open = None,
        }
    }
    ports
}

/// Bits of a range `msb : lsb` of numbers.
fn width(range: &[&str]) -> Option<u32> {
    let [high, ":", low] = range else { return None };
    let (high, low): (u32, u32) = (high.parse().ok()?, low.parse().ok()?);
    high.abs_diff(low).checked_add(1)
}
