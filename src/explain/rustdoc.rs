//! Structures and enumerations of a source text, with the documentation of their fields and values.

use std::collections::BTreeMap;

/// A field of a structure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) meaning: String,
}

/// What some source texts define: structures with their fields, enumerations with their values.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    pub(super) structs: BTreeMap<String, Vec<Field>>,
    pub(super) enums: BTreeMap<String, Vec<Field>>,
}

/// The name after a keyword, as in `pub struct Name {`.
fn defined<'a>(line: &'a str, keyword: &str) -> Option<&'a str> {
    let line = line.strip_prefix("pub ").unwrap_or(line);
    let rest = line.strip_prefix(keyword)?.strip_suffix('{')?;
    Some(rest.trim())
}

/// Documentation in plain words: links are what they name. What follows an empty line is for readers of
/// the source text alone.
fn plain(lines: &[&str]) -> String {
    let paragraph: Vec<&str> = lines
        .iter()
        .copied()
        .take_while(|own| !own.is_empty())
        .collect();
    let text = paragraph.join(" ");
    let mut out = String::with_capacity(text.len());
    let mut rest = &*text;
    // `[`name`]`, and `[name](place)`.
    while let Some((before, after)) = rest.split_once('[') {
        let Some((inner, tail)) = after.split_once(']') else {
            break;
        };
        let is_link = inner.starts_with('`') || tail.starts_with('(');
        out.push_str(before);
        match is_link {
            true => {
                out.push_str(inner);
                rest = match tail.strip_prefix('(').and_then(|own| own.split_once(')')) {
                    Some((_, tail)) => tail,
                    None => tail,
                };
            }
            false => {
                out.push('[');
                rest = after;
            }
        }
    }
    out + rest
}

impl Definitions {
    /// Adds what a source text defines at its first level.
    pub(super) fn read(&mut self, source: &str) {
        let mut docs: Vec<&str> = vec![];
        let mut within: Option<(String, bool)> = None;
        for line in source.lines() {
            let bare = line.trim();
            if let Some(doc) = bare.strip_prefix("///") {
                docs.push(doc.trim());
                continue;
            }
            if bare.starts_with("#[") || bare.starts_with("//") {
                continue;
            }
            if line == "}" {
                within = None;
            } else if let Some(name) = defined(line, "struct ") {
                within = Some((name.to_owned(), true));
            } else if let Some(name) = defined(line, "enum ") {
                within = Some((name.to_owned(), false));
            } else if let Some((own, is_struct)) = &within {
                let meaning = plain(&docs);
                match (is_struct, bare.strip_suffix(',')) {
                    (true, Some(field)) => {
                        let field = field
                            .strip_prefix("pub ")
                            .and_then(|own| own.split_once(": "));
                        if let Some((name, kind)) = field {
                            self.structs.entry(own.clone()).or_default().push(Field {
                                name: name.to_owned(),
                                kind: kind.to_owned(),
                                meaning,
                            });
                        }
                    }
                    (false, Some(name)) => {
                        self.enums.entry(own.clone()).or_default().push(Field {
                            name: kebab(name),
                            kind: String::new(),
                            meaning,
                        });
                    }
                    _ => {}
                }
            }
            docs.clear();
        }
    }
}

/// The name of a value in a file: `FeatureMajor` as `feature-major`.
fn kebab(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !out.is_empty() {
            out.push('-');
        }
        out.extend(c.to_lowercase());
    }
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn fields_and_values_are_found_with_their_documentation() {
        let mut found = Definitions::default();
        found.read(
            "/// A unit.\npub struct Unit {\n    /// Lanes, see [`Other::lanes`] and [a page](b.md).\n    \
             /// Two lines [0, 1].\n    ///\n    /// `None` here.\n    #[serde(default)]\n    pub lanes: Option<u32>,\n    hidden: u32,\n}\n\n\
             pub enum Kind {\n    /// First.\n    OneOfThem,\n    Two,\n}\n\
             impl Unit {\n    /// No field.\n    fn lanes(&self) {}\n}\n",
        );
        let lanes = &found.structs["Unit"];
        assert_eq!(lanes.len(), 1);
        assert_eq!((&*lanes[0].name, &*lanes[0].kind), ("lanes", "Option<u32>"));
        assert_eq!(
            lanes[0].meaning,
            "Lanes, see `Other::lanes` and a page. Two lines [0, 1]."
        );
        let names: Vec<_> = found.enums["Kind"].iter().map(|own| &*own.name).collect();
        assert_eq!(names, ["one-of-them", "two"]);
        assert_eq!(found.enums["Kind"][1].meaning, "");
    }
}
