//! Values of keys that several tables of a file share: lists of a fixed length, lattices, boxes, rotations, units, and what
//! a user may write in more than one way.

mod axis;
mod cuboid;
mod quaternion;
#[cfg(test)]
mod schema;
mod unit;

use serde::Deserialize;
use serde::de::{self, Deserializer, SeqAccess, Visitor};

pub(crate) use axis::{AxisValues, MAX_NUMBERS, numbers};
pub(crate) use cuboid::BoxFile;
pub(crate) use quaternion::QuaternionKeys;
pub(crate) use unit::{Unit, UpFile};

/// `0.7` or `[0.2, 2.0]`: horizontal and vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OneOrTwo {
    pub(crate) horizontal: f64,
    pub(crate) vertical: Option<f64>,
}

/// `"walk"` or `2`: which of several things in a file, by its name or by its number, counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum NameOrNumber {
    Name(String),
    Number(usize),
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
pub(crate) fn exactly<'de, D, T, const N: usize>(deserializer: D) -> Result<[T; N], D::Error>
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
pub(crate) fn exactly_if_given<'de, D, T, const N: usize>(deserializer: D) -> Result<Option<[T; N]>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    exactly(deserializer).map(Some)
}
