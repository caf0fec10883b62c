//! Reports and their published schemas.

use std::path::Path;

use serde_json::Value;

/// What a report breaks of its schema; none where the value is no report of a command.
pub(crate) fn faults_of(value: &Value) -> Vec<String> {
    let Some(command) = value.get("command").and_then(Value::as_str) else {
        return vec![];
    };
    if value.get("format_version").is_none() {
        return vec![];
    }
    let name = command.replace(" --", "-");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/schemas");
    let text = std::fs::read_to_string(folder.join(format!("{name}.json")));
    let text = text.unwrap_or_else(|error| panic!("no schema of `{command}`: {error}"));
    let schema = serde_json::from_str(&text).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let errors = validator.iter_errors(value);
    errors
        .map(|error| format!("{command} {}: {error}", error.instance_path))
        .collect()
}

/// Panics where a report breaks its schema.
pub(super) fn check(value: &Value) {
    let faults = faults_of(value);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
