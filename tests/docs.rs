//! The commands in the documents run as they stand.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod common;

use std::path::Path;

use common::expect;

/// Lines that begin with `$ potamoi` in blocks marked `console`.
fn commands(text: &str) -> Vec<String> {
    let mut inside = false;
    let mut out = vec![];
    for line in text.lines() {
        if let Some(kind) = line.strip_prefix("```") {
            inside = kind == "console";
        } else if inside {
            let command = line.strip_prefix("$ potamoi ");
            out.push(command.expect("a console block holds commands").to_owned());
        }
    }
    out
}

#[test]
fn commands_in_the_documents_work() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut pages = vec![root.join("README.md"), root.join("CONTRIBUTING.md")];
    for file in std::fs::read_dir(root.join("docs")).unwrap() {
        let path = file.unwrap().path();
        if path.extension().is_some_and(|e| e == "md") {
            pages.push(path);
        }
    }
    pages.sort();
    let run = |page: &std::path::PathBuf| {
        let folder = tempfile::tempdir().unwrap();
        let commands = commands(&std::fs::read_to_string(page).unwrap());
        for command in &commands {
            let arguments: Vec<&str> = command.split(' ').collect();
            expect(folder.path(), 0, &arguments);
        }
        commands.len()
    };
    // Commands of a page need each other, pages do not.
    let half = pages.len() / 2;
    let count: usize = std::thread::scope(|scope| {
        let halves = [&pages[..half], &pages[half..]];
        let threads = halves.map(|pages| scope.spawn(move || pages.iter().map(run).sum::<usize>()));
        threads.into_iter().map(|t| t.join().unwrap()).sum()
    });
    assert!(count >= 10, "{count}");
}

/// The pictures in the documents are those of today's renderer. Codes may
/// differ by one where floating point differs between machines.
#[test]
fn pictures_in_the_documents_are_current() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["garden", "lantern"] {
        expect(
            folder.path(),
            0,
            &["render", "--scene", scene, "--out", "p.png"],
        );
        let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/images/{scene}.png"));
        let [kept, now] =
            [kept, folder.path().join("p.png")].map(|p| image::open(p).unwrap().to_rgb8());
        assert_eq!(kept.dimensions(), now.dimensions());
        let far = kept
            .iter()
            .zip(now.iter())
            .filter(|(a, b)| a.abs_diff(**b) > 1)
            .count();
        assert!(
            far * 1000 < kept.len(),
            "{scene}: {far} codes differ: make refresh renders them again"
        );
    }
}
