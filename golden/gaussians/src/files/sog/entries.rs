//! All values of a JSON text with their paths, duplicates included. (The usual maps keep only the
//! last of two equal keys.)

use std::fmt;

use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::Value;

/// A JSON value; objects keep the order and duplicates of their fields.
enum Node {
    Object(Vec<(String, Self)>),
    Other(Value),
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Nodes)
    }
}

struct Nodes;

impl<'de> Visitor<'de> for Nodes {
    type Value = Node;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Node, A::Error> {
        let mut all = vec![];
        while let Some(entry) = map.next_entry()? {
            all.push(entry);
        }
        Ok(Node::Object(all))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Node, A::Error> {
        let mut all = vec![];
        while let Some(value) = list.next_element::<Value>()? {
            all.push(value);
        }
        Ok(Node::Other(all.into()))
    }

    fn visit_bool<E>(self, value: bool) -> Result<Node, E> {
        Ok(Node::Other(value.into()))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Node, E> {
        Ok(Node::Other(value.into()))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Node, E> {
        Ok(Node::Other(value.into()))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Node, E> {
        Ok(Node::Other(value.into()))
    }

    fn visit_str<E>(self, value: &str) -> Result<Node, E> {
        Ok(Node::Other(value.into()))
    }

    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Other(Value::Null))
    }
}

/// The fields of an object at any depth; `None` if the text is not an object.
///
/// # Errors
/// The text is not valid JSON.
pub(super) fn read(text: &[u8]) -> Result<Option<Vec<(String, Value)>>, serde_json::Error> {
    let Node::Object(fields) = serde_json::from_slice(text)? else {
        return Ok(None);
    };
    let mut all = vec![];
    for (key, node) in fields {
        flatten(key, node, &mut all);
    }
    Ok(Some(all))
}

fn flatten(path: String, node: Node, all: &mut Vec<(String, Value)>) {
    match node {
        Node::Other(value) => all.push((path, value)),
        Node::Object(fields) if fields.is_empty() => {
            all.push((path, Value::Object(Default::default())))
        }
        Node::Object(fields) => {
            for (key, node) in fields {
                flatten(format!("{path}.{key}"), node, all);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_field_is_kept() {
        let all = read(br#"{"a":{"b":[1,{"c":2}],"d":null},"a":{"b":-1.5},"e":{},"f":"g"}"#);
        let all = all.unwrap().unwrap();
        let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["a.b", "a.d", "a.b", "e", "f"]);
        assert_eq!(all[0].1.to_string(), r#"[1,{"c":2}]"#);
        assert!(read(b"[1]").unwrap().is_none() && read(b"{").is_err());
        assert!(read("[".repeat(1 << 20).as_bytes()).is_err());
    }
}
