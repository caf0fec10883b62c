//! JSON objects whose fields are taken one by one, so that what no one takes is known.

use std::fmt;

use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::error::Category;
use serde_json::{Map, Value};

use super::error::{FileError, Origin};
use potamoi_base::file_keys::told;

/// The byte order mark that some editors prepend.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
/// Longest value in messages, in characters.
const TOLD: usize = 60;

/// A value in which no object has a field twice.
struct Unique(Value);

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Uniques).map(Self)
    }
}

struct Uniques;

impl<'de> Visitor<'de> for Uniques {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        let mut all = Map::new();
        while let Some((key, Unique(value))) = map.next_entry::<String, Unique>()? {
            if all.contains_key(&key) {
                let key = told(&key);
                return Err(A::Error::custom(format!("field `{key}` is given twice")));
            }
            all.insert(key, value);
        }
        Ok(Value::Object(all))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        let mut all = vec![];
        while let Some(Unique(value)) = list.next_element()? {
            all.push(value);
        }
        Ok(Value::Array(all))
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }
}

/// An object, of which fields are taken.
#[derive(Debug)]
pub(super) struct Object<'a> {
    /// Where it stands, for errors: `nodes[3]`.
    place: String,
    /// The same without indices, for the table of keys: `nodes`.
    key: String,
    left: Map<String, Value>,
    name: Origin<'a>,
}

impl<'a> Object<'a> {
    /// Reads the outermost object of a text; `part` names the text in errors.
    pub(super) fn read(text: &[u8], part: &str, name: Origin<'a>) -> Result<Self, FileError> {
        let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        let value = serde_json::from_slice(text).map_err(|e| {
            let problem = match e.classify() {
                Category::Data => e.to_string(),
                _ => format!("line {}, column {}: this is no JSON", e.line(), e.column()),
            };
            name.part(part, problem)
        });
        let Unique(Value::Object(left)) = value? else {
            return Err(name.part(part, "an object in braces is expected"));
        };
        Ok(Self {
            place: String::new(),
            key: String::new(),
            left,
            name,
        })
    }

    fn inner(&self, value: Value, place: String, key: &str) -> Result<Self, FileError> {
        match value {
            Value::Object(left) => Ok(Self {
                key: join(&self.key, key),
                place,
                left,
                name: self.name,
            }),
            other => Err(self.name.field(place, shown(&other), "an object in braces")),
        }
    }

    /// The same object under a shorter key in the table.
    pub(super) fn named(self, key: &str) -> Self {
        Self {
            key: key.to_owned(),
            ..self
        }
    }

    /// The field's place, for errors.
    pub(super) fn place(&self, key: &str) -> String {
        join(&self.place, key)
    }

    /// An error about a field.
    pub(super) fn wrong(&self, key: &str, value: impl ToString, expected: &str) -> FileError {
        self.name.field(self.place(key), value, expected)
    }

    /// Takes a field of any kind.
    pub(super) fn take(&mut self, key: &str) -> Option<Value> {
        self.left.shift_remove(key)
    }

    /// Takes a field that `of` understands.
    fn taken<T>(
        &mut self,
        key: &str,
        expected: &str,
        of: impl Fn(&Value) -> Option<T>,
    ) -> Result<Option<T>, FileError> {
        match self.take(key) {
            None => Ok(None),
            Some(value) => match of(&value) {
                Some(own) => Ok(Some(own)),
                None => Err(self.wrong(key, shown(&value), expected)),
            },
        }
    }

    /// Takes a whole number of at least 0.
    pub(super) fn whole(&mut self, key: &str) -> Result<Option<usize>, FileError> {
        self.taken(key, "a whole number of at least 0", whole)
    }

    /// Takes a whole number that must be there.
    pub(super) fn needed(&mut self, key: &str) -> Result<usize, FileError> {
        let found = self.whole(key)?;
        found.ok_or_else(|| self.wrong(key, "missing", "a whole number of at least 0"))
    }

    /// Takes a text.
    pub(super) fn text(&mut self, key: &str) -> Result<Option<String>, FileError> {
        self.taken(key, "a text", |value| value.as_str().map(str::to_owned))
    }

    /// Takes true or false.
    pub(super) fn flag(&mut self, key: &str) -> Result<Option<bool>, FileError> {
        self.taken(key, "true or false", Value::as_bool)
    }

    /// Takes finite numbers, as many as the result holds.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        key: &str,
    ) -> Result<Option<[f64; N]>, FileError> {
        self.taken(key, &format!("{N} finite numbers"), |value| {
            let all = value.as_array()?.iter();
            let numbers: Option<Vec<f64>> = all
                .map(|own| own.as_f64().filter(|v| v.is_finite()))
                .collect();
            numbers?.try_into().ok()
        })
    }

    /// Takes a list of texts; none if it is missing.
    pub(super) fn texts(&mut self, key: &str) -> Result<Vec<String>, FileError> {
        let found = self.taken(key, "a list of texts", |value| {
            let texts = value.as_array()?.iter();
            texts.map(|own| own.as_str().map(str::to_owned)).collect()
        });
        Ok(found?.unwrap_or_default())
    }

    /// Takes a list of whole numbers; none if it is missing.
    pub(super) fn wholes(&mut self, key: &str) -> Result<Option<Vec<usize>>, FileError> {
        self.taken(key, "a list of whole numbers of at least 0", |value| {
            value.as_array()?.iter().map(whole).collect()
        })
    }

    /// Takes an object.
    pub(super) fn object(&mut self, key: &str) -> Result<Option<Self>, FileError> {
        let place = self.place(key);
        match self.take(key) {
            Some(value) => self.inner(value, place, key).map(Some),
            None => Ok(None),
        }
    }

    /// Takes a list of objects; none if it is missing.
    pub(super) fn objects(&mut self, key: &str) -> Result<Vec<Self>, FileError> {
        let place = self.place(key);
        match self.take(key) {
            None => Ok(vec![]),
            Some(Value::Array(all)) => (all.into_iter().enumerate())
                .map(|(i, value)| self.inner(value, format!("{place}[{i}]"), key))
                .collect(),
            Some(other) => Err(self.wrong(key, shown(&other), "a list of objects")),
        }
    }

    /// Names of the fields that are left.
    pub(super) fn names(&self) -> Vec<String> {
        self.left.keys().cloned().collect()
    }

    /// Adds the keys that no reader took to `rest`.
    pub(super) fn finish(self, rest: &mut Vec<String>) {
        rest.extend(self.left.keys().map(|own| join(&self.key, own)));
    }
}

fn join(before: &str, key: &str) -> String {
    match before {
        "" => key.to_owned(),
        before => format!("{before}.{key}"),
    }
}

/// A whole number, written with or without a decimal point.
fn whole(value: &Value) -> Option<usize> {
    let float = value.as_f64();
    let float = float.filter(|v| v.fract() == 0.0 && (0.0..9e15).contains(v));
    let found = value.as_u64().or(float.map(|v| v as u64))?;
    usize::try_from(found).ok()
}

/// The beginning of a value, for error messages.
fn shown(value: &Value) -> String {
    match value {
        Value::Object(_) => "an object".to_owned(),
        Value::Array(all) => format!("a list of {}", all.len()),
        other => potamoi_base::file_keys::told_within(&other.to_string(), TOLD),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_no_one_takes_is_left_under_its_path() {
        let text = br#"{"a": {"b": [1, 2.0], "c": "d", "x": 1}, "n": [{"k": 3, "y": null}]}"#;
        let mut whole = Object::read(text, "t", Origin("f")).unwrap();
        let mut a = whole.object("a").unwrap().unwrap();
        assert_eq!(a.wholes("b").unwrap().unwrap(), [1, 2]);
        assert_eq!(a.text("c").unwrap().unwrap(), "d");
        let mut n = whole.objects("n").unwrap().remove(0);
        assert_eq!(n.needed("k").unwrap(), 3);
        let missing = n.needed("z").unwrap_err().to_string();
        assert!(missing.contains("f: n[0].z is missing"), "{missing}");
        let mut rest = vec![];
        for own in [a, n, whole] {
            own.finish(&mut rest);
        }
        assert_eq!(rest, ["a.x", "n.y"]);
    }

    #[test]
    fn no_field_is_given_twice_at_any_depth() {
        for text in [r#"{"a":1,"a":2}"#, r#"{"l":[{"b":1,"b":1}]}"#] {
            let error = Object::read(text.as_bytes(), "t", Origin("f")).unwrap_err();
            assert!(error.to_string().contains("is given twice"), "{error}");
        }
        assert!(Object::read("[".repeat(1 << 20).as_bytes(), "t", Origin("f")).is_err());
        assert!(Object::read(b"[1]", "t", Origin("f")).is_err());
    }
}
