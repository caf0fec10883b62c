//! Links lead to files and headings that exist, and every page is in the book once, under one of
//! its four kinds.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use super::{name, pages, pages_in, read, root};

/// Parts of the book, and the folders whose pages stand there.
const KINDS: [(&str, &[&str]); 4] = [
    ("Tutorials", &["tutorials"]),
    ("How-to guides", &["how-to", "adding"]),
    ("Reference", &["reference"]),
    ("Explanation", &["explanation", "decisions"]),
];
/// Pages at the top of the book whose kind is not their folder's.
const AT_THE_TOP: [(&str, &str); 2] = [
    ("ARCHITECTURE.md", "Explanation"),
    ("GLOSSARY.md", "Reference"),
];
/// The book's own front page and table of contents.
const FRONT: [&str; 2] = ["README.md", "SUMMARY.md"];

/// The text without code, in which links are none: blocks are blank, spans of code are gone.
fn prose(text: &str) -> String {
    let mut inside = false;
    let mut out = String::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
        } else if !inside {
            for (n, part) in line.split('`').enumerate() {
                // Odd parts are code, unless the span goes on in the next line.
                if n % 2 == 0 {
                    out.push_str(part);
                }
            }
        }
        out.push('\n');
    }
    out
}

/// Targets of the links of a page.
fn links(text: &str) -> Vec<String> {
    let text = prose(text);
    let mut found = vec![];
    for (at, _) in text.match_indices("](") {
        let rest = &text[at + 2..];
        if let Some(end) = rest.find(')') {
            found.push(rest[..end].trim().to_owned());
        }
    }
    found
}

/// The anchors of a page's headings, as GitHub and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut inside = false;
    let mut found = BTreeSet::new();
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for line in text.lines() {
        if line.starts_with("```") {
            inside = !inside;
        }
        let heading = line.trim_start_matches('#');
        if inside || heading.len() == line.len() || !heading.starts_with(' ') {
            continue;
        }
        let kept = heading.trim().chars().filter_map(|c| match c {
            ' ' => Some('-'),
            c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_ascii_lowercase()),
            _ => None,
        });
        let anchor: String = kept.collect();
        let count = seen.entry(anchor.clone()).or_default();
        found.insert(match *count {
            0 => anchor,
            n => format!("{anchor}-{n}"),
        });
        *count += 1;
    }
    found
}

/// A path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                out.pop();
            }
            Component::CurDir => {}
            part => out.push(part),
        }
    }
    out
}

#[test]
fn links_lead_to_files_and_headings_that_exist() {
    let mut wrong = vec![];
    let mut count = 0;
    for page in pages() {
        for link in links(&read(&page)) {
            if link.contains("://") || link.starts_with("mailto:") {
                continue;
            }
            count += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => page.clone(),
                file => plain(&page.parent().unwrap().join(file)),
            };
            let is_page = target.extension().is_some_and(|e| e == "md");
            if !target.exists() || !target.starts_with(root()) {
                wrong.push(format!("{}: {link}: no such file", name(&page)));
            } else if !anchor.is_empty() && is_page && !anchors(&read(&target)).contains(anchor) {
                wrong.push(format!("{}: {link}: no such heading", name(&page)));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(count > 100, "{count} links: are they found?");
}

/// Emitted Verilog names the page that its errors are told on. The name is part of the text that
/// syntheses are held against, and stays where the page moves.
#[test]
fn pages_that_verilog_names_are_there() {
    let mut count = 0;
    for preset in std::fs::read_dir(root().join("rtl_out")).unwrap() {
        for unit in std::fs::read_dir(preset.unwrap().path()).unwrap().flatten() {
            let files = std::fs::read_dir(unit.path())
                .into_iter()
                .flatten()
                .flatten();
            for file in files.filter(|f| f.path().extension().is_some_and(|e| e == "v")) {
                let text = read(&file.path());
                for (at, _) in text.match_indices("docs/") {
                    let page = text[at..].split(".md").next().unwrap();
                    let page = root().join(format!("{page}.md"));
                    assert!(
                        page.is_file(),
                        "{}: {}",
                        file.path().display(),
                        page.display()
                    );
                    count += 1;
                }
            }
        }
    }
    assert!(count > 0);
}

#[test]
fn every_page_is_in_the_book_once_under_its_kind() {
    let book = root().join("docs");
    let mut part = String::new();
    let mut listed: BTreeMap<String, String> = BTreeMap::new();
    for line in read(&book.join("SUMMARY.md")).lines() {
        if let Some(title) = line.strip_prefix("# ") {
            part = title.to_owned();
        }
        for link in links(line) {
            let before = listed.insert(link.clone(), part.clone());
            assert!(before.is_none(), "SUMMARY.md lists {link} twice");
        }
    }
    for page in pages_in(&book) {
        let page = page.strip_prefix(&book).unwrap();
        let own = page.to_string_lossy().into_owned();
        let folder = page.parent().unwrap().to_string_lossy().into_owned();
        let by_folder = KINDS.iter().find(|(_, own)| own.contains(&&*folder));
        let by_name = AT_THE_TOP.iter().find(|(name, _)| *name == own);
        let kind = by_folder
            .map(|(kind, _)| *kind)
            .or(by_name.map(|(_, kind)| *kind));
        let found = listed.remove(&own);
        match kind {
            None if FRONT.contains(&&*own) => {}
            None => panic!("{own}: of no kind; put it into the folder of one"),
            Some(kind) => assert_eq!(found.as_deref(), Some(kind), "{own} in SUMMARY.md"),
        }
    }
    assert!(
        listed.is_empty(),
        "SUMMARY.md lists what is not there: {listed:?}"
    );
}

#[test]
fn the_front_page_of_the_book_leads_to_every_page() {
    let book = root().join("docs");
    let front: BTreeSet<String> = links(&read(&book.join("README.md"))).into_iter().collect();
    for page in pages_in(&book) {
        let own = page
            .strip_prefix(&book)
            .unwrap()
            .to_string_lossy()
            .into_owned();
        assert!(
            FRONT.contains(&&*own) || front.contains(&own),
            "docs/README.md does not lead to {own}"
        );
    }
}

#[test]
fn links_and_anchors_are_told_from_code() {
    let text = "# A `b` c\n[x](y.md) `[n](o.md)`\n```\n[n](o.md)\n# no\n```\n## A b c\n";
    assert_eq!(links(text), ["y.md"]);
    let all: Vec<_> = anchors(text).into_iter().collect();
    assert_eq!(all, ["a-b-c", "a-b-c-1"]);
}
