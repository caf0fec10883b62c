//! The page on adding an exponential form is followed: its example is added to a copy of the crates
//! and tested there.
//!
//! A file is new after a line ``New file `PATH`:``; lines are added after ``In `PATH`, below
//! `LINE`:``. The block that follows is what is written.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{read, root};

const PAGE: &str = "docs/adding/exponential.md";
/// The example's name, as files and modules have it.
const FORM: &str = "mitchell";
/// The crates that a form is in, and those that they are built on.
const CRATES: [&str; 6] = [
    "formats",
    "golden/base",
    "golden/reference",
    "hdl/netlist",
    "hdl/units",
    "sim/cycles",
];

/// A change of a file.
#[derive(Debug, PartialEq)]
struct Change {
    path: String,
    /// The line below which the text goes; none of a new file.
    below: Option<String>,
    text: String,
}

/// The changes of a page, in order.
fn changes(page: &str) -> Vec<Change> {
    let mut out = vec![];
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let parts: Vec<_> = line.split('`').collect();
        let (path, below) = match parts[..] {
            ["New file ", path, ":"] => (path, None),
            ["In ", path, ", below ", below, ":"] => (path, Some(below.to_owned())),
            _ => continue,
        };
        let block = lines.by_ref().skip_while(|line| !line.starts_with("```"));
        let block = block.skip(1).take_while(|line| !line.starts_with("```"));
        out.push(Change {
            path: path.to_owned(),
            below,
            text: block.map(|line| line.to_owned() + "\n").collect(),
        });
    }
    out
}

/// A file with a change made.
fn changed(old: &str, change: &Change) -> String {
    let Some(below) = &change.below else {
        return change.text.clone();
    };
    let line = format!("{below}\n");
    assert_eq!(
        old.matches(&line).count(),
        1,
        "{}: lines `{below}`",
        change.path
    );
    old.replace(&line, &format!("{line}{}", change.text))
}

/// At most eight files, which a search for the form's name finds, and registries that have the
/// lines that the page names.
#[test]
fn the_page_on_exponential_forms_names_lines_that_exist() {
    let changes = changes(&read(&root().join(PAGE)));
    let files: BTreeSet<_> = changes.iter().map(|c| &c.path).collect();
    assert_eq!(files.len(), 8, "{files:?}");
    assert_eq!(changes.iter().filter(|c| c.below.is_none()).count(), 4);
    for change in &changes {
        let path = root().join(&change.path);
        let named = change.path.contains(FORM) || change.text.contains(FORM);
        assert!(named, "{change:?}");
        if change.below.is_some() {
            changed(&read(&path), change);
        } else {
            assert!(!path.exists(), "{}", path.display());
        }
    }
}

/// Files of a folder and below it, but for tests and build outputs.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else {
            found.push(path);
        }
    }
}

/// Writes a file if it holds something else: what is built stays built.
fn write(path: &Path, text: &[u8]) {
    if std::fs::read(path).is_ok_and(|old| old == text) {
        return;
    }
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, text).unwrap();
}

/// The workspace's manifest, of these crates and one more.
fn manifest() -> String {
    let mut manifest: toml::Table = read(&root().join("Cargo.toml")).parse().unwrap();
    manifest.retain(|key, _| key == "workspace" || key == "profile");
    let workspace = manifest["workspace"].as_table_mut().unwrap();
    let members = CRATES.iter().chain(&["every-form"]);
    let members: Vec<_> = members.map(|&c| toml::Value::from(c)).collect();
    workspace.insert("members".to_owned(), members.into());
    workspace.remove("default-members");
    // Little is run: crates of the workspace are built in haste, those of others as ever.
    let dev = manifest["profile"]["dev"].as_table_mut().unwrap();
    let packages = dev["package"].as_table_mut().unwrap();
    packages.retain(|name, _| !name.starts_with("potamoi-"));
    for name in CRATES {
        let name = format!("potamoi-{}", name.rsplit('/').next().unwrap());
        let haste = toml::Table::from_iter([("opt-level".to_owned(), 0.into())]);
        packages.insert(name, haste.into());
    }
    manifest.to_string()
}

/// A crate's manifest whose tests need no crate of the workspace.
fn manifest_of(path: &Path) -> String {
    let mut manifest: toml::Table = read(path).parse().unwrap();
    if let Some(needed) = manifest.get_mut("dev-dependencies") {
        let needed = needed.as_table_mut().unwrap();
        needed.retain(|name, _| !name.starts_with("potamoi-"));
    }
    manifest.to_string()
}

/// A copy of the crates with the page's changes, below `folder`.
fn copy(folder: &Path) {
    let mut wanted = BTreeSet::new();
    let changes = changes(&read(&root().join(PAGE)));
    for name in CRATES {
        let mut sources = vec![root().join(name).join("Cargo.toml")];
        files(&root().join(name).join("src"), &mut sources);
        for path in sources {
            let own = path.strip_prefix(root()).unwrap();
            wanted.insert(folder.join(own));
            if own.ends_with("Cargo.toml") {
                write(&folder.join(own), manifest_of(&path).as_bytes());
                continue;
            }
            let own = own.to_str().unwrap();
            let made: Vec<_> = changes.iter().filter(|c| c.path == own).collect();
            if made.is_empty() {
                write(&folder.join(own), &std::fs::read(&path).unwrap());
            } else {
                let text = made.iter().fold(read(&path), |text, c| changed(&text, c));
                write(&folder.join(own), text.as_bytes());
            }
        }
    }
    for change in changes.iter().filter(|c| c.below.is_none()) {
        wanted.insert(folder.join(&change.path));
        write(&folder.join(&change.path), change.text.as_bytes());
    }
    for name in CRATES {
        let mut there = vec![];
        files(&folder.join(name), &mut there);
        for gone in there.into_iter().filter(|path| !wanted.contains(path)) {
            std::fs::remove_file(gone).unwrap();
        }
    }
    for path in ["configs", "Cargo.lock"] {
        let mut all = vec![];
        let from = root().join(path);
        if from.is_dir() {
            files(&from, &mut all);
        } else {
            all.push(from);
        }
        for path in all {
            let own = path.strip_prefix(root()).unwrap();
            let to = folder.join(own);
            // Cargo leaves out of it what these crates do not need.
            if !(own == Path::new("Cargo.lock") && to.exists()) {
                write(&to, &std::fs::read(&path).unwrap());
            }
        }
    }
    write(&folder.join("Cargo.toml"), manifest().as_bytes());
    let own = folder.join("every-form");
    let test = read(&root().join("sim/rtl/tests/rtl/every_form.rs"));
    write(&own.join("tests/every_form.rs"), test.as_bytes());
    write(&own.join("src/lib.rs"), b"//! Nothing.\n");
    let needed = ["formats", "netlist", "units", "reference", "cycles"];
    let needed = needed.map(|name| format!("potamoi-{name}.workspace = true\n"));
    let text = format!(
        "[package]\nname = \"every-form\"\nedition = \"2024\"\n\n[dependencies]\n{}",
        needed.concat()
    );
    write(&own.join("Cargo.toml"), text.as_bytes());
}

#[test]
fn the_page_on_exponential_forms_adds_one() {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let folder = scratch.join("adding-exponential");
    copy(&folder);
    // The crates of others are built there already.
    let built = scratch.parent().unwrap();
    for tests in [
        &["-p", "potamoi-reference", "--lib", FORM][..],
        &["-p", "every-form"],
    ] {
        let done = Command::new(env!("CARGO"))
            .current_dir(&folder)
            .env("CARGO_TARGET_DIR", built)
            .args(["test", "--offline"])
            .args(tests)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&done.stdout);
        let error = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success(), "{tests:?}\n{said}\n{error}");
        assert!(said.contains("test result: ok. 1 passed"), "{said}");
    }
}

#[test]
fn changes_are_read_and_made() {
    let page = "New file `a.rs`:\n\n```rust\none\n```\n\nIn `b.rs`, below `  two;`:\n\n```rust\n  three;\n```\n";
    let found = changes(page);
    assert_eq!(found.len(), 2);
    assert_eq!(found[0].below, None);
    assert_eq!(changed("", &found[0]), "one\n");
    assert_eq!(
        changed("1;\n  two;\n4;\n", &found[1]),
        "1;\n  two;\n  three;\n4;\n"
    );
}
