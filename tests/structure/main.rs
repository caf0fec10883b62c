//! What ARCHITECTURE.md promises: dependencies point one way, and unsafe code stays in one place.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod crates;
mod dependencies;
mod module_files;
mod modules;
mod release;

use std::path::Path;

/// The folder of the workspace.
fn root() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().nth(2).unwrap()
}

/// Every file below a folder whose name ends so, build output left out.
fn files(folder: &Path, end: &str, found: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && name != "out" && !name.starts_with('.') {
            files(&path, end, found);
        } else if name.ends_with(end) {
            found.push(path);
        }
    }
}

/// Documents lead somewhere: every path in backticks below a folder of the tree exists. Paths with
/// placeholders are left out, as are code blocks.
#[test]
fn paths_in_the_documents_exist() {
    let root = root();
    let tops = [
        "docs", "formats", "golden", "hdl", "sim", "src", "tests", "tools",
    ];
    let mut pages = vec![root.join("README.md"), root.join("CONTRIBUTING.md")];
    files(&root.join("docs"), ".md", &mut pages);
    let mut named = 0;
    for page in pages {
        let text = std::fs::read_to_string(&page).unwrap();
        // What a reader is told to make is not there yet.
        let text: String = text
            .lines()
            .filter(|line| !line.starts_with("New file "))
            .flat_map(|line| [line, "\n"])
            .collect();
        let prose = text.split("```").step_by(2);
        let words = prose.flat_map(|part| part.split('`').skip(1).step_by(2));
        for word in words {
            let is_path = tops.iter().any(|top| word.starts_with(&format!("{top}/")));
            if is_path
                && !word.contains([' ', '*', '<', '{', '('])
                && !word.contains("NAME")
                && !word.contains("NNNN")
            {
                named += 1;
                let file = word.split(':').next().unwrap();
                assert!(root.join(file).exists(), "{}: {word}", page.display());
            }
        }
    }
    assert!(named > 100, "{named}");
}

/// The compiler denies it wherever the workspace's lints hold and are not
/// lifted; no file outside the binding lifts them.
#[test]
fn unsafe_code_is_in_the_verilator_binding_alone() {
    let root = root();
    let table = |path: &Path| {
        let text = std::fs::read_to_string(path).unwrap();
        text.parse::<toml::Table>().unwrap()
    };
    let workspace = table(&root.join("Cargo.toml"));
    assert_eq!(
        workspace["workspace"]["lints"]["rust"]["unsafe_code"].as_str(),
        Some("deny")
    );
    let mut manifests = vec![];
    files(root, "Cargo.toml", &mut manifests);
    assert!(manifests.len() >= 7, "{manifests:?}");
    for path in manifests {
        let own = table(&path);
        let lints = own.get("lints");
        let has = |field: &str, of: Option<&toml::Value>| of.and_then(|t| t.get(field)).cloned();
        let inherits = has("workspace", lints) == Some(toml::Value::Boolean(true));
        // A package apart from the workspace says it itself.
        let denied = has("unsafe_code", has("rust", lints).as_ref());
        let denies = own.contains_key("workspace") && denied == Some("deny".into());
        assert!(inherits || denies, "{}", path.display());
    }

    let mut sources = vec![];
    files(root, ".rs", &mut sources);
    assert!(sources.len() > 100);
    let lint = concat!("unsafe", "_code,");
    let names = |end: &str| lint.replace(',', end);
    let lifting = sources.iter().filter(|path| {
        let text = std::fs::read_to_string(path).unwrap();
        [",", ")", "\n"]
            .iter()
            .any(|end| text.contains(&names(end)))
    });
    assert_eq!(
        lifting.collect::<Vec<_>>(),
        [&root.join("sim/verilated/src/lib.rs")]
    );
}
