//! Objects that allow no key beside those of their type.

use std::collections::BTreeSet;

use serde_json::{Map, Value};

/// Keywords under which a schema has others that hold of the same value.
const PARTS: [&str; 3] = ["allOf", "anyOf", "oneOf"];
/// Keywords whose value is a schema, for a value within.
const INNER: [&str; 2] = ["items", "additionalProperties"];
/// Keywords whose value has schemas by name.
const NAMED: [&str; 2] = ["properties", "$defs"];

/// Closes all objects whose keys are listed.
pub(super) fn close(schema: &mut Value) {
    let mut open = BTreeSet::new();
    visit(schema, false, &mut |own, is_part| {
        let refers = own.get("$ref").and_then(Value::as_str);
        if is_part || own.contains_key("properties") {
            open.extend(refers.map(str::to_owned));
        }
    });
    // A definition that is a part of others is closed where it is used.
    for path in &open {
        let name = path.rsplit('/').next().unwrap_or_default();
        schema["$defs"][name][OPEN] = true.into();
    }
    visit(schema, false, &mut |own, is_part| {
        let has_keys = own.contains_key("properties");
        let is_kept = own.remove(OPEN).is_some() || is_part;
        let refers = own.get("$ref").and_then(Value::as_str);
        let takes_open = refers.is_some_and(|path| open.contains(path));
        if is_kept || own.contains_key("additionalProperties") || !(has_keys || takes_open) {
            return;
        }
        let is_whole = refers.is_none() && !PARTS.iter().any(|name| own.contains_key(*name));
        let word = match is_whole {
            true => "additionalProperties",
            false => "unevaluatedProperties",
        };
        own.insert(word.to_owned(), false.into());
    });
}

/// Marks a definition while others are closed.
const OPEN: &str = "$open";

/// Shows every schema within one. `is_part` where a schema around it has keys of the same object, and is
/// closed itself.
fn visit(schema: &mut Value, is_part: bool, show: &mut impl FnMut(&mut Map<String, Value>, bool)) {
    let Value::Object(own) = schema else {
        return;
    };
    let has_keys = own.contains_key("properties");
    for name in INNER {
        own.get_mut(name)
            .into_iter()
            .for_each(|s| visit(s, false, show));
    }
    for name in NAMED {
        let all = own.get_mut(name).and_then(Value::as_object_mut);
        for inner in all.into_iter().flat_map(Map::values_mut) {
            visit(inner, false, show);
        }
    }
    let parts = PARTS.map(|name| (name, is_part || has_keys));
    for (name, are_parts) in parts.into_iter().chain([("prefixItems", false)]) {
        let all = own.get_mut(name).and_then(Value::as_array_mut);
        for inner in all.into_iter().flatten() {
            visit(inner, are_parts, show);
        }
    }
    show(own, is_part);
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn objects_are_closed_once_around_their_parts() {
        let a = json!({ "type": "object", "properties": { "a": { "type": "integer" } } });
        let mut plain = json!({ "items": a });
        close(&mut plain);
        assert_eq!(plain["items"]["additionalProperties"], false);

        let mut mixed = a.clone();
        mixed["oneOf"] = json!([a, { "properties": { "b": a } }]);
        close(&mut mixed);
        assert_eq!(mixed["unevaluatedProperties"], false);
        assert!(mixed["oneOf"][0].get("additionalProperties").is_none());
        let inner = &mixed["oneOf"][1]["properties"]["b"];
        assert_eq!(inner["additionalProperties"], false);

        let mut choice = json!({ "anyOf": [a] });
        close(&mut choice);
        assert_eq!(choice["anyOf"][0]["additionalProperties"], false);

        let mut map = json!({ "type": "object", "additionalProperties": a });
        close(&mut map);
        let inner = &map["additionalProperties"];
        assert_eq!(inner["additionalProperties"], false);
    }

    #[test]
    fn definitions_that_are_parts_are_closed_where_they_are_used() {
        let a = json!({ "type": "object", "properties": { "a": { "type": "integer" } } });
        let mut schema = json!({
            "properties": {
                "tagged": { "properties": { "state": {} }, "$ref": "#/$defs/A" },
                "alone": { "$ref": "#/$defs/A" },
                "other": { "$ref": "#/$defs/B" },
            },
            "$defs": { "A": a, "B": a },
        });
        close(&mut schema);
        let keys = &schema["properties"];
        assert_eq!(keys["tagged"]["unevaluatedProperties"], false);
        assert_eq!(keys["alone"]["unevaluatedProperties"], false);
        assert!(keys["other"].get("unevaluatedProperties").is_none());
        assert_eq!(schema["$defs"]["A"], a);
        assert_eq!(schema["$defs"]["B"]["additionalProperties"], false);
    }
}
