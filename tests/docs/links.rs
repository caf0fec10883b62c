//! Links lead to files and headings that exist, and every page is in the book once, under one of
//! its four kinds.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use pulldown_cmark::{BrokenLink, Event, HeadingLevel, LinkType, Options, Parser, Tag, TagEnd};

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

/// What a page's Markdown and HTML lead to and what leads into it.
#[derive(Default)]
struct Page {
    /// Targets of links and pictures: inline, by reference, and in attributes of HTML.
    links: Vec<String>,
    /// Names of references, as in `[text][name]`, that no line defines.
    undefined: Vec<String>,
    /// Anchors of headings, as GitHub and mdBook make them, and of `id` in HTML.
    anchors: BTreeSet<String>,
}

fn parsed(text: &str) -> Page {
    let undefined = RefCell::new(vec![]);
    let note = |link: BrokenLink<'_>| {
        // Brackets alone, `[text]`, are usually no link.
        if !matches!(link.link_type, LinkType::Shortcut) {
            undefined.borrow_mut().push(link.reference.to_string());
        }
        None
    };
    let mut page = Page::default();
    let (mut html, mut heading) = (String::new(), None::<String>);
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for event in Parser::new_with_broken_link_callback(text, Options::ENABLE_TABLES, Some(note)) {
        match event {
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                page.links.push(dest_url.into_string());
            }
            Event::Html(part) | Event::InlineHtml(part) => html += &part,
            Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
            Event::Text(part) | Event::Code(part) => {
                heading.iter_mut().for_each(|heading| *heading += &part);
            }
            Event::End(TagEnd::Heading(_)) => {
                let anchor = anchor(&heading.take().unwrap_or_default());
                let count = seen.entry(anchor.clone()).or_default();
                page.anchors.insert(match *count {
                    0 => anchor,
                    n => format!("{anchor}-{n}"),
                });
                *count += 1;
            }
            _ => {}
        }
    }
    page.links.extend(attributes(&html, &["href", "src"]));
    page.anchors.extend(attributes(&html, &["id", "name"]));
    page.undefined = undefined.into_inner();
    page
}

/// The anchor of a heading with this text.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter_map(|c| match c {
        ' ' => Some('-'),
        c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_ascii_lowercase()),
        _ => None,
    });
    kept.collect()
}

/// Values of these attributes in tags of HTML, comments excluded.
fn attributes(html: &str, names: &[&str]) -> Vec<String> {
    let mut text = String::new();
    for (n, part) in html.split("<!--").enumerate() {
        let shown = match n {
            0 => part,
            _ => part.split_once("-->").map_or("", |(_, after)| after),
        };
        text += shown;
    }
    let mut found = vec![];
    for tag in text.split('<').skip(1) {
        let tag = tag.split('>').next().unwrap_or_default();
        for name in names {
            let parts = tag.split(&format!("{name}=")).collect::<Vec<_>>();
            for pair in parts.windows(2) {
                // A name that ends so is another attribute.
                if !pair[0].ends_with(char::is_whitespace) {
                    continue;
                }
                let quote = pair[1].chars().next().filter(|c| "\"'".contains(*c));
                let value = match quote {
                    Some(quote) => pair[1][1..].split(quote).next(),
                    None => pair[1].split_whitespace().next(),
                };
                found.push(value.unwrap_or_default().trim().to_owned());
            }
        }
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

/// What is wrong with the links of a page, and their count, those to other sites excluded.
fn broken(page: &Path, text: &str) -> (Vec<String>, usize) {
    let own = parsed(text);
    let undefined = own.undefined.iter();
    let mut wrong: Vec<_> = undefined
        .map(|link| format!("{}: [{link}]: no such reference", name(page)))
        .collect();
    let local = |link: &&String| !link.contains("://") && !link.starts_with("mailto:");
    let links: Vec<_> = own.links.iter().filter(local).collect();
    for link in &links {
        let (file, heading) = link.split_once('#').unwrap_or((link, ""));
        let target = match file {
            "" => page.to_owned(),
            file => plain(&page.parent().unwrap().join(file)),
        };
        let is_page = target.extension().is_some_and(|e| e == "md");
        if !target.exists() || !target.starts_with(root()) {
            wrong.push(format!("{}: {link}: no such file", name(page)));
        } else if !heading.is_empty() && is_page {
            let anchors = match file {
                "" => own.anchors.clone(),
                _ => parsed(&read(&target)).anchors,
            };
            if !anchors.contains(heading) {
                wrong.push(format!("{}: {link}: no such heading", name(page)));
            }
        }
    }
    (wrong, links.len())
}

#[test]
fn links_lead_to_files_and_headings_that_exist() {
    let mut wrong = vec![];
    let mut count = 0;
    for page in pages() {
        let (own, links) = broken(&page, &read(&page));
        wrong.extend(own);
        count += links;
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(count > 100, "{count} links: are they found?");
}

/// A broken link of every kind is found, and none in code or in a comment.
#[test]
fn broken_links_of_every_kind_are_found() {
    let page = root().join("docs/README.md");
    let text = "# Here\n[a](no.md) ![b](no.png) [c](#nowhere) [d][one] [e][] [f][none]\n\
                <a class='x' href=\"no.html\">g</a> <img src='no.svg'>\n\
                `[h](no.md)` <!-- [i](no.md) <img src='no.svg'> --> [j] \
                [k](#here) <https://example.invalid> [l](ARCHITECTURE.md#crates)\n\n\
                ```\n[m](no.md)\n```\n\n[one]: none.md\n[e]: none.md#x\n";
    let (wrong, count) = broken(&page, text);
    let page = "docs/README.md";
    let expected = [
        ("[none]", "reference"),
        ("no.md", "file"),
        ("no.png", "file"),
        ("#nowhere", "heading"),
        ("none.md", "file"),
        ("none.md#x", "file"),
        ("no.html", "file"),
        ("no.svg", "file"),
    ];
    let expected = expected.map(|(link, what)| format!("{page}: {link}: no such {what}"));
    assert_eq!(wrong, expected);
    assert_eq!(count, 9);
}

/// Whoever has the emitted Verilog alone has no book.
#[test]
fn the_verilog_names_no_page() {
    let mut count = 0;
    for preset in std::fs::read_dir(root().join("rtl_out")).unwrap() {
        for unit in std::fs::read_dir(preset.unwrap().path()).unwrap().flatten() {
            let files = std::fs::read_dir(unit.path())
                .into_iter()
                .flatten()
                .flatten();
            for file in files.filter(|f| f.path().extension().is_some_and(|e| e == "v")) {
                let text = read(&file.path());
                assert!(!text.contains("docs/"), "{}", file.path().display());
                count += 1;
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
        for link in parsed(line.trim_start()).links {
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
    let front: BTreeSet<String> = parsed(&read(&book.join("README.md")))
        .links
        .into_iter()
        .collect();
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

/// Every page has a title, and a sentence below it on what it gives.
#[test]
fn every_page_begins_with_a_title_and_a_sentence() {
    for page in pages_in(&root().join("docs")) {
        if page.ends_with("SUMMARY.md") {
            continue;
        }
        let text = read(&page);
        let mut events = Parser::new(&text);
        let title = events.next();
        let is_title = matches!(
            title,
            Some(Event::Start(Tag::Heading {
                level: HeadingLevel::H1,
                ..
            }))
        );
        assert!(is_title, "{}: {title:?}", name(&page));
        let below = events
            .skip_while(|event| !matches!(event, Event::End(TagEnd::Heading(_))))
            .nth(1);
        assert_eq!(
            below,
            Some(Event::Start(Tag::Paragraph)),
            "{}: below its title",
            name(&page)
        );
    }
}

#[test]
fn links_and_anchors_are_told_from_code() {
    let text = "# A `b` c\n[x](y.md) `[n](o.md)`\n```\n[n](o.md)\n# no\n```\n## A b c\n<a id=\"own\"></a>\n";
    let page = parsed(text);
    assert_eq!(page.links, ["y.md"]);
    let all: Vec<_> = page.anchors.iter().collect();
    assert_eq!(all, ["a-b-c", "a-b-c-1", "own"]);
}
