#![allow(clippy::unwrap_used)]
use std::collections::BTreeSet;
use std::path::Path;

use clap::CommandFactory as _;
use serde_json::Value;

use super::*;
use crate::cli::Cli;

#[test]
fn every_command_with_a_report_publishes_its_schema() {
    let cli = Cli::command();
    let has_report = |own: &&clap::Command| own.get_arguments().any(|flag| flag.get_id() == "json");
    let commands = cli.get_subcommands().filter(has_report);
    let commands: Vec<&str> = commands.map(clap::Command::get_name).collect();
    let first = |own: &Published| own.command.split(' ').next().unwrap();
    let mut published: Vec<&str> = all().map(first).collect();
    published.dedup();
    assert_eq!(published, commands);
}

#[test]
fn schemas_are_those_of_the_types() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/schemas");
    let is_refresh = std::env::var_os("POTAMOI_REFRESH").is_some();
    let mut names = BTreeSet::new();
    for own in all() {
        let path = folder.join(format!("{}.json", own.name()));
        let now = own.text().unwrap();
        names.insert(path.clone());
        if is_refresh {
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(&path, now).unwrap();
            continue;
        }
        let kept = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            kept == now,
            "{}: not the schema of what {} writes; write it with\n\
             POTAMOI_REFRESH=1 cargo test --bin potamoi schemas\n\
             and raise its FORMAT_VERSION where a key went or means something else",
            path.display(),
            own.command
        );
    }
    let files = std::fs::read_dir(&folder)
        .unwrap()
        .map(|e| e.unwrap().path());
    assert_eq!(files.collect::<BTreeSet<_>>(), names);
}

/// Whether a schema allows any key of its own object.
fn open_objects(schema: &Value, at: &str, found: &mut Vec<String>) {
    match schema {
        Value::Object(own) => {
            if own.get("additionalProperties") == Some(&Value::Bool(true)) {
                found.push(at.to_owned());
            }
            for (key, inner) in own {
                open_objects(inner, &format!("{at}/{key}"), found);
            }
        }
        Value::Array(all) => all.iter().for_each(|own| open_objects(own, at, found)),
        _ => {}
    }
}

#[test]
fn objects_with_any_key_are_few_and_known() {
    let mut found = vec![];
    for own in all() {
        open_objects(&own.schema(), own.command, &mut found);
    }
    // Plots are specifications of Vega-Lite.
    assert_eq!(found, ["report/$defs/Document/properties/plots"]);
}

#[test]
fn every_report_has_its_version_and_its_command() {
    for own in all() {
        let schema = own.schema();
        let shapes = schema["anyOf"].as_array().cloned();
        for shape in shapes.unwrap_or_else(|| vec![schema.clone()]) {
            let name = shape["$ref"].as_str().unwrap().rsplit('/').next().unwrap();
            let keys = &schema["$defs"][name]["properties"];
            assert_eq!(
                keys["format_version"]["const"], own.version,
                "{}",
                own.command
            );
            assert_eq!(keys["command"]["const"], own.command);
        }
    }
}
