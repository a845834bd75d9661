//! Reads TOML values into typed structures, with errors that say their kind and the keys that lead to them.

use std::fmt::{self, Display};

use serde::de::value::SeqDeserializer;
use serde::de::{
    self, DeserializeOwned, DeserializeSeed, Deserializer, IntoDeserializer, MapAccess, Visitor,
};
use toml::{Table, Value};

/// Why a value cannot be read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Unreadable {
    pub(super) kind: Unread,
    /// In words, without the keys.
    pub(super) message: String,
    /// The keys that lead to it, the outermost first.
    pub(super) keys: Vec<String>,
}

/// What is wrong with a value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Unread {
    /// A table lacks this key.
    Missing(&'static str),
    /// A table has a key that is none of these.
    UnknownKey(String, &'static [&'static str]),
    /// A word is none of these.
    UnknownWord(String, &'static [&'static str]),
    /// It is of another type, or out of range.
    Value,
}

/// Reads a value.
pub(super) fn read<T: DeserializeOwned>(value: impl Into<Value>) -> Result<T, Unreadable> {
    T::deserialize(Reader(value.into()))
}

impl Unreadable {
    fn of(kind: Unread, said: Unreadable) -> Self {
        Unreadable { kind, ..said }
    }
}

impl Display for Unreadable {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.message)?;
        if self.keys.is_empty() { Ok(()) } else { write!(f, " in `{}`", self.keys.join(".")) }
    }
}

impl std::error::Error for Unreadable {}

impl de::Error for Unreadable {
    fn custom<M: Display>(message: M) -> Self {
        Unreadable { kind: Unread::Value, message: message.to_string(), keys: Vec::new() }
    }

    fn missing_field(field: &'static str) -> Self {
        Unreadable::of(Unread::Missing(field), Unreadable::custom(format_args!("missing field `{field}`")))
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        let said = format!("unknown field `{field}`, {}", one_of(expected));
        Unreadable::of(Unread::UnknownKey(field.into(), expected), Unreadable::custom(said))
    }

    fn unknown_variant(word: &str, expected: &'static [&'static str]) -> Self {
        let said = format!("unknown variant `{word}`, {}", one_of(expected));
        Unreadable::of(Unread::UnknownWord(word.into(), expected), Unreadable::custom(said))
    }
}

/// The list as serde words it.
fn one_of(expected: &[&str]) -> String {
    match expected {
        [] => "there are none".into(),
        [one] => format!("expected `{one}`"),
        [one, other] => format!("expected `{one}` or `{other}`"),
        all => format!("expected one of `{}`", all.join("`, `")),
    }
}

struct Reader(Value);

impl<'de> Deserializer<'de> for Reader {
    type Error = Unreadable;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        match self.0 {
            Value::String(text) => visitor.visit_string(text),
            Value::Integer(number) => visitor.visit_i64(number),
            Value::Float(number) => visitor.visit_f64(number),
            Value::Boolean(is) => visitor.visit_bool(is),
            Value::Datetime(date) => visitor.visit_string(date.to_string()),
            Value::Array(list) => {
                let length = list.len();
                let mut entries = SeqDeserializer::new(list.into_iter().map(Reader));
                let found = visitor.visit_seq(&mut entries)?;
                // A list of so many entries is filled from the front.
                let more = |_: Unreadable| de::Error::invalid_length(length, &"fewer elements in array");
                entries.end().map_err(more).map(|()| found)
            }
            Value::Table(table) => visitor.visit_map(Entries { rest: table.into_iter(), open: None }),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        match self.0 {
            Value::String(word) => visitor.visit_enum(word.into_deserializer()),
            _ => Err(de::Error::custom("wanted string or table")),
        }
    }

    serde::forward_to_deserialize_any! {
        bool u8 u16 u32 u64 i8 i16 i32 i64 f32 f64 char str string seq bytes byte_buf map unit struct
        ignored_any unit_struct tuple_struct tuple identifier
    }
}

impl IntoDeserializer<'_, Unreadable> for Reader {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

/// The entries of a table, one after the other.
struct Entries {
    rest: <Table as IntoIterator>::IntoIter,
    open: Option<(String, Value)>,
}

impl<'de> MapAccess<'de> for Entries {
    type Error = Unreadable;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Unreadable> {
        self.open = self.rest.next();
        let key = self.open.as_ref().map(|(key, _)| key.clone().into_deserializer());
        key.map(|key: de::value::StringDeserializer<Unreadable>| seed.deserialize(key)).transpose()
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Unreadable> {
        let (key, value) = self.open.take().ok_or_else(|| de::Error::custom("a value before its key"))?;
        seed.deserialize(Reader(value)).map_err(|mut error| {
            error.keys.insert(0, key);
            error
        })
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Outer {
        inner: Vec<Inner>,
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Inner {
        size: f64,
        count: Option<u32>,
        kind: Option<Word>,
        pair: Option<[f64; 2]>,
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(rename_all = "lowercase")]
    enum Word {
        Round,
        Square,
        Flat,
    }

    fn table(text: &str) -> Table {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn what_is_right_is_read_as_the_crate_reads_it() {
        for text in ["inner = [{ size = 1 }, { size = 1.5, count = 2, kind = \"flat\" }]", "inner = []"] {
            assert_eq!(read::<Outer>(table(text)).unwrap(), table(text).try_into().unwrap(), "{text}");
        }
    }

    /// From the front of the text the crate would fill the list, and pass over the rest.
    #[test]
    fn a_list_that_is_too_long_is_told() {
        let error = read::<Outer>(table("inner = [{ size = 1, pair = [1, 2, 3] }]")).unwrap_err();
        assert_eq!(error.to_string(), "invalid length 3, expected fewer elements in array in `inner.pair`");
    }

    #[test]
    fn what_is_wrong_is_told_in_the_words_of_the_crate_and_as_a_value() {
        const KEYS: &[&str] = &["size", "count", "kind", "pair"];
        const WORDS: &[&str] = &["round", "square", "flat"];
        for (text, kind, keys) in [
            ("", Unread::Missing("inner"), &[][..]),
            ("inner = [{}]", Unread::Missing("size"), &["inner"]),
            ("inner = [{ sise = 1 }]", Unread::UnknownKey("sise".into(), KEYS), &["inner"]),
            ("other = 1", Unread::UnknownKey("other".into(), &["inner"]), &[]),
            ("inner = [{ kind = \"flta\" }]", Unread::UnknownWord("flta".into(), WORDS), &["inner", "kind"]),
            ("inner = [{ size = \"1\" }]", Unread::Value, &["inner", "size"]),
            ("inner = [{ size = 1, count = -1 }]", Unread::Value, &["inner", "count"]),
            ("inner = [{ kind = 1 }]", Unread::Value, &["inner", "kind"]),
            ("inner = [{ pair = [1] }]", Unread::Value, &["inner", "pair"]),
        ] {
            let error = read::<Outer>(table(text)).unwrap_err();
            assert_eq!(
                (&error.kind, &error.keys[..]),
                (&kind, &keys.iter().map(|key| key.to_string()).collect::<Vec<_>>()[..]),
                "{text}"
            );
            assert_eq!(error.message, toml::from_str::<Outer>(text).unwrap_err().message(), "{text}");
        }
    }
}
