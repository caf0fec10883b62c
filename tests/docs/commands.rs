//! The commands in the documents run as they stand.
//!
//! A block marked `console` holds commands, each on a line that begins with `$ potamoi `. Those of
//! a page run one after another in one folder. `console exit=1` marks commands that end with
//! another exit status than 0, `console slow` those that take long, which run with `--ignored`, and
//! `console slow=NAME` the subcommand of a block that does; a block marked `file=NAME` is written into the folder.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use super::{figures, folder_with_docs, name, pages, read};
use crate::common::expect;

/// Arguments, and the exit status that is expected.
#[derive(Debug, PartialEq)]
struct Command {
    arguments: String,
    status: i32,
    is_slow: bool,
}

/// What a page says to do.
#[derive(Debug, PartialEq)]
enum Step {
    Run(Command),
    Write { name: String, text: String },
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
            for line in block {
                let arguments = line.strip_prefix("$ potamoi ");
                let arguments = arguments.expect("a console block holds commands");
                let slow = option("slow=").map(|name| format!("{name} "));
                let is_slow = slow.is_some_and(|name| arguments.starts_with(&name));
                out.push(Step::Run(Command {
                    arguments: arguments.to_owned(),
                    status: option("exit=").map_or(0, |status| status.parse().unwrap()),
                    is_slow: is_slow || kind.split(' ').any(|word| word == "slow"),
                }));
            }
        }
    }
    out
}

#[test]
fn steps_are_commands_and_files() {
    let text = "```sh\n$ potamoi no\n```\n1. x\n\n   ```toml file=a.toml\n   [a]\n   b = 1\n   ```\n\n\
                ```console exit=4\n$ potamoi x\n```\n```console slow\n$ potamoi y z\n```\n\
                ```console slow=v\n$ potamoi u v\n$ potamoi v u\n```\n";
    let write = Step::Write {
        name: "a.toml".to_owned(),
        text: "[a]\nb = 1\n".to_owned(),
    };
    let run = |arguments: &str, status, is_slow| {
        let arguments = arguments.to_owned();
        Step::Run(Command {
            arguments,
            status,
            is_slow,
        })
    };
    assert_eq!(
        steps(text),
        [
            write,
            run("x", 4, false),
            run("y z", 0, true),
            run("u v", 0, false),
            run("v u", 0, true)
        ]
    );
}

/// Runs the steps of a page in a folder of its own, without the slow commands or with them; gives the number of
/// commands.
fn follow(page: &Path, with_slow: bool) -> usize {
    let steps = steps(&read(page));
    let is_slow = |step: &Step| matches!(step, Step::Run(command) if command.is_slow);
    if with_slow && !steps.iter().any(is_slow) {
        return 0;
    }
    let folder = folder_with_docs();
    let mut count = 0;
    for step in steps {
        let command = match step {
            Step::Write { name, text } => {
                std::fs::write(folder.path().join(name), text).unwrap();
                continue;
            }
            Step::Run(command) if command.is_slow && !with_slow => continue,
            Step::Run(command) => command,
        };
        let start = Instant::now();
        match figures::of_command(&command.arguments) {
            Some(said) => match said.get() {
                Some(Ok(said)) if command.status == 0 => said.write_files(folder.path()),
                Some(Err(why)) => panic!("{why}"),
                _ => panic!("{command:?} gives figures: it succeeds"),
            },
            None => {
                let words = shell_words::split(&command.arguments).expect("words of a shell");
                let arguments: Vec<&str> = words.iter().map(String::as_str).collect();
                expect(folder.path(), command.status, &arguments);
            }
        }
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{seconds:6.1} s  {}: potamoi {}",
            name(page),
            command.arguments
        );
        count += 1;
    }
    count
}

/// Follows all pages. Commands of a page need each other, pages do not.
fn follow_all(with_slow: bool) -> usize {
    let pages = pages();
    let next = AtomicUsize::new(0);
    let some = || {
        let mut count = 0;
        while let Some(page) = pages.get(next.fetch_add(1, Ordering::Relaxed)) {
            count += follow(page, with_slow);
        }
        count
    };
    std::thread::scope(|scope| {
        let threads = [(); 2].map(|()| scope.spawn(some));
        threads.into_iter().map(|t| t.join().unwrap()).sum()
    })
}

#[test]
fn commands_in_the_documents_work() {
    let count = follow_all(false);
    assert!(count >= 20, "{count}");
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn slow_commands_in_the_documents_work() {
    assert!(follow_all(true) >= 2);
}

/// Marks of figures are not shown on a page: the command of a search stands before its output.
#[test]
fn commands_of_searches_are_shown() {
    let mut count = 0;
    for page in pages() {
        let text = read(&page);
        for (at, mark) in text.match_indices("figures: explore ") {
            let (shown, command) = text.split_at(at);
            let command = command["figures: ".len()..].lines().next().unwrap();
            // What is shown ends where the comment begins.
            let shown = &shown[..shown.rfind("<!--").unwrap()];
            let shown = shown.replace(" \\\n    ", " ");
            let expected = format!("```sh\npotamoi {command}\n```\n");
            assert!(
                shown.trim_end().ends_with(expected.trim_end()),
                "{}: {mark}{command}",
                name(&page)
            );
            count += 1;
        }
    }
    assert!(count >= 4, "{count}");
}
