//! Pages that say how to add something are followed: their examples are added to a copy of the
//! crates and, since that takes long, tested there by `make test-full` alone.
//!
//! A file is new after a line ``New file `PATH`:``; lines are added after ``In `PATH`, below
//! `LINE`:`` and put in its place after ``In `PATH`, in place of `LINE`:``. The block that follows is
//! what is written.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{read, root};

/// The pages, and the tests that their examples have to pass in the copy.
pub(super) const PAGES: [(&str, &str); 2] = [
    ("docs/adding/exponential.md", "every_form"),
    ("docs/adding/unit.md", "every_operation"),
];
/// The name of the form that the first page adds, as files and modules have it.
pub(super) const FORM: &str = "mitchell";
/// The crates that the examples are in, and those that they are built on.
const CRATES: [&str; 6] = [
    "formats",
    "golden/base",
    "golden/reference",
    "hdl/netlist",
    "hdl/units",
    "sim/cycles",
];

/// Where a text goes.
#[derive(Debug, PartialEq)]
enum At {
    NewFile,
    Below(String),
    InPlaceOf(String),
}

/// Where the copy is, from its workspace: elsewhere than the crates are in theirs. Cargo takes
/// crates of one name and place for one, and both workspaces build into one folder.
const COPY: &str = "copy";

/// A change of a file.
#[derive(Debug, PartialEq)]
pub(super) struct Change {
    pub(super) path: String,
    at: At,
    text: String,
}

/// The changes of a page, in order.
pub(super) fn changes(page: &str) -> Vec<Change> {
    let mut out = vec![];
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let parts: Vec<_> = line.split('`').collect();
        let (path, at) = match parts[..] {
            ["New file ", path, ":"] => (path, At::NewFile),
            ["In ", path, ", below ", line, ":"] => (path, At::Below(line.to_owned())),
            ["In ", path, ", in place of ", line, ":"] => (path, At::InPlaceOf(line.to_owned())),
            _ => continue,
        };
        let block = lines.by_ref().skip_while(|line| !line.starts_with("```"));
        let block = block.skip(1).take_while(|line| !line.starts_with("```"));
        out.push(Change {
            path: path.to_owned(),
            at,
            text: block.map(|line| line.to_owned() + "\n").collect(),
        });
    }
    out
}

/// A file with a change made.
fn changed(old: &str, change: &Change) -> String {
    let (line, kept) = match &change.at {
        At::NewFile => return change.text.clone(),
        At::Below(line) => (format!("{line}\n"), true),
        At::InPlaceOf(line) => (format!("{line}\n"), false),
    };
    assert_eq!(old.matches(&line).count(), 1, "{}: `{line}`", change.path);
    let before = if kept { &*line } else { "" };
    old.replace(&line, &format!("{before}{}", change.text))
}

/// The changes of all pages.
fn all_changes() -> Vec<Change> {
    let pages = PAGES
        .iter()
        .map(|(page, _)| changes(&read(&root().join(page))));
    pages.flatten().collect()
}

/// At most eight files, which a search for the form's name finds.
#[test]
fn an_exponential_form_touches_eight_files() {
    let changes = changes(&read(&root().join(PAGES[0].0)));
    let files: BTreeSet<_> = changes.iter().map(|c| &c.path).collect();
    assert_eq!(files.len(), 8, "{files:?}");
    for change in &changes {
        let named = change.path.contains(FORM) || change.text.contains(FORM);
        assert!(named, "{change:?}");
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
    let members = CRATES.iter().chain(&["followed"]);
    let members: Vec<_> = members
        .map(|c| toml::Value::from(format!("{COPY}/{c}")))
        .collect();
    workspace.insert("members".to_owned(), members.into());
    workspace.remove("default-members");
    let needed = workspace["dependencies"].as_table_mut().unwrap();
    for needed in needed.iter_mut().filter_map(|(_, d)| d.as_table_mut()) {
        if let Some(path) = needed.get_mut("path") {
            *path = format!("{COPY}/{}", path.as_str().unwrap()).into();
        }
    }
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
    let changes = all_changes();
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
    for change in changes.iter().filter(|c| c.at == At::NewFile) {
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
    let mut presets = vec![];
    files(&root().join("configs"), &mut presets);
    for path in presets {
        let own = path.strip_prefix(root()).unwrap();
        write(&folder.join(own), &std::fs::read(&path).unwrap());
    }
    let own = folder.join("followed");
    for (_, name) in PAGES {
        let test = read(&root().join(format!("sim/rtl/tests/rtl/{name}.rs")));
        write(&own.join(format!("tests/{name}.rs")), test.as_bytes());
    }
    write(&own.join("src/lib.rs"), b"//! Nothing.\n");
    let needed = ["formats", "netlist", "units", "reference", "cycles"];
    let needed = needed.map(|name| format!("potamoi-{name}.workspace = true\n"));
    let text = format!(
        "[package]\nname = \"followed\"\nedition = \"2024\"\n\n[dependencies]\n{}",
        needed.concat()
    );
    write(&own.join("Cargo.toml"), text.as_bytes());
}

/// Each change has one place in today's sources, and what comes of it is Rust as `rustfmt` writes it.
#[test]
fn what_the_pages_add_fits_the_sources() {
    let folder = tempfile::tempdir().unwrap();
    copy(folder.path());
    let changes = all_changes();
    let paths: BTreeSet<_> = changes.iter().map(|c| &c.path).collect();
    for path in paths {
        let file = folder.path().join(path);
        let text = read(&file);
        for change in changes.iter().filter(|c| c.path == *path) {
            assert!(text.contains(&change.text), "{change:?}");
        }
        // From standard input: modules of the file are left out.
        let done = Command::new("rustfmt")
            .args(["--edition", "2024", "--check", "--config-path"])
            .arg(root())
            .stdin(std::fs::File::open(&file).unwrap())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&done.stdout) + String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success(), "{path}: {said}");
    }
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn what_the_pages_add_passes_its_tests() {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let folder = scratch.join("followed");
    copy(&folder.join(COPY));
    write(&folder.join("Cargo.toml"), manifest().as_bytes());
    // Cargo leaves out of it what these crates do not need.
    let (lock, given) = (read(&root().join("Cargo.lock")), folder.join("given.lock"));
    if !std::fs::read_to_string(&given).is_ok_and(|old| old == lock) {
        write(&given, lock.as_bytes());
        write(&folder.join("Cargo.lock"), lock.as_bytes());
    }
    // The crates of others are built there already.
    let built = scratch.parent().unwrap();
    for tests in [
        &["-p", "potamoi-reference", "--lib", FORM][..],
        &["-p", "followed", "--test", "every_form"],
        &["-p", "followed", "--test", "every_operation"],
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
    let page = "New file `a.rs`:\n\n```rust\none\n```\n\nIn `b.rs`, below `  two;`:\n\n```rust\n  three;\n```\n\
                In `b.rs`, in place of `1;`:\n```rust\n0;\n```\n";
    let found = changes(page);
    assert_eq!(found.len(), 3);
    assert_eq!(changed("", &found[0]), "one\n");
    let below = changed("1;\n  two;\n4;\n", &found[1]);
    assert_eq!(below, "1;\n  two;\n  three;\n4;\n");
    assert_eq!(changed(&below, &found[2]), "0;\n  two;\n  three;\n4;\n");
}
