//! Every dependency has its reason, and every reason its dependency.

use std::collections::BTreeSet;

/// Names before the reasons in `deny.toml`: `# name, name   why`.
fn with_reasons(text: &str) -> BTreeSet<String> {
    let rows = text.lines().filter_map(|line| line.strip_prefix("# "));
    let names = rows.filter_map(|row| row.split_once("  ").map(|(names, _)| names));
    names
        .flat_map(|names| names.split(','))
        // Beside a package's name stands the crate of ours that needs it.
        .filter_map(|name| name.split_whitespace().next())
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_dependency_has_a_reason() {
    let root = super::root();
    let read = |name: &str| std::fs::read_to_string(root.join(name)).unwrap();
    let workspace: toml::Table = read("Cargo.toml").parse().unwrap();
    let all = workspace["workspace"]["dependencies"].as_table().unwrap();
    let named: BTreeSet<String> = (all.iter())
        .filter(|(_, value)| value.get("path").is_none())
        .map(|(name, _)| name.clone())
        .collect();
    assert!(named.len() > 30);
    assert_eq!(with_reasons(&read("deny.toml")), named, "deny.toml");
}
