//! What a release says of itself in several places.

use super::root;

fn read(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap()
}

/// The value after a word at the start of a line, without quotes.
fn after<'a>(text: &'a str, word: &str) -> &'a str {
    let line = text.lines().find_map(|line| line.strip_prefix(word));
    line.unwrap().trim_matches('"')
}

#[test]
fn versions_of_the_program_the_package_and_the_citation_agree() {
    let cargo = read("Cargo.toml");
    let own = after(&cargo, "version = ");
    assert_eq!(after(&read("python/pyproject.toml"), "version = "), own);
    assert_eq!(after(&read("CITATION.cff"), "version: "), own);
    let workspace: toml::Table = cargo.parse().unwrap();
    let all = workspace["workspace"]["dependencies"].as_table().unwrap();
    let ours = all.values().filter(|value| value.get("path").is_some());
    let versions: Vec<_> = ours.map(|value| value["version"].as_str()).collect();
    assert!(versions.len() > 20 && versions.iter().all(|version| *version == Some(own)));
}

#[test]
fn no_crate_goes_to_a_registry() {
    let mut manifests = vec![];
    super::files(root(), "Cargo.toml", &mut manifests);
    for path in manifests {
        let text = std::fs::read_to_string(&path).unwrap();
        let is_package = text.contains("[package]");
        let is_kept = text.contains("publish = false") || text.contains("publish.workspace = true");
        assert!(
            !is_package || is_kept,
            "{}: publish = false",
            path.display()
        );
    }
}

#[test]
fn every_fitted_model_has_its_origin() {
    let page = read("golden/models/README.md");
    for entry in std::fs::read_dir(root().join("golden/models")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let is_named = name == "README.md" || page.contains(&format!("`{name}`"));
        assert!(is_named, "golden/models/README.md: {name}");
    }
}
