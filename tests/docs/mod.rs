//! The documents: their commands run, their links lead somewhere, every page is in the book, and
//! their pictures and figures are the program's.

mod adding;
mod commands;
mod figures;
mod flags;
mod followed;
mod links;
mod pictures;

use std::path::{Path, PathBuf};

use crate::common::shared;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files that end in `.md` in a folder and below it, in order. Links to them are other names.
fn pages_in(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![];
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_symlink() {
            continue;
        }
        if path.is_dir() {
            found.extend(pages_in(&path));
        } else if path.extension().is_some_and(|e| e == "md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// All pages for readers: the book, and those at the top of the repository.
fn pages() -> Vec<PathBuf> {
    let mut all = pages_in(&root().join("docs"));
    for name in [
        "README.md",
        "CONTRIBUTING.md",
        "SECURITY.md",
        "CHANGELOG.md",
    ] {
        all.push(root().join(name));
    }
    all
}

/// A page's path from the top of the repository.
fn name(page: &Path) -> String {
    let relative = page.strip_prefix(root()).unwrap_or(page);
    relative.to_string_lossy().into_owned()
}

fn read(page: &Path) -> String {
    std::fs::read_to_string(page).unwrap_or_else(|e| panic!("{}: {e}", page.display()))
}

/// An empty folder for commands of the book, but for links to the book's files, to test files and to real
/// scenes, where they are here: commands name those from the top of the repository.
fn folder_with_docs() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let files = folder.path().join("golden/tests");
    std::fs::create_dir_all(&files).unwrap();
    for (from, to) in [
        ("docs", "docs"),
        ("golden/tests/fixtures", "golden/tests/fixtures"),
    ] {
        std::os::unix::fs::symlink(root().join(from), folder.path().join(to)).unwrap();
    }
    if let Some(scenes) = shared().as_deref().and_then(Path::parent) {
        let scenes = scenes.canonicalize().unwrap();
        std::os::unix::fs::symlink(scenes, folder.path().join("shared")).unwrap();
    }
    folder
}
