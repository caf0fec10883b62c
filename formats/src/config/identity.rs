//! Identity of a configuration in headers, traces and results.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

/// Values of all fields of a configuration as JSON text, by the field's path.
fn fields(config: &impl Serialize) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    // Fields of a configuration are numbers, texts and lists of them.
    let whole = serde_json::to_value(config).unwrap_or_default();
    leaves(&whole, "", &mut found);
    found
}

fn leaves(value: &Value, path: &str, found: &mut BTreeMap<String, String>) {
    match value {
        Value::Object(inner) => {
            for (name, value) in inner {
                let path = match path {
                    "" => name.clone(),
                    path => format!("{path}.{name}"),
                };
                leaves(value, &path, found);
            }
        }
        leaf => {
            found.insert(path.to_owned(), leaf.to_string());
        }
    }
}

/// Hash of the fields of `config` that differ from `plain`, 12 hexadecimal digits.
pub(super) fn hash<T: Serialize>(config: &T, plain: &T) -> String {
    let defaults = fields(plain);
    let mut all = blake3::Hasher::new();
    for (path, value) in fields(config) {
        if defaults.get(&path) != Some(&value) {
            all.update(format!("{path} = {value}\n").as_bytes());
        }
    }
    all.finalize().to_hex()[..12].to_owned()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::config::{Config, PRESETS};

    /// Each field of each preset in serialised form, changed alone, changes the hash.
    #[test]
    fn the_hash_follows_every_field() {
        let plain = fields(&Config::default());
        let hash_of = |changed: &BTreeMap<String, String>| hash(changed, &plain);
        for (name, text) in PRESETS {
            let own = fields(&Config::from_toml(text, name).unwrap());
            assert!(own.len() > 30, "{name}: {} fields", own.len());
            let mut seen = vec![hash_of(&own)];
            for field in own.keys() {
                let mut changed = own.clone();
                changed.insert(field.clone(), "\"other\"".to_owned());
                let hash = hash_of(&changed);
                assert!(!seen.contains(&hash), "{name}: {field}");
                seen.push(hash);
            }
        }
    }

    /// A new parameter with its default changes no configuration's hash.
    #[test]
    fn a_new_parameter_with_its_default_changes_no_hash() {
        let plain = fields(&Config::default());
        let mut wider = plain.clone();
        wider.insert("gu.new".to_owned(), "false".to_owned());
        for (name, text) in PRESETS {
            let own = fields(&Config::from_toml(text, name).unwrap());
            let mut same = own.clone();
            same.insert("gu.new".to_owned(), "false".to_owned());
            assert_eq!(hash(&own, &plain), hash(&same, &wider), "{name}");
            same.insert("gu.new".to_owned(), "true".to_owned());
            assert_ne!(hash(&own, &plain), hash(&same, &wider), "{name}");
        }
    }
}
