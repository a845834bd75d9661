//! Values that a user may write in more than one way: a number or a pair, a number, a list or a lattice.

#[cfg(test)]
mod schema;

use std::fmt;

use serde::Deserialize;
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};

use super::poses::Quaternion;

/// `1.5`, `[1.5, 2.0]` or `{ start = -2.2, stop = 2.3, step = 0.5 }`.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Axis {
    List(Vec<f64>),
    Steps { start: f64, stop: f64, step: f64 },
}

/// `0.7` or `[0.2, 2.0]`: horizontal and vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OneOrTwo {
    pub(super) horizontal: f64,
    pub(super) vertical: Option<f64>,
}

/// `"walk"` or `2`: which of several things in a file, by its name or by its number, counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NameOrNumber {
    Name(String),
    Number(usize),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Steps {
    start: f64,
    stop: f64,
    step: f64,
}

impl<'de> Deserialize<'de> for Axis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AxisVisitor;
        impl<'de> Visitor<'de> for AxisVisitor {
            type Value = Axis;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number, a list of numbers, or { start, stop, step }")
            }
            fn visit_f64<E>(self, value: f64) -> Result<Axis, E> {
                Ok(Axis::List(vec![value]))
            }
            fn visit_i64<E>(self, value: i64) -> Result<Axis, E> {
                Ok(Axis::List(vec![value as f64]))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Axis, A::Error> {
                let mut list = Vec::new();
                while let Some(value) = seq.next_element()? {
                    list.push(value);
                }
                Ok(Axis::List(list))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Axis, A::Error> {
                let Steps { start, stop, step } =
                    Steps::deserialize(de::value::MapAccessDeserializer::new(map))?;
                Ok(Axis::Steps { start, stop, step })
            }
        }
        deserializer.deserialize_any(AxisVisitor)
    }
}

impl<'de> Deserialize<'de> for OneOrTwo {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PairVisitor;
        impl<'de> Visitor<'de> for PairVisitor {
            type Value = OneOrTwo;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number, or [horizontal, vertical]")
            }
            fn visit_f64<E>(self, value: f64) -> Result<OneOrTwo, E> {
                Ok(OneOrTwo { horizontal: value, vertical: None })
            }
            fn visit_i64<E: de::Error>(self, value: i64) -> Result<OneOrTwo, E> {
                self.visit_f64(value as f64)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<OneOrTwo, A::Error> {
                let missing = |n| de::Error::invalid_length(n, &self);
                let horizontal = seq.next_element()?.ok_or_else(|| missing(0))?;
                let vertical = Some(seq.next_element()?.ok_or_else(|| missing(1))?);
                if seq.next_element::<f64>()?.is_some() {
                    return Err(missing(3));
                }
                Ok(OneOrTwo { horizontal, vertical })
            }
        }
        deserializer.deserialize_any(PairVisitor)
    }
}

impl<'de> Deserialize<'de> for NameOrNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameVisitor;
        impl Visitor<'_> for NameVisitor {
            type Value = NameOrNumber;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a name, or a number counted from 0")
            }
            fn visit_str<E>(self, name: &str) -> Result<NameOrNumber, E> {
                Ok(NameOrNumber::Name(name.into()))
            }
            fn visit_i64<E: de::Error>(self, number: i64) -> Result<NameOrNumber, E> {
                let wrong = |_| E::invalid_value(de::Unexpected::Signed(number), &self);
                usize::try_from(number).map(NameOrNumber::Number).map_err(wrong)
            }
        }
        deserializer.deserialize_any(NameVisitor)
    }
}

/// A list of exactly N values. TOML's reader fills an array from the front and would pass over what is left.
pub(super) fn exactly<'de, D, T, const N: usize>(deserializer: D) -> Result<[T; N], D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    let values = Vec::<T>::deserialize(deserializer)?;
    let count = values.len();
    let wrong = |_| de::Error::invalid_length(count, &format!("a list of {N} numbers").as_str());
    values.try_into().map_err(wrong)
}

/// [`exactly`], for a key that may be left out.
pub(super) fn exactly_if_given<'de, D, T, const N: usize>(deserializer: D) -> Result<Option<[T; N]>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    exactly(deserializer).map(Some)
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
impl<'de> Deserialize<'de> for Quaternion {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct QuaternionVisitor;
        impl<'de> Visitor<'de> for QuaternionVisitor {
            type Value = Quaternion;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a table, as in { w = 1, x = 0, y = 0, z = 0 }")
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Quaternion, A::Error> {
                let parts = QuaternionParts::deserialize(de::value::MapAccessDeserializer::new(map))?;
                let QuaternionParts { w, x, y, z } = parts;
                Ok(Quaternion { w, x, y, z })
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Quaternion, A::Error> {
                let mut list: Vec<f64> = Vec::new();
                while let Some(number) = seq.next_element()? {
                    list.push(number);
                }
                let [a, b, c, d] = list[..] else { return Err(de::Error::invalid_length(list.len(), &self)) };
                let [last, first] =
                    [Quaternion { x: a, y: b, z: c, w: d }, Quaternion { w: a, x: b, y: c, z: d }];
                let what = "found a list, whose order is not known: if it is x, y, z, w, write";
                Err(de::Error::custom(format!("{what} {last}; if it is w, x, y, z, write {first}")))
            }
        }
        deserializer.deserialize_any(QuaternionVisitor)
    }
}

impl fmt::Display for Quaternion {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Quaternion { w, x, y, z } = self;
        write!(f, "{{ w = {w}, x = {x}, y = {y}, z = {z} }}")
    }
}

/// The unit of a file: `"mm"`, or metres in one of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit(pub(super) f64);

const UNITS: [(&str, f64); 4] = [("m", 1.0), ("cm", 0.01), ("mm", 1e-3), ("in", 0.0254)];

impl<'de> Deserialize<'de> for Unit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct UnitVisitor;
        impl Visitor<'_> for UnitVisitor {
            type Value = Unit;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("\"m\", \"cm\", \"mm\", \"in\", or metres in one of it, from 0.000001 to 1000000")
            }
            fn visit_str<E: de::Error>(self, word: &str) -> Result<Unit, E> {
                let known = UNITS.iter().find(|(name, _)| *name == word);
                known
                    .map(|(_, metres)| Unit(*metres))
                    .ok_or_else(|| E::unknown_variant(word, &["m", "cm", "mm", "in"]))
            }
            fn visit_f64<E: de::Error>(self, metres: f64) -> Result<Unit, E> {
                match (1e-6..=1e6).contains(&metres) {
                    true => Ok(Unit(metres)),
                    false => Err(E::invalid_value(de::Unexpected::Float(metres), &self)),
                }
            }
            fn visit_i64<E: de::Error>(self, metres: i64) -> Result<Unit, E> {
                self.visit_f64(metres as f64)
            }
        }
        deserializer.deserialize_any(UnitVisitor)
    }
}

/// Which axis of a file points up.
#[derive(Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub(super) enum UpFile {
    Y,
    Z,
}
