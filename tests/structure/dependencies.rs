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

/// The memory oracle is a workspace of its own, whose lock file no other build renews.
#[test]
fn the_lock_file_of_the_memory_oracle_is_of_today_s_crates() {
    let table = |path: &std::path::Path| -> toml::Table {
        std::fs::read_to_string(path).unwrap().parse().unwrap()
    };
    let mut manifests = vec![];
    super::files(super::root(), "Cargo.toml", &mut manifests);
    let mut own = std::collections::BTreeMap::new();
    for manifest in manifests.iter().map(|path| table(path)) {
        let Some(name) = manifest.get("package").and_then(|p| p["name"].as_str()) else {
            continue;
        };
        let dependencies = manifest.get("dependencies").and_then(|d| d.as_table());
        let names: std::collections::BTreeSet<String> = dependencies
            .into_iter()
            .flat_map(|d| d.keys().cloned())
            .collect();
        own.insert(name.to_owned(), names);
    }
    let lock = table(&super::root().join("sim/dram-oracle/Cargo.lock"));
    let mut count = 0;
    for package in lock["package"].as_array().unwrap() {
        let name = package["name"].as_str().unwrap();
        let Some(expected) = own.get(name).filter(|_| name != "potamoi-dram-oracle") else {
            continue;
        };
        let found = package.get("dependencies").and_then(|d| d.as_array());
        let found: std::collections::BTreeSet<String> = (found.into_iter().flatten())
            .filter_map(|d| Some(d.as_str()?.split(' ').next()?.to_owned()))
            .collect();
        assert_eq!(
            &found, expected,
            "{name}; again: cargo update --workspace --manifest-path sim/dram-oracle/Cargo.toml"
        );
        count += 1;
    }
    assert!(count > 5, "{count}");
}
