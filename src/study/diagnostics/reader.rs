//! Reads TOML values into typed structures. Its errors are values: the kind of error, the keys that lead to it and the
//! known words, from which callers find the line and suggest a near word. Dates are read as text.

use std::iter::Enumerate;

use serde::de::{
    self, DeserializeOwned, DeserializeSeed, Deserializer, Expected, IntoDeserializer, MapAccess, SeqAccess,
    Unexpected, Visitor,
};
use toml::{Table, Value};

use super::unreadable::{Step, Unreadable, one_of};

/// Reads a value.
pub(crate) fn read<T: DeserializeOwned>(value: impl Into<Value>) -> Result<T, Unreadable> {
    T::deserialize(Reader(value.into()))
}

struct Reader(Value);

impl Reader {
    /// Reads a table only. What serde generates for a structure also reads it from a list, key by key, which no file
    /// means.
    fn table<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        match self.0 {
            Value::Table(table) => visitor.visit_map(Entries { rest: table.into_iter(), open: None }),
            other => Err(wrong_type(&other, &visitor)),
        }
    }

    /// Reads a list only.
    fn list<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        let list = match self.0 {
            Value::Array(list) => list,
            other => return Err(wrong_type(&other, &visitor)),
        };
        let length = list.len();
        let mut rest = list.into_iter().enumerate();
        let found = visitor.visit_seq(List { rest: &mut rest })?;
        // A list of so many entries is filled from the front.
        match rest.next() {
            None => Ok(found),
            Some(_) => Err(de::Error::invalid_length(length, &"fewer")),
        }
    }
}

fn wrong_type(value: &Value, wanted: &dyn Expected) -> Unreadable {
    let found = match value {
        Value::String(text) => Unexpected::Str(text),
        Value::Integer(number) => Unexpected::Signed(*number),
        Value::Float(number) => Unexpected::Float(*number),
        Value::Boolean(is) => Unexpected::Bool(*is),
        Value::Datetime(_) => Unexpected::Other("a date"),
        Value::Array(_) => Unexpected::Seq,
        Value::Table(_) => Unexpected::Map,
    };
    de::Error::invalid_type(found, wanted)
}

impl<'de> Deserializer<'de> for Reader {
    type Error = Unreadable;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        match self.0 {
            Value::String(text) => visitor.visit_string(text),
            Value::Integer(number) => visitor.visit_i64(number),
            Value::Float(number) => visitor.visit_f64(number),
            Value::Boolean(is) => visitor.visit_bool(is),
            Value::Datetime(date) => visitor.visit_string(date.to_string()),
            Value::Array(_) => self.list(visitor),
            Value::Table(_) => self.table(visitor),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        self.table(visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        self.table(visitor)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        self.list(visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Unreadable> {
        self.list(visitor)
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
        words: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        match self.0 {
            Value::String(word) => visitor.visit_enum(word.into_deserializer()),
            // No word has keys of its own.
            other => Err(wrong_type(&other, &one_of(words).as_str())),
        }
    }

    serde::forward_to_deserialize_any! {
        bool u8 u16 u32 u64 i8 i16 i32 i64 f32 f64 char str string bytes byte_buf unit ignored_any
        unit_struct tuple_struct identifier
    }
}

/// The entries of a list, one after the other.
struct List<'a> {
    rest: &'a mut Enumerate<<Vec<Value> as IntoIterator>::IntoIter>,
}

impl<'de> SeqAccess<'de> for List<'_> {
    type Error = Unreadable;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Unreadable> {
        let Some((number, value)) = self.rest.next() else { return Ok(None) };
        seed.deserialize(Reader(value)).map(Some).map_err(|error| error.prefix(Step::Entry(number)))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
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
        seed.deserialize(Reader(value)).map_err(|error| error.prefix(Step::Key(key)))
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::super::unreadable::Unread;
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
        assert_eq!(error.to_string(), "found 3 entries, wanted fewer in `inner.pair`");
    }

    #[test]
    fn structures_are_read_from_tables_and_words_from_strings_only() {
        for (text, expected) in [
            ("inner = [[1, 2]]", "found a list, wanted a table in `inner`"),
            ("inner = [[]]", "found a list, wanted a table in `inner`"),
            ("inner = {}", "found a table, wanted a list in `inner`"),
            ("inner = [{ size = 1, pair = {} }]", "found a table, wanted a list of length 2 in `inner.pair`"),
            (
                "inner = [{ kind = {} }]",
                "found a table, wanted one of `round`, `square`, `flat` in `inner.kind`",
            ),
            (
                "inner = [{ kind = { flat = {} } }]",
                "found a table, wanted one of `round`, `square`, `flat` in `inner.kind`",
            ),
            ("inner = 1979-05-27", "found a date, wanted a list in `inner`"),
        ] {
            assert_eq!(read::<Outer>(table(text)).unwrap_err().to_string(), expected, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_in_words_of_files_and_as_a_value() {
        const KEYS: &[&str] = &["size", "count", "kind", "pair"];
        const WORDS: &[&str] = &["round", "square", "flat"];
        let (key, entry) = (|key: &str| Step::Key(key.into()), Step::Entry);
        let inner = |steps: &[Step]| [&[key("inner"), entry(0)], steps].concat();
        for (text, kind, steps, message) in [
            ("", Unread::Missing("inner"), vec![], "missing field `inner`"),
            ("inner = [{}]", Unread::Missing("size"), inner(&[]), "missing field `size`"),
            (
                "inner = [{ sise = 1 }]",
                Unread::UnknownKey("sise".into(), KEYS),
                inner(&[]),
                "unknown field `sise`, expected one of `size`, `count`, `kind`, `pair`",
            ),
            (
                "other = 1",
                Unread::UnknownKey("other".into(), &["inner"]),
                vec![],
                "unknown field `other`, expected `inner`",
            ),
            (
                "inner = [{ kind = \"flta\" }]",
                Unread::UnknownWord("flta".into(), WORDS),
                inner(&[key("kind")]),
                "unknown variant `flta`, expected one of `round`, `square`, `flat`",
            ),
            (
                "inner = [{ size = \"1\" }]",
                Unread::Value,
                inner(&[key("size")]),
                "found \"1\", wanted a number",
            ),
            (
                "inner = [{ size = true }]",
                Unread::Value,
                inner(&[key("size")]),
                "found true, wanted a number",
            ),
            (
                "inner = [{ size = 1 }, { size = 1, count = -1 }]",
                Unread::Value,
                vec![key("inner"), entry(1), key("count")],
                "found -1, wanted a whole number from 0 to 4294967295",
            ),
            (
                "inner = [{ size = 1, count = 2.0 }]",
                Unread::Value,
                inner(&[key("count")]),
                "found 2.0, wanted a whole number from 0 to 4294967295",
            ),
            (
                "inner = [{ kind = 1 }]",
                Unread::Value,
                inner(&[key("kind")]),
                "found 1, wanted one of `round`, `square`, `flat`",
            ),
            (
                "inner = [{ pair = [1] }]",
                Unread::Value,
                inner(&[key("pair")]),
                "found 1 entry, wanted a list of length 2",
            ),
            (
                "inner = [{ pair = [1, \"\"] }]",
                Unread::Value,
                inner(&[key("pair"), entry(1)]),
                "found \"\", wanted a number",
            ),
        ] {
            let error = read::<Outer>(table(text)).unwrap_err();
            assert_eq!((&error.kind, &error.steps), (&kind, &steps), "{text}");
            assert_eq!(error.message, message, "{text}");
        }
    }
}
