//! Pages that say how to add a thing: the files that they list are those that it takes.
//!
//! A page has a line `<!-- adding: at most N files, found by WORD, WORD -->`, and below it a table
//! whose first column names files or folders. A search for the words, which are the example's own,
//! finds files in all of these and in no others, but for those of a table below `<!-- found too -->`,
//! which know the example and need not know what is added. Tests are found only where the table names
//! them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::{followed, name, pages_in, read, root};

/// The pages, and the most files that each may list.
const LIMITS: [(&str, usize); 5] = [
    ("exponential", 8),
    ("field", 4),
    ("format", 3),
    ("knob", 4),
    ("unit", 14),
];

/// Rust files below a folder, but for tests and examples.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_test = name.starts_with("test") || name.ends_with("tests.rs");
        if is_test || ["target", "examples", "benches"].contains(&&*name) {
            continue;
        }
        if path.is_dir() {
            sources(&path, found);
        } else if name.ends_with(".rs") {
            found.push(path);
        }
    }
}

/// Whether a text has a word that is no part of another.
fn has_word(text: &str, word: &str) -> bool {
    let is_part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    let is_open = is_part(word.chars().next_back());
    text.match_indices(word).any(|(at, _)| {
        let (before, after) = (text[..at].chars().next_back(), &text[at + word.len()..]);
        !(is_part(before) || (is_open && is_part(after.chars().next())))
    })
}

/// The list of a page.
struct Listed {
    /// Files and folders of the table below the mark.
    files: BTreeSet<String>,
    /// The most that there may be.
    most: usize,
    /// Words that find them.
    words: Vec<String>,
    /// Files that the words find, and that what is added does not touch.
    too: BTreeSet<String>,
}

/// The files of the first table of a text: what its first column has in backticks.
fn files_of_table(text: &str) -> BTreeSet<String> {
    let rows = text.lines().skip_while(|line| !line.starts_with('|'));
    let rows = rows.take_while(|line| line.starts_with('|')).skip(2);
    let files = rows.filter_map(|row| Some(row.split('`').nth(1)?.to_owned()));
    files.collect()
}

impl Listed {
    fn of(text: &str) -> Option<Self> {
        let (_, rest) = text.split_once("<!-- adding: at most ")?;
        let (mark, rest) = rest.split_once(" -->")?;
        let (count, words) = mark.split_once(" files").unwrap_or((mark, ""));
        let words = words.strip_prefix(", found by ").unwrap_or_default();
        let too = rest.split_once("<!-- found too -->");
        Some(Self {
            files: files_of_table(rest),
            too: too
                .map(|(_, rest)| files_of_table(rest))
                .unwrap_or_default(),
            most: count.parse().ok()?,
            words: words
                .split(", ")
                .filter(|word| !word.is_empty())
                .map(str::to_owned)
                .collect(),
        })
    }

    /// Whether a text has one of the words.
    fn is_found_in(&self, text: &str) -> bool {
        self.words.iter().any(|word| has_word(text, word))
    }

    /// The file of the list, or the folder of it, that holds a file.
    fn holder(&self, file: &str) -> Option<&String> {
        let mut all = self.files.iter();
        all.find(|own| *own == file || (own.ends_with('/') && file.starts_with(&***own)))
    }
}

/// A source without its unit tests.
fn without_tests(text: &str) -> &str {
    let tests = text.find("#[cfg(test)]\nmod tests {");
    &text[..tests.unwrap_or(text.len())]
}

#[test]
fn pages_on_adding_list_the_files_that_it_takes() {
    let mut all = vec![];
    for folder in ["formats", "hdl", "golden", "sim", "src"] {
        sources(&root().join(folder), &mut all);
    }
    let all: Vec<_> = all.iter().map(|path| (name(path), read(path))).collect();
    for (page, limit) in LIMITS {
        let page = format!("docs/adding/{page}.md");
        let listed = Listed::of(&read(&root().join(&page))).unwrap_or_else(|| panic!("{page}"));
        assert!(listed.most <= limit, "{page}: at most {limit} files");
        let count = listed.files.len();
        assert!(count > 0 && count <= listed.most, "{page}: {count} files");
        for file in &listed.files {
            assert!(root().join(file).exists(), "{page}: {file}");
        }
        if listed.words.is_empty() {
            continue;
        }
        let found = all
            .iter()
            .filter(|(_, text)| listed.is_found_in(without_tests(text)));
        let mut holders = BTreeSet::new();
        let mut too = listed.too.clone();
        for (file, _) in found {
            if listed.too.contains(file) {
                too.remove(file);
                continue;
            }
            let holder = listed.holder(file);
            let words = &listed.words;
            holders.insert(holder.unwrap_or_else(|| panic!("{page}: {file} has one of {words:?}")));
        }
        for file in listed.files.iter().filter(|f| f.contains("/tests/")) {
            if listed.is_found_in(&read(&root().join(file))) {
                holders.insert(file);
            }
        }
        let named: BTreeSet<_> = listed.files.iter().collect();
        assert_eq!(holders, named, "{page}: a search for {:?}", listed.words);
        assert!(too.is_empty(), "{page}: not found: {too:?}");
    }
}

/// Every page has its limit.
#[test]
fn pages_on_adding_have_limits() {
    let pages = pages_in(&root().join("docs/adding"));
    let limits = LIMITS.map(|(page, _)| root().join(format!("docs/adding/{page}.md")));
    assert_eq!(pages, limits);
}

/// The form that the page adds takes a file where the form of its list has one.
#[test]
fn the_added_form_takes_the_files_of_the_list() {
    let text = read(&root().join(followed::PAGES[0].0));
    let listed = Listed::of(&text).unwrap().files;
    let own = listed.iter().map(|f| f.replace("radix4", followed::FORM));
    let changed = followed::changes(&text).into_iter().map(|c| c.path);
    assert_eq!(
        own.collect::<BTreeSet<_>>(),
        changed.collect::<BTreeSet<_>>()
    );
}

#[test]
fn words_and_lists_are_found() {
    assert!(has_word("a.hashed_levels = 1", "hashed_levels"));
    assert!(!has_word("unhashed_levels_of", "hashed_levels"));
    assert!(has_word("use tree::Tree", "tree::"));
    let text = "<!-- adding: at most 2 files, found by x, y z -->\n\n| file | |\n|---|---|\n| `a.rs` | b |\n| `d/` | |\n\n| `c` |\n";
    let listed = Listed::of(text).unwrap();
    assert_eq!(listed.files.iter().collect::<Vec<_>>(), ["a.rs", "d/"]);
    assert_eq!(
        (listed.most, &*listed.words),
        (2, &["x", "y z"].map(str::to_owned)[..])
    );
    assert!(listed.is_found_in("a y z") && !listed.is_found_in("xy"));
    assert_eq!(listed.holder("d/e.rs").unwrap(), "d/");
    assert_eq!(listed.holder("a.rs2"), None);
    let source = "mod a;\n#[cfg(test)]\nmod tests {\n x\n}\n";
    assert_eq!(without_tests(source), "mod a;\n");
}
