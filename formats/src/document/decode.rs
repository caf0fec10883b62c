//! From values to types.

use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error as _, IntoDeserializer, MapAccess, SeqAccess,
    VariantAccess, Visitor,
};

use super::{Value, Wrong};

const TEXT: &str = "a text in quotation marks";
const LIST: &str = "a list";
const SECTION: &str = "a section of named values";

fn wrong(value: &Value, expected: &str) -> Wrong {
    Wrong::found(value.shown(), expected)
}

/// What is expected in place of a value that is no whole number, or one beyond its ends.
fn whole_number(found: &Value, [low, high]: [i128; 2]) -> String {
    match (found, found.whole()) {
        (_, Some(own)) if own < low => format!("a whole number, {low} or more"),
        (_, Some(_)) => format!("a whole number, {high} at most"),
        (Value::Float(own), _) if own.abs() > 1e18 => format!("a whole number, {high} at most"),
        (Value::Text(text), _) if text.trim().parse::<f64>().is_ok() => {
            "a whole number, without quotation marks".to_owned()
        }
        _ => "a whole number".to_owned(),
    }
}

macro_rules! whole {
    ($($method:ident, $visit:ident, $type:ty;)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
            match self.whole().and_then(|whole| <$type>::try_from(whole).ok()) {
                Some(whole) => visitor.$visit(whole),
                None => {
                    let ends = [i128::from(<$type>::MIN), i128::from(<$type>::MAX)];
                    Err(wrong(self, &whole_number(self, ends)))
                }
            }
        }
    )*};
}

impl<'de> Deserializer<'de> for &'de Value {
    type Error = Wrong;

    whole! {
        deserialize_i8, visit_i8, i8;
        deserialize_i16, visit_i16, i16;
        deserialize_i32, visit_i32, i32;
        deserialize_i64, visit_i64, i64;
        deserialize_u8, visit_u8, u8;
        deserialize_u16, visit_u16, u16;
        deserialize_u32, visit_u32, u32;
        deserialize_u64, visit_u64, u64;
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        match self {
            Value::Null => visitor.visit_unit(),
            Value::Bool(value) => visitor.visit_bool(*value),
            Value::Int(value) => visitor.visit_i64(*value),
            Value::Large(value) => visitor.visit_u64(*value),
            Value::Float(value) => visitor.visit_f64(*value),
            Value::Text(text) => visitor.visit_borrowed_str(text),
            Value::List(_) => self.deserialize_seq(visitor),
            Value::Map(_) => self.deserialize_map(visitor),
        }
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        match self {
            Value::Bool(value) => visitor.visit_bool(*value),
            Value::Text(text) if ["true", "false"].contains(&&**text) => {
                Err(wrong(self, "true or false, without quotation marks"))
            }
            _ => Err(wrong(self, "true or false")),
        }
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        match self.number() {
            Some(value) if value.is_finite() && (value as f32).is_infinite() => {
                Err(wrong(self, "a number from -3.4e38 to 3.4e38"))
            }
            Some(value) => visitor.visit_f64(value),
            None => Err(wrong(self, "a number")),
        }
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        match self.number() {
            Some(value) => visitor.visit_f64(value),
            None => match self
                .text()
                .is_some_and(|own| own.trim().parse::<f64>().is_ok())
            {
                true => Err(wrong(self, "a number, without quotation marks")),
                false => Err(wrong(self, "a number")),
            },
        }
    }

    fn deserialize_char<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        self.deserialize_str(visitor)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        match self {
            Value::Text(text) => visitor.visit_borrowed_str(text),
            _ => Err(wrong(self, TEXT)),
        }
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        self.deserialize_str(visitor)
    }

    fn deserialize_bytes<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Wrong> {
        Err(wrong(self, "bytes, which no such document holds"))
    }

    fn deserialize_byte_buf<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        self.deserialize_bytes(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        match self {
            Value::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        match self {
            Value::Null => visitor.visit_unit(),
            _ => Err(wrong(self, "nothing")),
        }
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        self.deserialize_unit(visitor)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        let values = self.list().ok_or_else(|| wrong(self, LIST))?;
        visitor.visit_seq(&mut List { values, next: 0 })
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        match self.list() {
            Some(values) if values.len() != length => Err(count(values.len(), length)),
            Some(_) => self.deserialize_seq(visitor),
            None => Err(wrong(self, &format!("a list of {length} values"))),
        }
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        match self {
            Value::Map(entries) => visitor.visit_map(Map { entries, next: 0 }),
            _ => Err(wrong(self, SECTION)),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        if let Value::Map(entries) = self {
            let unknown = entries.iter().find(|(key, _)| !fields.contains(&&**key));
            if let Some((key, _)) = unknown {
                return Err(Wrong::unknown_field(key, fields));
            }
        }
        self.deserialize_map(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        let (name, content) = match self {
            Value::Text(name) => (&**name, None),
            Value::Map(entries) if entries.len() == 1 => (&*entries[0].0, Some(&entries[0].1)),
            _ => return Err(wrong(self, &format!("one of {}", variants.join(", ")))),
        };
        visitor.visit_enum(Variant { name, content })
    }

    fn deserialize_identifier<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        self.deserialize_str(visitor)
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        visitor.visit_unit()
    }
}

fn count(found: usize, expected: usize) -> Wrong {
    Wrong::found(format_args!("{found} values"), expected)
}

struct List<'de> {
    values: &'de [Value],
    next: usize,
}

impl<'de> SeqAccess<'de> for &mut List<'de> {
    type Error = Wrong;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Wrong> {
        let Some(value) = self.values.get(self.next) else {
            return Ok(None);
        };
        let made = seed.deserialize(value).map_err(|e| e.at(self.next))?;
        self.next += 1;
        Ok(Some(made))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.values.len() - self.next)
    }
}

struct Map<'de> {
    entries: &'de [(Box<str>, Value)],
    next: usize,
}

impl<'de> MapAccess<'de> for Map<'de> {
    type Error = Wrong;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Wrong> {
        let Some((key, _)) = self.entries.get(self.next) else {
            return Ok(None);
        };
        let key: StrDeserializer<'_, Wrong> = (**key).into_deserializer();
        seed.deserialize(key).map(Some)
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, Wrong> {
        let (key, value) = &self.entries[self.next];
        self.next += 1;
        seed.deserialize(value).map_err(|e| e.under(key))
    }
}

struct Variant<'de> {
    name: &'de str,
    content: Option<&'de Value>,
}

impl<'de> EnumAccess<'de> for Variant<'de> {
    type Error = Wrong;
    type Variant = Content<'de>;

    fn variant_seed<T: DeserializeSeed<'de>>(
        self,
        seed: T,
    ) -> Result<(T::Value, Content<'de>), Wrong> {
        let name: StrDeserializer<'_, Wrong> = self.name.into_deserializer();
        let content = Content {
            name: self.name,
            content: self.content,
        };
        Ok((seed.deserialize(name)?, content))
    }
}

/// Content beside a variant's name.
struct Content<'de> {
    name: &'de str,
    content: Option<&'de Value>,
}

impl<'de> Content<'de> {
    fn some(&self) -> Result<&'de Value, Wrong> {
        let missing = || Wrong::new("its values are missing").under(self.name);
        self.content.ok_or_else(missing)
    }
}

impl<'de> VariantAccess<'de> for Content<'de> {
    type Error = Wrong;

    fn unit_variant(self) -> Result<(), Wrong> {
        match self.content {
            None | Some(Value::Null) => Ok(()),
            Some(value) => Err(wrong(value, "the name alone").under(self.name)),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Wrong> {
        let value = self.some()?;
        seed.deserialize(value).map_err(|e| e.under(self.name))
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Wrong> {
        let made = self.some()?.deserialize_tuple(length, visitor);
        made.map_err(|e| e.under(self.name))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        let made = self.some()?.deserialize_struct("", fields, visitor);
        made.map_err(|e| e.under(self.name))
    }
}
