//! Flags in the documents are those that the command has.
//!
//! The reference page of the command line is held to the program by a test of the program's own;
//! here the other pages are held to it.

use std::collections::BTreeMap;

use super::{name, pages, read, root};

/// Flags of other programs that the documents name by themselves: of tools/hard-case-guards, and of the
/// program that writes Compact-3DGS models.
const OF_OTHERS: [&str; 2] = ["--end-to-end", "--comp"];

/// Commands by flag, as the reference page has them.
fn flags() -> BTreeMap<String, String> {
    let page = read(&root().join("docs/reference/cli.md"));
    let rows = page.lines().filter(|line| line.starts_with("| `--"));
    let rows = rows.map(|row| row.replace("\\|", " "));
    let mut found = BTreeMap::new();
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        if let [_, flag, _, _, _, commands, _] = cells[..] {
            found.insert(flag.trim_matches('`').to_owned(), commands.to_owned());
        }
    }
    found
}

/// Whether a line is of an indented block of commands.
fn is_block(line: &str) -> bool {
    line.starts_with("    ") && line.trim_start().starts_with("potamoi")
}

/// Pieces of code of a page, a line or a span each.
fn pieces(text: &str) -> Vec<String> {
    let mut found = vec![];
    let mut inside = false;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
        } else if inside || is_block(line) {
            found.push(line.trim().to_owned());
        } else {
            let spans = line.split('`').enumerate().filter(|(n, _)| n % 2 == 1);
            found.extend(spans.map(|(_, span)| span.to_owned()));
        }
    }
    found
}

fn flag_of(word: &str) -> Option<&str> {
    let word = word.trim_matches(|c: char| !c.is_ascii_alphanumeric() && c != '-');
    let flag = word
        .split('=')
        .next()
        .filter(|flag| flag.starts_with("--"))?;
    (flag.len() > 2).then_some(flag)
}

#[test]
fn flags_in_the_documents_are_those_of_the_command() {
    let flags = flags();
    assert!(flags.len() > 80, "{}", flags.len());
    let takes = |commands: &str, command: &str| match commands.strip_prefix("all but ") {
        Some(others) => !others.split(", ").any(|own| own == command),
        None => commands.split(", ").any(|own| own == command),
    };
    let commands: Vec<&str> = flags["--json"].split(", ").collect();
    let mut wrong = vec![];
    let mut count = 0;
    for page in pages() {
        let own = name(&page);
        // History, and the page itself, which names old flags.
        if own == "CHANGELOG.md" || own == "docs/reference/cli.md" {
            continue;
        }
        for piece in pieces(&read(&page)) {
            let words: Vec<&str> = piece.split_whitespace().collect();
            let start = words.iter().position(|word| *word == "potamoi");
            let (command, rest) = match start {
                Some(at) => {
                    let rest = &words[at + 1..];
                    let command = rest.iter().find(|word| commands.contains(word));
                    (command.copied(), rest)
                }
                None if piece.starts_with("--") => (None, &words[..]),
                None if words.first().is_some_and(|word| commands.contains(word)) => {
                    (words.first().copied(), &words[1..])
                }
                None => continue,
            };
            // A sentence goes on after a comma.
            let end = rest.iter().position(|word| word.ends_with(','));
            let rest = &rest[..end.map_or(rest.len(), |at| at + 1)];
            for flag in rest.iter().filter_map(|word| flag_of(word)) {
                count += 1;
                let fits = match (flags.get(flag), command) {
                    (Some(of), Some(command)) => takes(of, command),
                    (Some(_), None) => true,
                    (None, _) => {
                        ["--help", "--version"].contains(&flag) || OF_OTHERS.contains(&flag)
                    }
                };
                if !fits {
                    wrong.push(format!("{own}: {flag} in `{piece}`"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(count > 100, "{count}");
}
