//! Pages that say how to add a thing: the files that they list are those that it takes.
//!
//! A page has a line `<!-- adding: at most N files, found by WORD -->`, and below it a table whose
//! first column names files or folders. `found by WORD` means that a search for the example's own
//! word finds these files and no others, tests aside.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::{name, pages_in, read, root};

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
    text.match_indices(word).any(|(at, _)| {
        let (before, after) = (text[..at].chars().next_back(), &text[at + word.len()..]);
        !is_part(before) && !is_part(after.chars().next())
    })
}

/// Files of the table below the mark, the most that there may be, and the word that finds them.
fn listed(text: &str) -> Option<(BTreeSet<String>, usize, Option<&str>)> {
    let (_, rest) = text.split_once("<!-- adding: at most ")?;
    let (mark, rest) = rest.split_once(" -->")?;
    let (count, word) = match mark.split_once(" files, found by ") {
        Some((count, word)) => (count, Some(word)),
        None => (mark.strip_suffix(" files")?, None),
    };
    let rows = rest.lines().skip_while(|line| !line.starts_with('|'));
    let rows = rows.take_while(|line| line.starts_with('|')).skip(2);
    let files = rows.filter_map(|row| Some(row.split('`').nth(1)?.to_owned()));
    Some((files.collect(), count.parse().ok()?, word))
}

#[test]
fn pages_on_adding_list_the_files_that_it_takes() {
    let mut sources_of_all = vec![];
    for folder in ["formats", "hdl", "golden", "sim", "src"] {
        sources(&root().join(folder), &mut sources_of_all);
    }
    let mut checked = 0;
    for page in pages_in(&root().join("docs/adding")) {
        let own = name(&page);
        let Some((files, most, word)) =
            listed(&read(&page)).map(|(files, most, word)| (files, most, word.map(str::to_owned)))
        else {
            continue;
        };
        checked += 1;
        assert!(!files.is_empty() && files.len() <= most, "{own}: {files:?}");
        for file in &files {
            assert!(root().join(file).exists(), "{own}: {file}");
        }
        if let Some(word) = word {
            let found = sources_of_all
                .iter()
                .filter(|path| has_word(&read(path), &word));
            let found: BTreeSet<String> = found.map(|path| name(path)).collect();
            assert_eq!(files, found, "{own}: a search for {word}");
        }
    }
    assert!(checked >= 2, "{checked}");
}

#[test]
fn words_and_lists_are_found() {
    assert!(has_word("a.hashed_levels = 1", "hashed_levels"));
    assert!(!has_word("unhashed_levels_of", "hashed_levels"));
    let text = "<!-- adding: at most 2 files, found by x -->\n\n| file | |\n|---|---|\n| `a.rs` | b |\n\n| `c` |\n";
    let (files, most, word) = listed(text).unwrap();
    assert_eq!(
        (files.into_iter().collect::<Vec<_>>(), most, word),
        (vec!["a.rs".to_owned()], 2, Some("x"))
    );
}
