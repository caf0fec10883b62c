//! From bytes to values.

use std::borrow::Cow;
use std::cell::Cell;
use std::collections::HashSet;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use super::{Value, Wrong, foreign};
use crate::file_kinds::kind;

/// Largest number of values in a document: half a gigabyte of memory at 32 bytes each.
const MOST: usize = 1 << 24;
/// Byte-order mark of UTF-8.
const MARK: &[u8] = b"\xef\xbb\xbf";
/// Key under which TOML's reader presents a date.
const DATE: &str = "$__toml_private_datetime";
/// Replacement of bytes that are not UTF-8.
const LOST: char = '\u{fffd}';

/// Reads JSON.
///
/// # Errors
/// Invalid JSON, more than 16 million values, or a duplicate name.
pub fn json(bytes: &[u8]) -> Result<Value, Wrong> {
    let text = text(bytes)?;
    let mut reader = serde_json::Deserializer::from_str(&text);
    let left = Cell::new(MOST);
    let no_json = |error| match kind(bytes).or_else(|| is_toml(&text).then_some("TOML")) {
        Some(kind) => Wrong::found(kind, "JSON"),
        None => no_json(error),
    };
    let value = Seed(&left).deserialize(&mut reader).map_err(no_json)?;
    reader.end().map_err(no_json)?;
    checked(value, &text, bytes)
}

/// Reads TOML.
///
/// # Errors
/// As [`json`].
pub fn toml(bytes: &[u8]) -> Result<Value, Wrong> {
    let text = text(bytes)?;
    let no_toml = |e: toml::de::Error| {
        if let Some(kind) = kind(bytes).or_else(|| is_json(&text).then_some("JSON")) {
            return Wrong::found(kind, "TOML");
        }
        let at = e.span().map_or(0, |span| span.start);
        let message = foreign(&e.message().replace('\n', ", "));
        Wrong::new(format!("{}: invalid TOML: {message}", place(&text, at)))
    };
    let reader = toml::Deserializer::parse(&text).map_err(no_toml)?;
    let left = Cell::new(MOST);
    let value = Seed(&left).deserialize(reader).map_err(no_toml)?;
    checked(value, &text, bytes)
}

/// Converts TOML that was parsed elsewhere.
///
/// # Errors
/// It has more than 16 million values.
pub fn of_toml(table: toml::Table) -> Result<Value, Wrong> {
    let left = Cell::new(MOST);
    let value = Seed(&left).deserialize(toml::Value::Table(table));
    value.map_err(|e| Wrong::new(e.message()))
}

/// Converts a document to TOML. Nulls, which TOML does not have, are left out.
#[must_use]
pub fn to_toml(value: &Value) -> Option<toml::Value> {
    Some(match value {
        Value::Null => return None,
        Value::Bool(own) => toml::Value::Boolean(*own),
        Value::Int(own) => toml::Value::Integer(*own),
        Value::Large(own) => toml::Value::Float(*own as f64),
        Value::Float(own) => toml::Value::Float(*own),
        Value::Text(own) => toml::Value::String(own.to_string()),
        Value::List(all) => toml::Value::Array(all.iter().filter_map(to_toml).collect()),
        Value::Map(all) => {
            let all = all.iter();
            let entries = all.filter_map(|(key, own)| Some((key.to_string(), to_toml(own)?)));
            toml::Value::Table(entries.collect())
        }
    })
}

/// Text without byte-order mark. Bytes that are not UTF-8 are tolerated here; they are harmless in
/// comments.
fn text(bytes: &[u8]) -> Result<Cow<'_, str>, Wrong> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(Wrong::new("it is UTF-16 text: save it as UTF-8"));
    }
    let plain = bytes.strip_prefix(MARK).unwrap_or(bytes);
    Ok(String::from_utf8_lossy(plain))
}

/// Whether a text that is no TOML begins as JSON.
fn is_json(text: &str) -> bool {
    let text = text.trim_start();
    let list = text.strip_prefix('[').map(str::trim_start);
    text.starts_with('{') || list.is_some_and(|first| first.starts_with('{'))
}

/// Whether a text that is no JSON is TOML with a value.
fn is_toml(text: &str) -> bool {
    let table: Result<toml::Table, _> = toml::from_str(text);
    table.is_ok_and(|table| !table.is_empty())
}

/// Line and column of a byte, from 1.
fn place(text: &str, at: usize) -> String {
    let before = text.get(..at).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    let column = before[start..].chars().count() + 1;
    format!("line {line}, column {column}")
}

/// Wording of the JSON reader's errors.
fn no_json(e: serde_json::Error) -> Wrong {
    let (line, column) = (e.line(), e.column());
    let said = e.to_string();
    let said = said.split(" at line ").next().unwrap_or_default();
    let place = format!("line {line}, column {column}");
    let problem = match (e.classify(), said) {
        (serde_json::error::Category::Eof, _) => {
            "the text ends in the middle: a bracket, a quotation mark or a value is missing"
        }
        (serde_json::error::Category::Data, said) => said,
        (_, "number out of range") => "a number is too large for any type of number",
        (_, "recursion limit exceeded") => "brackets are nested too deeply: expected at most 127",
        (_, "trailing characters") => "something follows the end of the document: expected nothing",
        (_, "control character (\\u0000-\\u001F) found while parsing a string") => {
            "a control character or the end of a line within quotation marks"
        }
        _ => {
            "no JSON: a comma, colon, bracket or quotation mark is missing or too much, or a \
             value is none of JSON's, which NaN, Infinity and comments are not"
        }
    };
    Wrong::new(format!("{place}: {problem}"))
}

/// Refuses duplicate keys, and text that is not UTF-8 outside comments.
fn checked(value: Value, text: &str, bytes: &[u8]) -> Result<Value, Wrong> {
    let lossy = matches!(String::from_utf8_lossy(bytes), Cow::Owned(_));
    walk(&value, lossy).map_err(|wrong| match wrong {
        Some(wrong) => wrong,
        None => {
            let at = text.find(LOST).unwrap_or(0);
            Wrong::new(format!(
                "{}: the text is not UTF-8: save it as UTF-8",
                place(text, at)
            ))
        }
    })?;
    Ok(value)
}

/// `Err(None)`: a text has replaced bytes.
fn walk(value: &Value, lossy: bool) -> Result<(), Option<Wrong>> {
    let whole = |text: &str| match lossy && text.contains(LOST) {
        true => Err(None),
        false => Ok(()),
    };
    match value {
        Value::Text(text) => whole(text),
        Value::List(values) => {
            for (index, value) in values.iter().enumerate() {
                walk(value, lossy).map_err(|e| e.map(|e| e.at(index)))?;
            }
            Ok(())
        }
        Value::Map(entries) => {
            let mut seen = HashSet::with_capacity(entries.len());
            for (key, value) in entries {
                whole(key)?;
                if !seen.insert(key) {
                    let wrong = Wrong::new("it stands twice: expected once");
                    return Err(Some(wrong.under(key)));
                }
                walk(value, lossy).map_err(|e| e.map(|e| e.under(key)))?;
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

/// Builds a value from a reader's events, and counts down the values left.
#[derive(Clone, Copy)]
struct Seed<'a>(&'a Cell<usize>);

impl<'de> DeserializeSeed<'de> for Seed<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, reader: D) -> Result<Value, D::Error> {
        match self.0.get().checked_sub(1) {
            Some(left) => self.0.set(left),
            None => {
                let most = format!("more than {MOST} values, the most that are read");
                return Err(D::Error::custom(most));
            }
        }
        reader.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Seed<'_> {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(Value::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(Value::Int(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(i64::try_from(value).map_or(Value::Large(value), Value::Int))
    }

    // TOML's reader has room for these; no type here does.
    fn visit_i128<E>(self, value: i128) -> Result<Value, E> {
        Ok(Value::Float(value as f64))
    }

    fn visit_u128<E>(self, value: u128) -> Result<Value, E> {
        Ok(Value::Float(value as f64))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(Value::Float(value))
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(Value::Text(text.into()))
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> Result<Value, A::Error> {
        let mut values = vec![];
        while let Some(value) = access.next_element_seed(self)? {
            values.push(value);
        }
        Ok(Value::List(values.into()))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<Value, A::Error> {
        let mut entries = vec![];
        while let Some(key) = access.next_key::<String>()? {
            if key == DATE {
                return access.next_value_seed(self);
            }
            entries.push((key.into(), access.next_value_seed(self)?));
        }
        Ok(Value::Map(entries.into()))
    }
}
