//! A rotation as four named numbers.

use std::fmt;

use serde::Deserialize;
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};

/// A rotation; its length is 1.
#[derive(Clone, Copy)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub(crate) struct QuaternionKeys {
    pub(crate) w: f64,
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct QuaternionParts {
    w: f64,
    x: f64,
    y: f64,
    z: f64,
}

/// A table of w, x, y, z. A list is refused, since both orders of its numbers are in use.
impl<'de> Deserialize<'de> for QuaternionKeys {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct QuaternionVisitor;
        impl<'de> Visitor<'de> for QuaternionVisitor {
            type Value = QuaternionKeys;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a table, as in { w = 1, x = 0, y = 0, z = 0 }")
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<QuaternionKeys, A::Error> {
                let parts = QuaternionParts::deserialize(de::value::MapAccessDeserializer::new(map))?;
                let QuaternionParts { w, x, y, z } = parts;
                Ok(QuaternionKeys { w, x, y, z })
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<QuaternionKeys, A::Error> {
                let mut list: Vec<f64> = Vec::new();
                while let Some(number) = seq.next_element()? {
                    list.push(number);
                }
                let [a, b, c, d] = list[..] else { return Err(de::Error::invalid_length(list.len(), &self)) };
                let [last, first] =
                    [QuaternionKeys { x: a, y: b, z: c, w: d }, QuaternionKeys { w: a, x: b, y: c, z: d }];
                let what = "found a list, whose order is not known: if it is x, y, z, w, write";
                Err(de::Error::custom(format!("{what} {last}; if it is w, x, y, z, write {first}")))
            }
        }
        deserializer.deserialize_any(QuaternionVisitor)
    }
}

impl fmt::Display for QuaternionKeys {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let QuaternionKeys { w, x, y, z } = self;
        write!(f, "{{ w = {w}, x = {x}, y = {y}, z = {z} }}")
    }
}
