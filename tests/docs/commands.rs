//! The commands in the documents run as they stand.
//!
//! A block marked `console` holds commands, each on a line that begins with `$ potamoi `. Those of
//! a page run one after another in one folder. `console exit=1` marks commands that end with
//! another exit status than 0; a block marked `file=NAME` is written into the folder.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::{figures, folder_with_docs, name, pages, read};
use crate::common::expect;

/// What a page says to do.
#[derive(Debug, PartialEq)]
enum Step {
    /// Run with these arguments, and expect this exit status.
    Run(String, i32),
    Write {
        name: String,
        text: String,
    },
}

/// Steps of a page. Blocks may be indented, as in lists.
fn steps(text: &str) -> Vec<Step> {
    let mut out = vec![];
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let indent = line.len() - line.trim_start().len();
        let Some(kind) = line.trim_start().strip_prefix("```") else {
            continue;
        };
        let block: Vec<&str> = lines
            .by_ref()
            .take_while(|line| !line.trim_start().starts_with("```"))
            .map(|line| line.get(indent..).unwrap_or_default())
            .collect();
        let option = |name: &str| {
            let words = kind.split(' ');
            words.filter_map(|word| word.strip_prefix(name)).next_back()
        };
        if let Some(name) = option("file=") {
            let (name, text) = (name.to_owned(), block.join("\n") + "\n");
            out.push(Step::Write { name, text });
        } else if kind.split(' ').next() == Some("console") {
            let status = option("exit=").map_or(0, |status| status.parse().unwrap());
            for line in block {
                let command = line.strip_prefix("$ potamoi ");
                let command = command.expect("a console block holds commands");
                out.push(Step::Run(command.to_owned(), status));
            }
        }
    }
    out
}

#[test]
fn steps_are_commands_and_files() {
    let text = "```sh\n$ potamoi no\n```\n1. x\n\n   ```toml file=a.toml\n   [a]\n   b = 1\n   ```\n\n\
                ```console exit=4\n$ potamoi x\n```\n";
    let write = Step::Write {
        name: "a.toml".to_owned(),
        text: "[a]\nb = 1\n".to_owned(),
    };
    assert_eq!(steps(text), [write, Step::Run("x".to_owned(), 4)]);
}

#[test]
fn commands_in_the_documents_work() {
    let pages = pages();
    let run = |page: &PathBuf| {
        let folder = folder_with_docs();
        let mut count = 0;
        for step in steps(&read(page)) {
            match step {
                Step::Run(command, status) => {
                    println!("{}: potamoi {command}", name(page));
                    match figures::of_command(&command) {
                        Some(said) => match said.get() {
                            Some(Ok(said)) if status == 0 => said.write_files(folder.path()),
                            Some(Err(why)) => panic!("{why}"),
                            _ => panic!("potamoi {command} gives figures: it succeeds"),
                        },
                        None => {
                            let arguments: Vec<&str> = command.split(' ').collect();
                            expect(folder.path(), status, &arguments);
                        }
                    }
                    count += 1;
                }
                Step::Write { name, text } => {
                    std::fs::write(folder.path().join(name), text).unwrap();
                }
            }
        }
        count
    };
    // Commands of a page need each other, pages do not.
    let next = AtomicUsize::new(0);
    let some = || {
        let mut count = 0;
        while let Some(page) = pages.get(next.fetch_add(1, Ordering::Relaxed)) {
            count += run(page);
        }
        count
    };
    let count: usize = std::thread::scope(|scope| {
        let threads = [(); 2].map(|()| scope.spawn(some));
        threads.into_iter().map(|t| t.join().unwrap()).sum()
    });
    assert!(count >= 20, "{count}");
}
