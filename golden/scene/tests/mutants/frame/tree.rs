//! Trees of values: JSON, TOML and MessagePack.

use super::Rng;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Tree {
    Null,
    Bool(bool),
    Whole(i128),
    Float(f64),
    Text(String),
    Bytes(Vec<u8>),
    List(Vec<Tree>),
    Map(Vec<(String, Tree)>),
}

impl Tree {
    /// Of JSON that is whole.
    pub(crate) fn of_json(bytes: &[u8]) -> Self {
        fn of(value: serde_json::Value) -> Tree {
            use serde_json::Value;
            match value {
                Value::Null => Tree::Null,
                Value::Bool(v) => Tree::Bool(v),
                Value::Number(n) => match (n.as_i64(), n.as_u64()) {
                    (Some(v), _) => Tree::Whole(v.into()),
                    (None, Some(v)) => Tree::Whole(v.into()),
                    _ => Tree::Float(n.as_f64().unwrap_or_default()),
                },
                Value::String(v) => Tree::Text(v),
                Value::Array(v) => Tree::List(v.into_iter().map(of).collect()),
                Value::Object(v) => Tree::Map(v.into_iter().map(|(k, v)| (k, of(v))).collect()),
            }
        }
        of(serde_json::from_slice(bytes).expect("whole JSON"))
    }

    /// Of TOML that is whole.
    pub(crate) fn of_toml(text: &str) -> Self {
        fn of(value: toml::Value) -> Tree {
            use toml::Value;
            match value {
                Value::String(v) => Tree::Text(v),
                Value::Integer(v) => Tree::Whole(v.into()),
                Value::Float(v) => Tree::Float(v),
                Value::Boolean(v) => Tree::Bool(v),
                Value::Datetime(v) => Tree::Text(v.to_string()),
                Value::Array(v) => Tree::List(v.into_iter().map(of).collect()),
                Value::Table(v) => Tree::Map(v.into_iter().map(|(k, v)| (k, of(v))).collect()),
            }
        }
        let table: toml::Table = text.parse().expect("whole TOML");
        of(toml::Value::Table(table))
    }

    /// Of a whole MessagePack document.
    pub(crate) fn of_messages(mut bytes: &[u8]) -> Self {
        fn of(value: rmpv::Value) -> Tree {
            use rmpv::Value;
            match value {
                Value::Nil => Tree::Null,
                Value::Boolean(v) => Tree::Bool(v),
                Value::Integer(v) => Tree::Whole(match (v.as_i64(), v.as_u64()) {
                    (Some(v), _) => v.into(),
                    (None, v) => v.unwrap_or_default().into(),
                }),
                Value::F32(v) => Tree::Float(v.into()),
                Value::F64(v) => Tree::Float(v),
                Value::String(v) => Tree::Text(v.as_str().unwrap_or_default().to_owned()),
                Value::Binary(v) => Tree::Bytes(v),
                Value::Array(v) => Tree::List(v.into_iter().map(of).collect()),
                Value::Map(v) => {
                    let key = |k: rmpv::Value| k.as_str().unwrap_or_default().to_owned();
                    Tree::Map(v.into_iter().map(|(k, v)| (key(k), of(v))).collect())
                }
                Value::Ext(_, v) => Tree::Bytes(v),
            }
        }
        of(rmpv::decode::read_value(&mut bytes).expect("whole MessagePack"))
    }

    /// As JSON, with the words for what JSON has no numbers for.
    pub(crate) fn json(&self) -> Vec<u8> {
        let mut out = String::new();
        self.text(&mut out, ":", &["NaN", "Infinity", "-Infinity", "null"]);
        out.into_bytes()
    }

    /// As TOML, tables in lines of their own at the top alone.
    pub(crate) fn toml(&self) -> Vec<u8> {
        let mut out = String::new();
        let Self::Map(items) = self else {
            self.text(&mut out, "=", &["nan", "inf", "-inf", "null"]);
            return out.into_bytes();
        };
        for (key, value) in items {
            quoted(key, &mut out);
            out.push_str(" = ");
            value.text(&mut out, "=", &["nan", "inf", "-inf", "null"]);
            out.push('\n');
        }
        out.into_bytes()
    }

    fn text(&self, out: &mut String, between: &str, words: &[&str; 4]) {
        match self {
            Self::Null => out.push_str(words[3]),
            Self::Bool(v) => out.push_str(&v.to_string()),
            Self::Whole(v) => out.push_str(&v.to_string()),
            Self::Float(v) if v.is_nan() => out.push_str(words[0]),
            Self::Float(v) if v.is_infinite() => out.push_str(words[1 + usize::from(*v < 0.0)]),
            Self::Float(v) => out.push_str(&format!("{v:?}")),
            Self::Text(v) => quoted(v, out),
            Self::Bytes(v) => out.push_str(&format!("{v:?}")),
            Self::List(items) => {
                out.push('[');
                for (i, item) in items.iter().enumerate() {
                    out.push_str(if i > 0 { ", " } else { "" });
                    item.text(out, between, words);
                }
                out.push(']');
            }
            Self::Map(items) => {
                out.push('{');
                for (i, (key, item)) in items.iter().enumerate() {
                    out.push_str(if i > 0 { ", " } else { "" });
                    quoted(key, out);
                    out.push_str(between);
                    item.text(out, between, words);
                }
                out.push('}');
            }
        }
    }

    /// As MessagePack; floats keep 64 bits.
    pub(crate) fn messages(&self) -> Vec<u8> {
        fn of(tree: &Tree) -> rmpv::Value {
            use rmpv::Value;
            match tree {
                Tree::Null => Value::Nil,
                Tree::Bool(v) => Value::Boolean(*v),
                Tree::Whole(v) => match (i64::try_from(*v), u64::try_from(*v)) {
                    (Ok(v), _) => v.into(),
                    (_, Ok(v)) => v.into(),
                    _ => Value::F64(*v as f64),
                },
                Tree::Float(v) => Value::F64(*v),
                Tree::Text(v) => v.as_str().into(),
                Tree::Bytes(v) => Value::Binary(v.clone()),
                Tree::List(v) => Value::Array(v.iter().map(of).collect()),
                Tree::Map(v) => {
                    Value::Map(v.iter().map(|(k, v)| (k.as_str().into(), of(v))).collect())
                }
            }
        }
        let mut bytes = vec![];
        rmpv::encode::write_value(&mut bytes, &of(self)).expect("memory takes it");
        bytes
    }

    /// The value of a key that is there.
    pub(crate) fn at(&mut self, key: &str) -> &mut Self {
        let Self::Map(items) = self else {
            panic!("{key}: no map")
        };
        let found = items.iter_mut().find(|(own, _)| own == key);
        &mut found.unwrap_or_else(|| panic!("no {key}")).1
    }

    /// A node: at each fork one of the ways, so that long lists do not hide keys.
    fn node(&mut self, rng: &mut Rng) -> &mut Self {
        let count = match self {
            Self::List(items) => items.len(),
            Self::Map(items) => items.len(),
            _ => 0,
        };
        if count == 0 || rng.one_in(5) {
            return self;
        }
        let at = rng.below(count);
        match self {
            Self::List(items) => items[at].node(rng),
            Self::Map(items) => items[at].1.node(rng),
            _ => self,
        }
    }

    /// Changes one thing.
    pub(crate) fn mutate(&mut self, rng: &mut Rng) {
        if rng.one_in(15) {
            let other = self.node(rng).clone();
            *self.node(rng) = other;
        } else {
            self.node(rng).change(rng);
        }
    }

    fn change(&mut self, rng: &mut Rng) {
        if rng.one_in(14) {
            *self = match rng.below(8) {
                0 => Self::Null,
                1 => Self::Bool(true),
                2 => Self::List(vec![]),
                3 => Self::Map(vec![]),
                4 => Self::Text("1".to_owned()),
                5 => Self::List(vec![self.clone(); 2]),
                6 => {
                    let deep = *rng.pick(&[3, 100, 3000]);
                    (0..deep).fold(self.clone(), |own, _| Self::List(vec![own]))
                }
                _ => Self::Whole(0),
            };
            return;
        }
        match self {
            Self::Null => *self = Self::Whole(1),
            Self::Bool(v) => *v = !*v,
            Self::Whole(v) => match rng.below(6) {
                0 => *self = Self::Float(*v as f64),
                1 => *self = Self::Float(rng.float(*v as f64)),
                _ => *v = rng.integer(*v),
            },
            Self::Float(v) => match rng.below(6) {
                0 => *self = Self::Whole(*v as i128),
                1 => *self = Self::Whole(rng.integer(*v as i128)),
                _ => *v = rng.float(*v),
            },
            Self::Text(v) => *v = rng.text(v),
            Self::Bytes(v) => super::flat::change(v, rng, &[2, 4]),
            Self::List(items) => change_list(items, rng),
            Self::Map(items) => change_map(items, rng),
        }
    }
}

fn change_list(items: &mut Vec<Tree>, rng: &mut Rng) {
    if items.is_empty() {
        items.push(Tree::Whole(0));
        return;
    }
    let (at, other) = (rng.below(items.len()), rng.below(items.len()));
    match rng.below(6) {
        0 => items.truncate(at),
        1 => items.push(items[at].clone()),
        2 => items.insert(at, items[other].clone()),
        3 => items.swap(at, other),
        4 => drop(items.remove(at)),
        _ => items.extend_from_within(..),
    }
}

fn change_map(items: &mut Vec<(String, Tree)>, rng: &mut Rng) {
    if items.is_empty() {
        items.push(("x".to_owned(), Tree::Whole(0)));
        return;
    }
    let (at, other) = (rng.below(items.len()), rng.below(items.len()));
    match rng.below(8) {
        0 | 1 => drop(items.remove(at)),
        2 => items.push(items[at].clone()),
        3 => items[at].0 = rng.text(&items[at].0),
        4 => items.insert(at, ("unheard_of".to_owned(), Tree::Float(0.5))),
        5 => {
            // Minimum and maximum, width and height.
            let value = items[at].1.clone();
            items[at].1 = std::mem::replace(&mut items[other].1, value);
        }
        6 => items.reverse(),
        _ => items[at].1 = Tree::Null,
    }
}

/// Quoted as JSON and TOML both read it.
fn quoted(text: &str, out: &mut String) {
    out.push('"');
    for character in text.chars() {
        match character {
            '"' | '\\' => out.extend(['\\', character]),
            c if (c as u32) < 0x20 || c as u32 == 0x7f => {
                out.push_str(&format!("\\u{:04x}", c as u32));
            }
            c => out.push(c),
        }
    }
    out.push('"');
}

/// Seldom, what is done to a text as a whole.
pub(crate) fn around(mut bytes: Vec<u8>, rng: &mut Rng) -> Vec<u8> {
    if !rng.one_in(10) {
        return bytes;
    }
    match rng.below(6) {
        0 => bytes.splice(0..0, *b"\xef\xbb\xbf").for_each(drop),
        1 => bytes.extend(b"\n{}"),
        2 => bytes.extend(b"\xff\xfe"),
        3 => {
            let text = String::from_utf8_lossy(&bytes).replace('\n', "\r\n");
            bytes = text.into_bytes();
        }
        _ => rng.damage(&mut bytes),
    }
    bytes
}

/// A mutant of JSON.
pub(crate) fn json(bytes: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut tree = Tree::of_json(bytes);
    (0..rng.few()).for_each(|_| tree.mutate(rng));
    around(tree.json(), rng)
}

/// A mutant of TOML.
pub(crate) fn toml(text: &str, rng: &mut Rng) -> Vec<u8> {
    let mut tree = Tree::of_toml(text);
    (0..rng.few()).for_each(|_| tree.mutate(rng));
    around(tree.toml(), rng)
}
