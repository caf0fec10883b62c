//! The syntax of Liberty files: groups with arguments, values and groups in them.
//!
//! The crates that read Liberty either do not take the ASAP7 library, take minutes to
//! build, or are under a licence that this project's users could not take
//! (`docs/decisions/0005-reading-liberty.md`).

use super::SynthError;
use potamoi_base::file_keys::told;

/// Largest depth of nested groups; libraries have five.
const MAX_DEPTH: u32 = 32;

/// A group: `kind (arguments) { ... }`.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Group {
    pub(super) kind: String,
    pub(super) arguments: Vec<String>,
    /// Attributes in order.
    pub(super) values: Vec<Attribute>,
    pub(super) groups: Vec<Group>,
    /// Line on which it begins, from 1.
    pub(super) line: usize,
}

/// `name : value;` or `name (value, ...);`.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Attribute {
    pub(super) name: String,
    pub(super) values: Vec<String>,
    /// Line on which it begins, from 1.
    pub(super) line: usize,
}

impl Group {
    /// The value of an attribute, if present.
    pub(super) fn value(&self, name: &str) -> Option<&str> {
        let found = self.values.iter().find(|own| own.name == name);
        found?.values.first().map(String::as_str)
    }

    pub(super) fn groups<'a>(&'a self, kind: &'a str) -> impl Iterator<Item = &'a Group> {
        self.groups.iter().filter(move |g| g.kind == kind)
    }

    pub(super) fn name(&self) -> &str {
        self.arguments.first().map_or("", String::as_str)
    }

    /// The numbers of an attribute. Fails with the first text that is not a number.
    pub(super) fn numbers(&self, name: &str) -> Result<Vec<f64>, String> {
        let found = self.values.iter().filter(|own| own.name == name);
        let words = found.flat_map(|own| &own.values);
        let words = words.flat_map(|v| v.split([',', ' ', '\t', '\n', '\r', '\\']));
        let number = |word: &str| {
            let number = word.parse().ok().filter(|v: &f64| v.is_finite());
            number.ok_or_else(|| word.to_owned())
        };
        words.filter(|w| !w.is_empty()).map(number).collect()
    }

    /// An error in this group of the file `path`.
    pub(super) fn wrong(&self, path: &str, expected: &str, found: &str) -> SynthError {
        SynthError::Liberty {
            path: path.to_owned(),
            line: self.line,
            expected: format!(
                "{expected} in the {} `{}`",
                told(&self.kind),
                told(self.name())
            ),
            found: format!("`{}`", told(found)),
        }
    }
}

/// A number with a unit, a power of ten of `base`, converted to the unit ten to the power of `of`.
pub(super) fn scaled(text: &str, base: char, of: i32) -> Option<f64> {
    let at = text.find(|c: char| c.is_alphabetic())?;
    let (number, unit) = text.split_at(at);
    let unit = unit.trim().to_ascii_lowercase();
    let power = match unit.strip_suffix(base)? {
        "m" => -3,
        "u" => -6,
        "n" => -9,
        "p" => -12,
        "f" => -15,
        "" => 0,
        _ => return None,
    };
    let number: f64 = number.trim().parse().ok()?;
    let scaled = number * 10f64.powi(power - of);
    (scaled.is_finite() && scaled > 0.0).then_some(scaled)
}

/// Reads the library of a file; `origin` names it in errors.
pub(super) fn parse(text: &str, origin: &str) -> Result<Group, SynthError> {
    let mut reader = Reader {
        rest: text,
        line: 1,
        origin,
    };
    let line = reader.skip();
    let kind = reader.word("`library`")?;
    if kind != "library" {
        return Err(reader.wrong(line, "`library`", &kind));
    }
    let library = match reader.member(kind, line, 0)? {
        Member::Group(group) => group,
        Member::Value(..) => return Err(reader.wrong(line, "`library (name) {`", "no group")),
    };
    reader.skip();
    match reader.rest.chars().next() {
        None => Ok(library),
        Some(c) => Err(reader.wrong(reader.line, "the end of the file", &c.to_string())),
    }
}

enum Member {
    Value(String, Vec<String>),
    Group(Group),
}

struct Reader<'a> {
    rest: &'a str,
    line: usize,
    origin: &'a str,
}

impl Reader<'_> {
    fn wrong(&self, line: usize, expected: &str, found: &str) -> SynthError {
        SynthError::Liberty {
            path: self.origin.to_owned(),
            line,
            expected: expected.to_owned(),
            found: found.chars().take(40).collect(),
        }
    }

    /// Text at this position, for errors.
    fn here(&self) -> String {
        match self.rest.chars().next() {
            None => "the end of the file".to_owned(),
            Some('\n' | '\r') => "the end of the line".to_owned(),
            Some(c) => format!("`{c}`"),
        }
    }

    fn advance(&mut self, bytes: usize) {
        let (past, rest) = self.rest.split_at(bytes);
        self.line += past.matches('\n').count();
        self.rest = rest;
    }

    /// Skips blanks, comments and continued lines; returns the next line number.
    fn skip(&mut self) -> usize {
        loop {
            let blank = self.rest.len() - self.rest.trim_start().len();
            self.advance(blank);
            if let Some(comment) = self.rest.strip_prefix("/*") {
                let end = comment.find("*/").map_or(self.rest.len(), |at| at + 4);
                self.advance(end);
            } else if self.rest.starts_with("//") {
                let end = self.rest.find('\n').unwrap_or(self.rest.len());
                self.advance(end);
            } else if self.rest.starts_with('\\') {
                self.advance(1);
            } else {
                return self.line;
            }
        }
    }

    fn take(&mut self, c: char) -> bool {
        let is_here = self.rest.starts_with(c);
        if is_here {
            self.advance(c.len_utf8());
        }
        is_here
    }

    /// Reads a name or a number.
    fn word(&mut self, expected: &str) -> Result<String, SynthError> {
        self.up_to("(){}:;,\"\\", expected)
    }

    /// Reads up to a blank or one of `ends`.
    fn up_to(&mut self, ends: &str, expected: &str) -> Result<String, SynthError> {
        let ends = |c: char| c.is_whitespace() || ends.contains(c);
        let end = self.rest.find(ends).unwrap_or(self.rest.len());
        if end == 0 {
            return Err(self.wrong(self.line, expected, &self.here()));
        }
        let word = self.rest[..end].to_owned();
        self.advance(end);
        Ok(word)
    }

    /// Reads a string without its quotes; continued lines are joined.
    fn string(&mut self) -> Result<String, SynthError> {
        let line = self.line;
        self.advance(1);
        let Some(end) = self.rest.find('"') else {
            return Err(self.wrong(line, "a string that ends", "the end of the file"));
        };
        let text = self.rest[..end].replace("\\\n", "").replace("\\\r\n", "");
        self.advance(end + 1);
        Ok(text)
    }

    /// Reads what follows a name: a value or a group.
    fn member(&mut self, name: String, line: usize, depth: u32) -> Result<Member, SynthError> {
        self.skip();
        if self.take(':') {
            return Ok(Member::Value(name, vec![self.plain()?]));
        }
        if !self.take('(') {
            return Err(self.wrong(self.line, "`:` or `(`", &self.here()));
        }
        let mut arguments = vec![];
        loop {
            self.skip();
            if self.take(')') {
                break;
            }
            if self.take(',') {
                continue;
            }
            arguments.push(match self.rest.starts_with('"') {
                true => self.string()?,
                // Of buses some are ranges: `A[3:0]`.
                false => self.up_to("(){};,\"\\", "an argument or `)`")?,
            });
        }
        self.skip();
        if !self.take('{') {
            self.take(';');
            return Ok(Member::Value(name, arguments));
        }
        if depth == MAX_DEPTH {
            let expected = format!("at most {MAX_DEPTH} groups within each other");
            return Err(self.wrong(line, &expected, "more"));
        }
        let mut group = Group {
            kind: name,
            arguments,
            line,
            ..Group::default()
        };
        loop {
            let line = self.skip();
            if self.take('}') {
                break;
            }
            if self.take(';') {
                continue;
            }
            let expected = format!("a name, or `}}` for the group of line {}", group.line);
            let name = self.word(&expected)?;
            match self.member(name, line, depth + 1)? {
                Member::Value(name, values) => {
                    group.values.push(Attribute { name, values, line });
                }
                Member::Group(inner) => group.groups.push(inner),
            }
        }
        Ok(Member::Group(group))
    }

    /// Reads a value: a string, or all up to `;`, `}` or the end of the line.
    fn plain(&mut self) -> Result<String, SynthError> {
        let blank = self.rest.len() - self.rest.trim_start_matches([' ', '\t']).len();
        self.advance(blank);
        if self.rest.starts_with('"') {
            let text = self.string()?;
            self.skip();
            self.take(';');
            return Ok(text);
        }
        let end = self.rest.find([';', '}', '\n']).unwrap_or(self.rest.len());
        let text = self.rest[..end].trim().to_owned();
        if text.is_empty() {
            return Err(self.wrong(self.line, "a value", &self.here()));
        }
        self.advance(end);
        self.take(';');
        Ok(text)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    const SMALL: &str = "/* of two cells */\nlibrary (tiny) {\n  time_unit : \"1ps\"; // a unit\n  \
                         capacitive_load_unit (1, ff);\n  cell (INV) {\n    area : 0.5\n    \
                         pin (Y) { function : \"!A\"; timing () { values ( \\\n      \"1, 2\", \\\n      \
                         \"3, 4\" ); } }\n  };\n  cell (\"DFF\") { area : 2; }\n}\n";

    #[test]
    fn groups_values_and_strings_are_read() {
        let library = parse(SMALL, "tiny.lib").unwrap();
        assert_eq!((library.name(), library.line), ("tiny", 2));
        assert_eq!(library.value("time_unit"), Some("1ps"));
        assert_eq!(library.values[1].values, ["1", "ff"]);
        let cells: Vec<_> = library.groups("cell").collect();
        assert_eq!(
            cells.iter().map(|c| c.name()).collect::<Vec<_>>(),
            ["INV", "DFF"]
        );
        // A value ends with its line where there is no semicolon.
        assert_eq!(cells[0].value("area"), Some("0.5"));
        let pin = cells[0].groups("pin").next().unwrap();
        assert_eq!((pin.value("function"), pin.line), (Some("!A"), 7));
        let timing = pin.groups("timing").next().unwrap();
        assert_eq!(timing.values[0].values, ["1, 2", "3, 4"]);
    }

    #[test]
    fn what_is_broken_is_named_with_its_line() {
        for (text, line, expected) in [
            ("", 1, "`library`"),
            ("root:x:0", 1, "`library`"),
            ("library (a) {\n  cell (b) {\n", 3, "group of line 2"),
            ("library (a) {\n  area : ;\n}", 2, "a value"),
            ("library (a) {\n  area 2;\n}", 2, "`:` or `(`"),
            ("library (a) { b (\"c", 1, "a string that ends"),
            ("library (a) { b (c{", 1, "an argument or `)`"),
            ("library (a) { }\n x", 2, "the end of the file"),
        ] {
            let error = parse(text, "t.lib").unwrap_err().to_string();
            let wanted = format!("t.lib, line {line}: ");
            assert!(
                error.starts_with(&wanted) && error.contains(expected),
                "{error}"
            );
        }
        let deep = format!("library (a) {}", "{ b () ".repeat(100_000));
        assert!(
            parse(&deep, "t.lib")
                .unwrap_err()
                .to_string()
                .contains("at most 32")
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]

        /// A damaged file is either read, or refused with one line of error.
        #[test]
        fn damaged_files_are_read_or_refused(at in any::<prop::sample::Index>(), to in ".{0,3}") {
            let mut text: Vec<char> = SMALL.chars().collect();
            let at = at.index(text.len());
            text.splice(at..=at, to.chars());
            let text: String = text.into_iter().collect();
            if let Err(error) = parse(&text, "t.lib") {
                let said = error.to_string();
                prop_assert!(said.starts_with("t.lib, line ") && !said.contains('\n'), "{said}");
            }
        }
    }
}
